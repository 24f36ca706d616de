// Pairs the images of two streams whose stamps are close: image and depth, or reference and current. Knows no topic.
#pragma once

#include <cstddef>
#include <deque>
#include <vector>

#include <sensor_msgs/Image.h>

namespace gms_ransac {

/// The cameras of a stereo pair are triggered together; what the camera does in more time than this passes for
/// disparity.
constexpr double kStereoTolerance = 0.003;  // seconds

struct ImagePair {
  sensor_msgs::ImageConstPtr first;
  sensor_msgs::ImageConstPtr second;  ///< null: there is none
};

struct PairingOptions {
  double tolerance = 0.025;  ///< greatest difference of the stamps, seconds
  double patience = 1;       ///< seconds of the caller's clock that an image of the first stream waits for the second's
  size_t capacity = 10;      ///< images of either stream that wait
};

/// Every image of the first stream comes out once, in the order it came in: with the nearest of the second stream, or
/// alone once none can be expected any more. message_filters' ApproximateTime keeps an image without a partner to
/// itself, and throws where stamps are 68 years apart.
class ImagePairing {
 public:
  explicit ImagePairing(const PairingOptions& options) : options_(options) {}

  /// `now`: seconds of a clock that never goes back.
  void addFirst(const sensor_msgs::ImageConstPtr& image, double now);
  void addSecond(const sensor_msgs::ImageConstPtr& image);
  /// Returns the settled images, each once.
  std::vector<ImagePair> settled(double now);
  /// Time alone will decide something: ask settled() again, whether or not anything comes.
  bool pending() const { return !first_.empty(); }
  /// Forgets all that waits.
  void clear();

 private:
  struct Waiting {
    sensor_msgs::ImageConstPtr image;
    double since;
  };

  /// The one in the second stream for the oldest of the first, or the end.
  std::deque<sensor_msgs::ImageConstPtr>::iterator nearest();
  /// True if the second stream has passed the oldest image of the first: no later partner can be nearer.
  bool passed() const;
  /// The oldest of the first stream need wait no longer.
  bool overdue(double now) const;

  const PairingOptions options_;
  std::deque<Waiting> first_;
  std::deque<sensor_msgs::ImageConstPtr> second_;
};

}  // namespace gms_ransac
