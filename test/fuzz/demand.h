// How a fuzz target reports a violated condition.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>

namespace gms_ransac {

/// Ends the process, which is what a fuzzer takes for a find, unless `broken` is empty.
inline void demandEmpty(const std::string& broken) {
  if (broken.empty()) return;
  std::fprintf(stderr, "invariant broken: %s\n", broken.c_str());
  std::abort();
}

inline void demand(bool holds, const std::string& what) { demandEmpty(holds ? std::string() : "not so: " + what); }

}  // namespace gms_ransac
