#include "methods/method.h"

#include <stdexcept>
#include <utility>

#include "methods/rolling_shutter.h"

namespace gms_ransac {

const std::vector<MethodEntry>& methods() {
  static const std::vector<MethodEntry> table = {kRansac,    kRransacTdd, kProsac,   kSubsetRansac,
                                                 kSplit2080, kGms,        kGmsFive,  kGmsDistanceRansac,
                                                 kLan,       kGmsRansac,  kCpRansac, kLoProsac};
  return table;
}

std::string methodsText() {
  std::string text;
  for (const MethodEntry& method : methods()) {
    text += std::string(method.name) + "\n    " + method.source + ": " + method.summary + "\n";
  }
  return text;
}

const MethodEntry& findMethod(const std::string& name) {
  std::string known;
  for (const MethodEntry& method : methods()) {
    if (name == method.name) return method;
    known += (known.empty() ? "" : ", ") + std::string(method.name);
  }
  throw std::invalid_argument("unknown method '" + name + "'; known are " + known);
}

std::unique_ptr<Method> makeMethod(const MatchFilterOptions& options) {
  options.validate();
  std::unique_ptr<Method> method = findMethod(options.method).make(options);
  if (options.robust.rolling_shutter_readout == 0) return method;
  return std::make_unique<RollingShutter>(std::move(method), options.robust);
}

}  // namespace gms_ransac
