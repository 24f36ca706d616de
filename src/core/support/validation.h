// How option structs refuse a value: one sentence with the name, the value and the range.
#pragma once

#include <sstream>
#include <stdexcept>

namespace gms_ransac {

/// Throws std::invalid_argument unless low <= value <= high (so NaN is refused too).
template <typename Value, typename Bound>
void requireInRange(const char* field, Value value, Bound low, Bound high) {
  if (value >= low && value <= high) return;
  std::ostringstream sentence;
  sentence << field << " is " << value << "; it must be between " << low << " and " << high;
  throw std::invalid_argument(sentence.str());
}

}  // namespace gms_ransac
