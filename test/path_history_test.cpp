// What ~path keeps of a journey: its ends, evenly spread poses between them, and never more than fit.
#include "output/path_history.h"

#include <gtest/gtest.h>

namespace gms_ransac {
namespace {

geometry_msgs::PoseStamped at(double x) {
  geometry_msgs::PoseStamped pose;
  pose.pose.position.x = x;
  return pose;
}

TEST(PathHistory, KeepsEveryPoseWhileThereIsRoom) {
  PathHistory path(8);
  for (int i = 0; i < 8; ++i) {
    path.add(at(i));
    ASSERT_EQ(path.poses().size(), static_cast<size_t>(i + 1));
    EXPECT_EQ(path.poses()[i].pose.position.x, i);
  }
}

TEST(PathHistory, IsBoundedAndEvenlySpreadAfterwards) {
  PathHistory path(8);
  for (int i = 0; i < 1000; ++i) {
    path.add(at(i));
    const auto& poses = path.poses();
    ASSERT_LE(poses.size(), 8u);
    EXPECT_EQ(poses.front().pose.position.x, 0);
    EXPECT_EQ(poses.back().pose.position.x, i);
    if (i < 8) continue;
    ASSERT_GE(poses.size(), 5u) << i;
    const double step = poses[1].pose.position.x - poses[0].pose.position.x;
    for (size_t k = 1; k + 1 < poses.size(); ++k) {
      EXPECT_EQ(poses[k].pose.position.x - poses[k - 1].pose.position.x, step) << i;
    }
  }
}

TEST(PathHistory, BeginsAnew) {
  PathHistory path(4);
  for (int i = 0; i < 100; ++i) path.add(at(i));
  path.clear();
  EXPECT_TRUE(path.poses().empty());
  path.add(at(7));
  path.add(at(8));
  ASSERT_EQ(path.poses().size(), 2u);
  EXPECT_EQ(path.poses()[0].pose.position.x, 7);
}

}  // namespace
}  // namespace gms_ransac
