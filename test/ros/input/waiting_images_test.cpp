// Images that wait for what belongs to them: in order, each once, nothing taken twice or kept for ever.
#include "input/waiting_images.h"

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <boost/make_shared.hpp>

namespace gms_ransac {
namespace {

template <typename Message>
boost::shared_ptr<Message> stamped(double stamp) {
  auto message = boost::make_shared<Message>();
  message->header.stamp = ros::Time(stamp);
  return message;
}

/// An event and its result. An event is a letter and a time in hundredths of a second. The time is the stamp
/// of an (i)mage, one of the (s)econd stream, (c)amera_info or a (m)ask; the length of a (w)ait; or how far the
/// (S)ensors reach. (r) is the camera_info of the right camera, (x) forgets. An image that comes out is its stamp, "+"
/// with that of its partner, "i" and "r" with the camera_info of each camera, and "m" with the stamp of its mask; "?"
/// if some wait.
struct Step {
  const char *events, *out;
};

std::string play(const std::string& events, const WaitingOptions& options, double& now, double& reached,
                 WaitingImages& images) {
  std::string out;
  const auto text = [](const sensor_msgs::ImageConstPtr& image) {
    return std::to_string(std::lround(100 * image->header.stamp.toSec()));
  };
  std::istringstream words(events);
  for (std::string word; words >> word;) {
    const double time = word.size() > 1 ? std::stod(word.substr(1)) / 100 : 0;
    if (word[0] == 'i') images.add(stamped<sensor_msgs::Image>(time), ros::Time(1), now);
    if (word[0] == 's') images.addSecond(stamped<sensor_msgs::Image>(time));
    if (word[0] == 'c') images.addCameraInfo(stamped<sensor_msgs::CameraInfo>(time));
    if (word[0] == 'r') images.setRightInfo(boost::make_shared<sensor_msgs::CameraInfo>());
    if (word[0] == 'm') images.addMask(stamped<sensor_msgs::Image>(time));
    if (word[0] == 'w') now += time;
    if (word[0] == 'S') reached = time;
    if (word[0] == 'x') images.clear();
    for (const ImageWithInfo& input : images.settled(now)) {
      const sensor_msgs::ImageConstPtr partner = options.second != nullptr ? input.*options.second : nullptr;
      out += text(input.image) + (partner ? "+" + text(partner) : "") + (input.camera_info ? "i" : "") +
             (input.right_info ? "r" : "") + (input.mask ? "m" + text(input.mask) : "") + " ";
    }
  }
  out += images.pending() ? "?" : "";
  return out.substr(0, out.find_last_not_of(' ') + 1);
}

TEST(WaitingImages, ComeOutWithWhatBelongsToThem) {
  double reached = 0;
  WaitingOptions nothing, info, both_infos, info_of_each, mask, sensors, depth, depth_and_sensors, pair;
  info.for_camera_info = both_infos.for_camera_info = both_infos.for_right_info = true;
  info_of_each.info_of_each = mask.for_mask = true;
  sensors.sensors_reach = [&](const std_msgs::Header& image) { return image.stamp.toSec() <= reached; };
  depth.second = &ImageWithInfo::depth;
  pair.first = &ImageWithInfo::reference;
  pair.second = &ImageWithInfo::image;
  for (WaitingOptions* few : {&info, &both_infos, &info_of_each, &mask, &sensors}) few->capacity = 3;
  WaitingOptions few_depths = depth;
  few_depths.capacity = 3;
  depth_and_sensors = few_depths;
  depth_and_sensors.sensors_reach = sensors.sensors_reach;

  const struct {
    const char* what;
    const WaitingOptions& options;
    std::vector<Step> steps;
    int matched = 0, unpaired = 0;
    bool gave_up = false;
  } rows[] = {
      {"at once with the newest",
       nothing,
       {{"i100", "100"}, {"c0 i200", "200i"}, {"m0 i200 i300", "200im0 300im0"}, {"m100 m250 i400", "400im250"}}},
      {"the first of a stereo pair wait for both cameras", both_infos, {{"i100 c0 i200", "?"}, {"r", "100ir 200ir"}}},
      {"... once", both_infos, {{"c0 i100 w100", "100i"}, {"i200", "200i"}}, 0, 0, true},
      {"the first wait for camera_info", info, {{"i100 i200 w90", "?"}, {"c0", "100i 200i"}, {"i300", "300i"}}},
      {"in vain but once, and take it when it comes after all",
       info,
       {{"i100 w50 i200 w40", "?"}, {"w10", "100 200"}, {"i300", "300"}, {"c0 i400", "400i"}},
       0,
       0,
       true},
      {"none waits when too many do", info, {{"i100 i200 i300", "?"}, {"i400", "100 200 300 400"}}, 0, 0, true},
      {"forgotten on request", info, {{"i100 x c0", ""}}},
      {"with the camera_info of their stamp, or dropped: one lost, one late, too many, overtaken, a new start",
       info_of_each,
       {{"c100 i100 i200", "100i ?"},
        {"i300", "?"},
        {"c300", "300i"},
        {"i400 w100", ""},
        {"i500 i600 i700 i800 c800", "800i"},
        {"i750 c750", "750i"},
        {"i100 c100", "100i"}},
       5,
       5},
      {"with the mask of their stamp, whichever came first",
       mask,
       {{"i100 i200", "?"}, {"m100", "100m100 ?"}, {"m200 m300", "200m200"}, {"i300", "300m300"}}},
      {"not for a mask that was skipped", mask, {{"i100 i200 m200", "100 200m200"}}},
      {"not long, nor too many",
       mask,
       {{"i100 w50 i200 w50", "100 ?"}, {"i300 i400 i500", "200 ?"}, {"m500", "300 400 500m500"}}},
      {"again where the stamps go back",
       mask,
       {{"i900 m900", "900m900"}, {"m100 i100 i200", "100m100 ?"}, {"m200", "200m200"}}},
      {"for sensors, but not long, and what follows one in vain not at all until they are late no more",
       sensors,
       {{"i100 w10", "?"},
        {"S100", "100"},
        {"i200 w10 i300 w15", "200 300 ?"},
        {"w100 i400", "400 ?"},
        {"S400 w10 i500", "?"},
        {"S500 w10", "500"}}},
      {"for sensors without piling up", sensors, {{"S0 i100 i200 i300", "?"}, {"i400", "100 200 300 400 ?"}}},
      {"for depth, whichever comes first",
       depth,
       {{"i100", "?"}, {"s101", "100+101"}, {"s103", ""}, {"i103", "103+103"}},
       2},
      {"with the nearest, but not one that is nearer to the next image",
       depth,
       {{"i100 s98", "?"}, {"s101", "100+101"}, {"i200 i203 s202", "200 203+202"}},
       2},
      {"alone once the others have passed", depth, {{"i100 i103 i107 s107", "100 103 107+107"}}, 1},
      {"alone after a while, and what comes too late is not taken",
       depth,
       {{"i100 w90", "?"}, {"i103 w20", "100 ?"}, {"w90", "103"}, {"s100 s103 i107 s107", "107+107"}},
       1},
      {"alone once too many wait",
       few_depths,
       {{"i100 i110 i120", "?"}, {"i130", "100 ?"}, {"s120", "110 120+120 ?"}, {"s200", "130"}},
       1},
      {"a partner once found is kept, though others come from a faster camera",
       depth_and_sensors,
       {{"S0 i100 s100 i103 s103 s104 s105 s106 s107 s108", "?"}, {"S200", "100+100 103+103"}},
       2},
      {"half of a pair is dropped", pair, {{"i197 i200 s201", "201+201"}}, 1},
      {"slow partners cost the others nothing",
       depth,
       {{"s100 i100 i103 i106 s109 i109 i112 i115 s118 i118 i121 i124", "100+100 103 106 109+109 112 115 118+118 ?"},
        {"w100", "121 124"}},
       3},
      {"streams that start again, either first",
       depth,
       {{"i6000 s6000 s6003 i6006", "6000+6000 ?"},
        {"i100", "6006 ?"},
        {"s100", "100+100"},
        {"i103 s103", "103+103"},
        {"s50 i50", "50+50"}},
       4},
      {"stamps further apart than a duration holds",
       depth,
       {{"i0 s420000000000 i420000000000 s0 w100", "0+0 420000000000"}},
       1}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.what);
    WaitingImages images(row.options);
    double now = 0;
    for (const Step& step : row.steps) {
      EXPECT_EQ(play(step.events, row.options, now, reached, images), step.out) << step.events;
    }
    EXPECT_EQ(images.matched(), row.matched);
    EXPECT_EQ(images.unpaired(), row.unpaired);
    EXPECT_EQ(images.gaveUpCameraInfo(), row.gave_up);
  }
}

TEST(WaitingImages, ComeOutEachOnceAndInOrder) {
  uint32_t random = 1;
  const auto chance = [&](int percent) {
    random = random * 1664525u + 1013904223u;
    return static_cast<int>((random >> 16) % 100) < percent;
  };
  WaitingOptions options;
  options.second = &ImageWithInfo::depth;
  WaitingImages images(options);
  std::vector<ros::Time> sent, received;
  const auto collect = [&](double now) {
    for (const ImageWithInfo& input : images.settled(now)) {
      received.push_back(input.image->header.stamp);
      if (!input.depth) continue;
      EXPECT_LE(std::abs((received.back() - input.depth->header.stamp).toSec()), 0.025);
    }
  };
  for (int i = 0; i < 3000; ++i) {
    const double stamp = 1 + i / 30.0;
    if (chance(90)) {
      sent.emplace_back(stamp);
      images.add(stamped<sensor_msgs::Image>(stamp), ros::Time(), stamp);
    }
    if (chance(70)) images.addSecond(stamped<sensor_msgs::Image>(stamp + (chance(50) ? 0.01 : -0.01)));
    collect(stamp);
  }
  collect(1e6);
  EXPECT_EQ(received, sent);
}

}  // namespace
}  // namespace gms_ransac
