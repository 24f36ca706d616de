// When the search of one pair ends although it might find better.
#pragma once

#include <functional>

namespace gms_ransac {

/// Seconds from any origin, never falling.
using Clock = std::function<double()>;

struct TimeLimit {
  Clock now;
  double search_until = 0;  ///< no further sample is drawn from then on
  double hurry_from = 0;    ///< what follows the search is cut short when it begins after that

  bool late() const { return now() >= hurry_from; }
};

}  // namespace gms_ransac
