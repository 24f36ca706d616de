#include "former_names.h"

#include "gms_ransac/feature_extractor.h"
#include "gms_ransac/method.h"

namespace gms_ransac {

namespace {

/// A parameter whose words were renamed, and what says how.
struct Renamed {
  const char* parameter;
  std::string MatchFilterConfig::*value;
  std::string (*current)(const std::string& name);
};
const Renamed kRenamed[] = {{"method", &MatchFilterConfig::method, &currentMethodName},
                            {"extractor", &MatchFilterConfig::extractor, &currentExtractorName}};

std::string sentence(const std::string& parameter, const std::string& former, const std::string& current) {
  return "parameter " + parameter + " is '" + former + "', which is now called '" + current +
         "'; the old name still works";
}

}  // namespace

std::vector<std::string> replaceFormerNames(const ros::NodeHandle& pnh) {
  std::vector<std::string> sentences;
  for (const Renamed& renamed : kRenamed) {
    std::string given;
    if (!pnh.getParam(renamed.parameter, given)) continue;
    const std::string current = renamed.current(given);
    if (current == given) continue;
    pnh.setParam(renamed.parameter, current);
    sentences.push_back(sentence(pnh.resolveName(renamed.parameter), given, current));
  }
  return sentences;
}

std::vector<std::string> replaceFormerNames(MatchFilterConfig& config) {
  std::vector<std::string> sentences;
  for (const Renamed& renamed : kRenamed) {
    std::string& value = config.*renamed.value;
    const std::string current = renamed.current(value);
    if (current == value) continue;
    sentences.push_back(sentence(std::string("~") + renamed.parameter, value, current));
    value = current;
  }
  return sentences;
}

}  // namespace gms_ransac
