// The table of methods. A new method is a file beside this one and a line in the list.
#pragma once

#include <memory>

#include "gms_ransac/match_filter.h"
#include "gms_ransac/method.h"

/// Every method's entry, in the order in which they are listed to users.
// clang-format off
#define GMS_RANSAC_METHODS(entry) \
  entry(kRansac)                 \
  entry(kRransacTdd)             \
  entry(kProsac)                 \
  entry(kSubsetRansac)           \
  entry(kSplit2080)              \
  entry(kGms)                    \
  entry(kGmsFive)                \
  entry(kGmsDistanceRansac)      \
  entry(kLan)                    \
  entry(kGmsRansac)              \
  entry(kCpRansac)               \
  entry(kLoProsac)
// clang-format on

namespace gms_ransac {

#define DECLARE_ENTRY(name) extern const MethodEntry name;
GMS_RANSAC_METHODS(DECLARE_ENTRY)
#undef DECLARE_ENTRY

/// What an entry's `make` is.
template <class SomeMethod>
std::unique_ptr<Method> make(const MatchFilterOptions& options) {
  return std::make_unique<SomeMethod>(options);
}

}  // namespace gms_ransac
