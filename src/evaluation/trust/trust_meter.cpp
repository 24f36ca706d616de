#include "trust/trust_meter.h"

#include <algorithm>
#include <memory>

#include <Eigen/Core>

#include "run/experiment.h"
#include "scenes/drawn_scenes.h"

namespace gms_ransac {

namespace {

Reliability reliabilityOf(const Answer& answer, const TruthNoise& noise, const ClockStep& step) {
  Reliability reliability;
  if (answer.result.robust.probability.empty()) return reliability;  // without a model nothing was weighed
  const MatchLabel label(answer.truth, answer.camera, noise, step);
  for (size_t i = 0; i < answer.result.matches.size(); ++i) {
    if (answer.result.stage[i] == MatchStage::kRaw) continue;
    const Match& match = answer.result.matches[i];
    const std::optional<bool> right = label(answer.reference.keypoints[static_cast<size_t>(match.reference)].pt,
                                            answer.current.keypoints[static_cast<size_t>(match.current)].pt);
    if (right) reliability.add(static_cast<double>(answer.result.probability[i]), *right);
  }
  return reliability;
}

TrustRow rowOf(const Answer& answer, const std::string& set, const TruthNoise& noise, const ClockStep& step) {
  TrustContext context;
  context.kind = noise.exact() ? "rendered" : "real";
  context.set = set;
  context.gap = answer.context.gap;
  context.pair = answer.context.reference + ' ' + answer.context.current;
  context.method = answer.context.method;
  context.status = answer.result.status;
  context.survivors = answer.result.matches_gms;
  PoseTruth truth;
  truth.noise = noise;
  truth.clock_step = step;
  if (noise.exact()) truth.limits = kExactLimits;
  const bool known = answer.truth.currentInReference().has_value();
  if (known) truth.pose = *answer.truth.currentInReference();
  return makeTrustRow(context, answer.result.robust, known ? &truth : nullptr, reliabilityOf(answer, noise, step));
}

std::vector<TrustRow> measureSet(const TrustPlan& plan, const TrustUnit& unit) {
  const TrustSet& set = plan.sets[static_cast<size_t>(unit.set)];
  const Dataset dataset = Dataset::open(set.path, plan.dataset);
  const std::vector<DatasetPair> pairs = dataset.pairs(std::max(1, unit.gap), plan.stride);
  std::vector<Contender> contenders;
  for (const MatchFilterOptions& pipeline : plan.pipelines) contenders.push_back({pipeline, 0});
  Experiment experiment(dataset, contenders, unit.gap);
  std::vector<TrustRow> rows;
  for (int i = unit.first; i < unit.first + unit.count; ++i) {
    const DatasetPair& pair = pairs[static_cast<size_t>(i)];
    const ClockStep step = clockStep(dataset, pair, set.noise.clock);
    experiment.run(pair, [&](const Answer& answer) { rows.push_back(rowOf(answer, dataset.name(), set.noise, step)); });
  }
  return rows;
}

/// Whether the points of a drawn match are within kCorrectWithin of one another's true places.
bool isRight(const TwoViewScene& scene, size_t match) {
  const PointPairs& pairs = scene.pairs;
  const Eigen::Vector2d reference(pairs.x_reference[match], pairs.y_reference[match]);
  const Eigen::Vector2d current(pairs.x_current[match], pairs.y_current[match]);
  return (current - reference - scene.displacements[match]).norm() < kCorrectWithin;
}

Reliability reliabilityOf(const TwoViewScene& scene, const RobustResult& result) {
  Reliability reliability;
  for (size_t i = 0; i < result.probability.size(); ++i) {
    reliability.add(static_cast<double>(result.probability[i]), isRight(scene, i));
  }
  return reliability;
}

std::vector<TrustRow> measureScene(const TrustPlan& plan, const TrustUnit& unit) {
  const std::string& name = plan.scenes[static_cast<size_t>(unit.scene)];
  const std::vector<DrawnScene>& all = drawnScenes();
  const auto drawn = std::find_if(all.begin(), all.end(), [&](const DrawnScene& scene) { return scene.name == name; });
  std::vector<std::unique_ptr<Method>> methods;
  for (const MatchFilterOptions& pipeline : plan.pipelines) methods.push_back(makeMethod(pipeline));
  RobustResult result;
  std::vector<TrustRow> rows;
  for (int i = unit.first; i < unit.first + unit.count; ++i) {
    const TwoViewScene scene = drawPair(*drawn, i);
    PoseTruth truth;
    truth.limits = kExactLimits;
    truth.pose.linear() = scene.R.transpose();
    truth.pose.translation() = -scene.R.transpose() * scene.t;
    for (size_t m = 0; m < methods.size(); ++m) {
      methods[m]->reset();  // each pair is of another world
      methods[m]->estimate(scene.pairs, scene.camera, result);
      TrustContext context;
      context.kind = "drawn";
      context.set = name;
      context.pair = std::to_string(i);
      context.method = plan.pipelines[m].method;
      context.status = statusOf(result, scene.camera);
      context.survivors = scene.pairs.size();
      rows.push_back(makeTrustRow(context, result, &truth, reliabilityOf(scene, result)));
    }
  }
  return rows;
}

}  // namespace

std::vector<TrustRow> measureTrust(const TrustPlan& plan, const TrustUnit& unit) {
  return unit.set >= 0 ? measureSet(plan, unit) : measureScene(plan, unit);
}

}  // namespace gms_ransac
