#include "stream/step.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "guard.h"
#include "text.h"

namespace gms_ransac {

namespace {

// Share of the reference's keypoints that must be inliers for it to be kept. Successive images of a handheld camera
// have 0.4 to 0.7 (TUM freiburg1, 2000 keypoints), so the view has shifted by about half when it falls below.
constexpr double kWellSeen = 0.2;
// The next image is expected within this many times the interval between the last two.
constexpr double kLateImage = 2;
// After a loss image after image is compared with every kept one, which may show another place: that many tries leave
// more to chance than one pair of neighbours does. Among 5000 pairs of images of different places (four real sets,
// three rendered rooms) 83 pass for the same place, with 17 inliers at most.
constexpr int kSureInliers = 30;

/// The answer to one image in the making.
struct Step : Comparison {
  Recovery& recovery;

  /// Without keypoints nothing can be compared with the image.
  bool useless() const {
    return answer.status == MatchStats::TOO_FEW_KEYPOINTS && current->frame.features.size() < kMinimumMatches;
  }
  bool tooLateFor(const PreparedFrame& reference) const {
    return current->stamp() - reference.stamp() - stream.copied_seconds > pipeline.options.max_frame_gap;
  }
  bool comparable(const PreparedFrame& reference) const {
    return current->frame.features.descriptors.comparableWith(reference.frame.features.descriptors);
  }
  /// The time between the images of the pair is known, and short enough for one velocity.
  bool velocityKnown() const {
    if (!answer.pair || current->pair_reference) return true;
    return current->image.stamp_verdict != StampVerdict::kAfterLate &&
           current->stamp() - answer.pair->reference->stamp() <= pipeline.options.max_frame_gap;
  }
  void answerImage();
  void answerPair();

  struct Start {
    uint8_t status;
    Continuity continuity;
    Why why;
    std::string before = std::string();  ///< detail of `why`
  };
  /// Why the image cannot be compared with the reference, if so.
  std::optional<Start> newStart() const;
  void begin(const Start& start);
  bool holdReference() const;
  /// The current image becomes the reference.
  void advance();

  // After a loss, with ~recovery_frames.
  enum class WayBack {
    kNone,    ///< the image is to be answered as without a loss
    kNotYet,  ///< the answer is that there is none
    kFound
  };
  /// A pair with a kept stream.
  struct Attempt {
    size_t index;
    std::shared_ptr<ComparedPair> pair;
    bool shows_the_same = false;
  };
  /// Camera and options allow to look for the way back in this image.
  bool mayGoBack() const;
  bool isOfOneCamera(const PreparedFrame& reference) const;
  WayBack goBack();
  WayBack compareWithKept();
  Attempt tryKept(size_t index);
  /// The first of them that shows the same.
  std::optional<Attempt> find(const std::vector<size_t>& indices);
  /// The stream goes on from the kept one.
  void resumeFrom(const Attempt& found);
  /// The place of the reference is known, that of the images to come is not.
  void lose();
  /// The reference is kept before the current image takes its place.
  void keepReference();
};

void Step::answerImage() {
  if (goBack() != WayBack::kNone) return;
  if (const std::optional<Start> start = newStart()) return begin(*start);
  compare();
  // It would make the next one fail too; the one before it is the better reference.
  if (useless()) {
    if (!mayGoBack()) return;
    lose();
    recovery.miss();
    return;
  }
  answer.reference_held = holdReference();
  if (answer.reference_held) return;
  keepReference();
  advance();
}

void Step::answerPair() {
  const bool resets = current->image.reset != Reset::kNone;
  if (resets) answer.continuity = Continuity::kRestarted;
  stream.forget();
  stream.past = Past();
  stream.reference = current->pair_reference;
  const cv::Size before = stream.reference->frame.features.image_size;
  if (before != current->frame.features.image_size) {
    answer.status = MatchStats::BAD_IMAGE;
    return because(Why::kSizesDiffer, sizeText(before));
  }
  if (resets) because(Why::kReset);
  compare();
}

std::optional<Step::Start> Step::newStart() const {
  constexpr uint8_t kFirst = MatchStats::FIRST_FRAME, kTime = MatchStats::TIME_RESET;
  constexpr Continuity kRestarted = Continuity::kRestarted, kBroken = Continuity::kBroken;
  const StampVerdict verdict = current->image.stamp_verdict;
  if (current->image.reset != Reset::kNone) return Start{kFirst, kRestarted, Why::kReset};
  if (verdict == StampVerdict::kClockReset) return Start{kTime, kRestarted, Why::kClockBack};
  if (verdict == StampVerdict::kJumpedBack) return Start{kTime, kRestarted, Why::kStampsBack};
  if (verdict == StampVerdict::kSteppedBack) {
    return Start{kTime, kBroken, Why::kStampsBack,
                 " by less than ~max_frame_gap: the clock that sets them was set back"};
  }
  if (verdict == StampVerdict::kGap) return Start{kTime, kBroken, Why::kGap};
  if (!stream.reference && stream.stamp) return Start{kTime, kBroken, Why::kNoneKept};
  if (!stream.reference) return Start{kFirst, Continuity::kContinuous, Why::kFirst};
  const std::string& frame_before = stream.reference->image.header.frame_id;
  if (current->image.header.frame_id != frame_before) return Start{kFirst, kBroken, Why::kFrameChanged, frame_before};
  if (current->frame.features.image_size != stream.reference->frame.features.image_size)
    return Start{kFirst, kBroken, Why::kSizeChanged, sizeText(stream.reference->frame.features.image_size)};
  if (!comparable(*stream.reference)) {
    return Start{kFirst, kBroken, Why::kDescriptorsChanged, stream.reference->frame.features.descriptors.kind()};
  }
  if (tooLateFor(*stream.reference)) return Start{kTime, kBroken, Why::kReferenceOld};
  return std::nullopt;
}

void Step::begin(const Start& start) {
  answer.status = start.status;
  answer.continuity = start.continuity;
  because(start.why, start.before);
  if (start.continuity != Continuity::kContinuous) because(Why::kNewReference);
  stream.forget();
  const bool other_camera = start.why == Why::kFrameChanged;
  if (start.continuity == Continuity::kRestarted) stream.forgetSensor();
  if (start.continuity == Continuity::kRestarted || other_camera) stream.past = Past();
  if (other_camera) stream.place.restart();
  recovery.clear();
  stream.reference = current;
}

bool Step::holdReference() const {
  if (answer.status != MatchStats::LOW_PARALLAX || !pipeline.options.hold_reference) return false;
  // Standing still for long, the reference would grow too old to be compared with the next image.
  const double interval = current->stamp() - stream.stamp.value_or(0),
               age = current->stamp() - stream.reference->stamp();
  if (age + kLateImage * interval > pipeline.options.max_frame_gap) return false;
  // Turning on, the reference would leave the view before there is parallax; so only while it is well seen.
  const MatchResult& result = answer.pair->result;
  return result.inliers >= kWellSeen * result.keypoints_reference;
}

void Step::advance() {
  stream.tracks.advance();
  if (answer.poseValid()) {
    stream.scale.advance();
  } else {
    stream.scale.reset();
  }
  if (answer.since_key) {
    stream.key.advance();
  } else {
    stream.key = KeyFrame();
  }
  stream.reference = current;
  stream.copied_seconds = 0;
}

bool Step::mayGoBack() const {
  return pipeline.options.recovery.frames > 0 && current->image.camera->camera.calibrated() &&
         current->image.reset == Reset::kNone && current->image.stamp_verdict <= StampVerdict::kGap;
}

bool Step::isOfOneCamera(const PreparedFrame& reference) const {
  return current->image.header.frame_id == reference.image.header.frame_id &&
         current->frame.features.image_size == reference.frame.features.image_size && comparable(reference);
}

Step::WayBack Step::goBack() {
  if (pipeline.options.recovery.frames == 0) recovery.clear();
  if (!mayGoBack()) return WayBack::kNone;
  const bool late = current->image.stamp_verdict == StampVerdict::kGap;
  if (stream.reference && (late || tooLateFor(*stream.reference))) lose();
  recovery.giveUp(current->stamp(), pipeline.options.recovery);
  if (!recovery.lost()) return WayBack::kNone;
  const std::shared_ptr<PreparedFrame> newest = recovery.kept().front().reference;
  if (!isOfOneCamera(*newest)) return WayBack::kNone;

  WayBack way = WayBack::kNotYet;
  guarded([&] { way = compareWithKept(); }, [&](const std::string& what) { fail(newest, what); });
  if (way == WayBack::kNone || useless()) return way;
  if (way == WayBack::kFound) keepReference();
  advance();
  if (way == WayBack::kNotYet) stream.tracks.reset();
  return way;
}

Step::WayBack Step::compareWithKept() {
  std::vector<size_t> others = recovery.next();
  const Attempt newest = tryKept(others.front());
  others.erase(others.begin());
  if (newest.shows_the_same) {
    resumeFrom(newest);
    return WayBack::kFound;
  }
  // An image that has too few keypoints for one of them has for all.
  const bool hopeless = newest.pair->result.status == Status::kTooFewKeypoints;
  if (const std::optional<Attempt> found = hopeless ? std::nullopt : find(others)) {
    resumeFrom(*found);
    return WayBack::kFound;
  }
  recovery.miss();
  if (stream.reference) return WayBack::kNone;
  stream.tracks.reset();
  conclude(newest.pair);
  answer.reasons.push_back({Why::kKept, {}, static_cast<int>(recovery.kept().size())});
  return WayBack::kNotYet;
}

Step::Attempt Step::tryKept(size_t index) {
  Attempt tried = {index, attempt(recovery.kept()[index].reference)};
  MatchResult& result = tried.pair->result;
  if (result.status != Status::kOk && result.status != Status::kLowParallax) return tried;
  tried.shows_the_same = result.inliers >= kSureInliers;
  if (!tried.shows_the_same) result.reject();
  return tried;
}

std::optional<Step::Attempt> Step::find(const std::vector<size_t>& indices) {
  for (const size_t index : indices) {
    Attempt tried = tryKept(index);
    if (tried.shows_the_same) return tried;
    if (tried.pair->result.status == Status::kTooFewKeypoints) break;
  }
  return std::nullopt;
}

void Step::resumeFrom(const Attempt& found) {
  const int missed = recovery.missed();
  Stream kept = recovery.resume(found.index);
  kept.tracks.numberFrom(stream.tracks);
  stream = std::move(kept);
  stream.breakChain();      // the motion of that time
  stream.key = KeyFrame();  // of a pair that is not in the place
  stream.reference = found.pair->reference;
  answer.recovered = true;
  conclude(found.pair);
  answer.recovered = answer.poseValid();  // the gate is the last that may refuse it
  answer.reasons.insert(answer.reasons.begin(), {Why::kGoesOn, {}, missed});
}

void Step::lose() {
  if (!recovery.lost()) {
    recovery.keep(stream, pipeline.options.recovery);
    recovery.lose();
  }
  stream.forget();
}

void Step::keepReference() {
  if (!mayGoBack()) return;
  // Blurred images often agree on a little; what is published of such a pair need not be what comes next starts from.
  const MatchResult& result = answer.pair->result;
  const bool sure = answer.poseValid() && result.inliers >= kSureInliers && 2 * result.inliers >= result.size();
  if (recovery.lost()) return recovery.addPair(sure);
  recovery.keep(stream, pipeline.options.recovery);
  if (sure || answer.recovered) return;
  recovery.lose();
  recovery.miss();
}

}  // namespace

ProcessedFrame step(Pipeline& pipeline, Stream& stream, Recovery& recovery, PairPool& pairs,
                    const std::shared_ptr<PreparedFrame>& current) {
  recovery.dropPixels(stream.reference.get());
  pairs.releaseFrames();
  Step image{{pipeline, stream, pairs, current}, recovery};
  image.answer.current = current;
  if (current->pair_reference) {
    image.answerPair();
  } else {
    image.answerImage();
  }
  stream.stamp = current->stamp();
  image.answer.times.detect = current->frame.detect_seconds;
  image.answer.velocity_known = image.velocityKnown();
  integrate(pipeline.parameters, stream.place, image.answer);
  if (!current->mask_problem.empty()) image.because(Why::kNoMask, current->mask_problem);
  image.answer.doubt = current->doubt;
  const auto saysIt = [&](const Reason& reason) { return reason.detail == image.answer.doubt; };
  const bool is_said = std::any_of(image.answer.reasons.begin(), image.answer.reasons.end(), saysIt);
  if (!image.answer.doubt.empty() && !is_said) image.because(Why::kDoubt, image.answer.doubt);
  return std::move(image.answer);
}

}  // namespace gms_ransac
