// Words that a sentence must contain.
#pragma once

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace gms_ransac {

/// True if the text has all the parts. No parts: it has to be empty.
inline testing::AssertionResult says(const std::string& text, const std::vector<std::string>& parts) {
  if (parts.empty() && !text.empty()) return testing::AssertionFailure() << text;
  for (const std::string& part : parts) {
    if (text.find(part) == std::string::npos) return testing::AssertionFailure() << "no '" << part << "' in: " << text;
  }
  return testing::AssertionSuccess();
}

}  // namespace gms_ransac
