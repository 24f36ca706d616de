// The same sentence once in a while, different ones side by side, and what a neighbour can make of it: no endless log
// and no endless memory.
#include "throttle.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <ros/console.h>

namespace gms_ransac {
namespace {

/// Collects what is logged. Registered for good: some versions of log4cxx crash when an appender is taken away.
class Log : public ros::console::LogAppender {
 public:
  Log() { ros::console::register_appender(this); }
  void log(ros::console::Level /*level*/, const char* text, const char* /*file*/, const char* /*function*/,
           int /*line*/) override {
    lines.emplace_back(text);
  }
  std::vector<std::string> lines;
};

Log& emptyLog() {
  static Log* const log = new Log();
  log->lines.clear();
  return *log;
}

TEST(Throttle, SaysTheSameOnceAndOthersBeside) {
  Log& log = emptyLog();
  Throttle throttle("", 1000);
  for (int i = 0; i < 3; ++i) {
    throttle.warn("dark", "too dark");
    throttle.info("bright", "too bright");
    throttle.warnOnce("first", "first");
  }
  EXPECT_EQ(log.lines, (std::vector<std::string>{"too dark", "too bright", "first"}));
}

TEST(Throttle, OneReasonDoesNotHideAnother) {
  Log& log = emptyLog();
  Throttle throttle("", 1000);
  for (const int width : {640, 641}) {
    throttle.warn("image", "not used: " + std::to_string(width) + " columns");
    throttle.warn("image", "not used: late");
  }
  EXPECT_EQ(log.lines, (std::vector<std::string>{"not used: 640 columns", "not used: late"}));
}

TEST(Throttle, SaysItAgainAfterAWhile) {
  Log& log = emptyLog();
  Throttle throttle("", 0);
  for (int i = 0; i < 3; ++i) {
    throttle.warn("dark", "too dark");
    throttle.warnOnce("first", "first");
  }
  EXPECT_EQ(log.lines.size(), 4u);
}

TEST(Throttle, SentencesThatAreAllDifferentAreBounded) {
  Log& log = emptyLog();
  Throttle throttle("", 1000);
  for (int i = 0; i < 100000; ++i) {
    const std::string sentence = "fx is " + std::to_string(i);
    throttle.warn(sentence, sentence);
  }
  EXPECT_EQ(log.lines.size(), Throttle::kSentences);
  EXPECT_EQ(throttle.remembered(), Throttle::kSentences);
}

TEST(Throttle, RoomIsMadeByWhatMayBeSaidAgain) {
  Log& log = emptyLog();
  Throttle throttle("", 0);
  for (int i = 0; i < 1000; ++i) throttle.warn(std::to_string(i), "varies");
  EXPECT_EQ(log.lines.size(), 1000u);
  EXPECT_LE(throttle.remembered(), Throttle::kSentences);
}

TEST(Throttle, KeepsWhatIsSaidOnce) {
  Log& log = emptyLog();
  Throttle throttle("", 0);
  throttle.warnOnce("once", "once");
  for (int i = 0; i < 1000; ++i) throttle.warn(std::to_string(i), "often");
  throttle.warnOnce("once", "once");
  EXPECT_EQ(std::count(log.lines.begin(), log.lines.end(), "once"), 1);
}

}  // namespace
}  // namespace gms_ransac
