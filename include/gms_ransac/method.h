// The one table of methods: each is a named choice for every stage (doc: design of the paper's comparison).
#pragma once

#include <string>
#include <vector>

namespace gms_ransac {

enum class MatcherChoice { kNearest, kMutual };
enum class FilterChoice {
  kNone,
  kGms,          ///< Bian 2017: 20 x 20 cells, threshold factor 6
  kGmsFive,      ///< Chen 2018: five cells vote instead of nine
  kGmsDistance,  ///< Zhu 2019: then matches whose displacement differs from their neighbours' are dropped
  kGmsAdaptive   ///< ours: square cells, votes weighed with descriptors, turn and change of level
};
enum class OrderingChoice { kNone, kDescriptorDistance, kMotionStatistics };
enum class SamplerChoice { kUniform, kProsac, kRandomSubsets, kSplit, kConfidenceGroups, kStratified };
enum class VerifierChoice { kAll, kTdd, kHoldOut, kBlockwise };
enum class RecheckChoice { kNone, kGms };

/// One row: the stages a method is composed of.
struct Method {
  const char* name;
  const char* source;   ///< paper
  const char* summary;  ///< our reading of it, one line
  MatcherChoice matcher;
  FilterChoice filter;
  OrderingChoice ordering;
  SamplerChoice sampler;
  VerifierChoice verifier;
  RecheckChoice recheck;     ///< after the robust estimation
  bool keeps_filter_output;  ///< the model gives only the pose; inliers are what the filter kept (`gms`, `gms5`)
};

const std::vector<Method>& methods();

/// Throws std::invalid_argument listing the known names.
const Method& findMethod(const std::string& name);

enum class ModelType { kEssential, kFundamental, kHomography };

/// "essential", "fundamental", "homography"; throws std::invalid_argument for another word.
ModelType parseModelType(const std::string& name);
std::string toString(ModelType model);

}  // namespace gms_ransac
