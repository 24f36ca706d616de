// A gms_ransac/Keypoints message as matrices, without a copy, or as the core's Features. Header-only, without ROS
// headers.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "gms_ransac/features.h"

namespace gms_ransac {

/// Reads the columns of a message in place: the message must outlive the view. Usage: `const KeypointsView
/// view(*message); cv::Mat descriptors = view.descriptors();`
template <typename Message>
class KeypointsView {
 public:
  using Column = Eigen::Map<const Eigen::VectorXf>;

  /// Columns that a message does not have are empty: octaves are 0 then, angles -1, the others 0. Throws
  /// std::invalid_argument naming the first column or keypoint that cannot be.
  explicit KeypointsView(const Message& message) : message_(message) {
    const size_t n = message.u.size();
    require("v", message.v.size(), n);
    requireIfAny("octave", message.octave, n);
    requireIfAny("size", message.size, n);
    requireIfAny("angle", message.angle, n);
    requireIfAny("response", message.response, n);
    requireIfAny("sigma", message.sigma, n);
    requireIfAny("track_id", message.track_id, n);
    requireIfAny("depth", message.depth, n);
    requireDescriptors();
    if (std::max(message.width, message.height) > Features::kLargestSide)
      refuse("the image is larger than " + std::to_string(Features::kLargestSide) + " pixels a side");
    if (!(message.scale_factor > 1) || !std::isfinite(message.scale_factor)) refuse("scale_factor is not above 1");
    for (size_t i = 0; i < n; ++i) {
      if (!isInImage(message.u[i], static_cast<int>(message.width)) ||
          !isInImage(message.v[i], static_cast<int>(message.height))) {
        refuse("keypoint " + std::to_string(i) + " lies outside the image");
      }
      if (!message.octave.empty() && message.octave[i] >= Features::kOctaves) {
        refuse("keypoint " + std::to_string(i) + " has no possible octave");
      }
      if (!message.angle.empty() && !isAngle(message.angle[i])) {
        refuse("keypoint " + std::to_string(i) + " has no angle within 360 degrees; -1 is unknown");
      }
    }
  }
  explicit KeypointsView(Message&&) = delete;  // the view would outlive it

  int size() const { return static_cast<int>(message_.u.size()); }
  /// N values each; what they are: msg/Keypoints.msg.
  Column u() const { return {message_.u.data(), size()}; }
  Column v() const { return {message_.v.data(), size()}; }
  /// Empty if the message has none.
  Column sigma() const { return {message_.sigma.data(), static_cast<Eigen::Index>(message_.sigma.size())}; }
  bool hasDepth() const { return !message_.depth.empty(); }
  /// Metres along the optical axis, 0: not known. Only with hasDepth().
  Column depth() const { return {message_.depth.data(), hasDepth() ? size() : 0}; }
  bool hasFloats() const { return message_.descriptor_type == Message::DESCRIPTOR_FLOAT32; }
  /// N x K CV_8U, K bytes each, or N x D CV_32F.
  cv::Mat descriptors() const {
    const int bytes = size() == 0 ? kDescriptorBytes : static_cast<int>(message_.descriptor_size);
    const int columns = hasFloats() ? bytes / kFloatBytes : bytes;
    return cv::Mat(size(), columns, hasFloats() ? CV_32F : CV_8U, const_cast<uint8_t*>(message_.descriptors.data()));
  }
  cv::KeyPoint keypoint(int i) const {
    const auto k = static_cast<size_t>(i);
    return {message_.u[k],
            message_.v[k],
            entry(message_.size, k, 0.f),
            wrappedAngle(entry(message_.angle, k, -1.f)),
            entry(message_.response, k, 0.f),
            entry(message_.octave, k, 0),
            static_cast<int>(entry(message_.track_id, k, 0))};
  }
  /// A copy for MatchFilter, MotionStatisticsFilter and, with descriptors of 32 bytes, HammingMatcher, packed. Throws
  /// std::invalid_argument for floats that are not finite. Needs gms_ransac_core.
  Features features() const {
    Features features;
    features.image_size = {static_cast<int>(message_.width), static_cast<int>(message_.height)};
    features.scale_factor = message_.scale_factor;
    for (int i = 0; i < size(); ++i) features.keypoints.push_back(keypoint(i));
    features.descriptors.assign(descriptors());
    return features;
  }

  bool isRectified() const { return message_.pixel_space == Message::PIXELS_RECTIFIED; }
  bool calibrated() const { return message_.K[0] > 0 && message_.K[4] > 0; }
  Eigen::Matrix3d K() const { return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&message_.K[0]); }

 private:
  static constexpr int kFloatBytes = 4;
  static constexpr uint32_t kLargestDescriptor = 65536;  ///< bytes

  [[noreturn]] static void refuse(const std::string& what) { throw std::invalid_argument("Keypoints: " + what); }
  static void require(const char* column, size_t length, size_t expected) {
    if (length == expected) return;
    refuse(std::string(column) + " has " + std::to_string(length) + " entries, but " + std::to_string(expected) +
           " belong to this many keypoints (u)");
  }
  template <typename Values>
  static void requireIfAny(const char* column, const Values& values, size_t expected) {
    if (!values.empty()) require(column, values.size(), expected);
  }
  template <typename Values, typename Value>
  static Value entry(const Values& values, size_t k, Value none) {
    return values.empty() ? none : static_cast<Value>(values[k]);
  }
  void requireDescriptors() const {
    const size_t n = message_.u.size(), bytes = message_.descriptor_size;
    if (message_.descriptor_type > Message::DESCRIPTOR_FLOAT32) {
      refuse("descriptor_type is " + std::to_string(message_.descriptor_type) +
             "; it must be DESCRIPTOR_BINARY (0) or DESCRIPTOR_FLOAT32 (1)");
    }
    if (n > 0 && (bytes == 0 || bytes > kLargestDescriptor || (hasFloats() && bytes % kFloatBytes != 0))) {
      refuse("descriptor_size is " + std::to_string(bytes) + "; it must be the bytes of one descriptor" +
             (hasFloats() ? ", four for each number" : ", such as 32 of ORB"));
    }
    require("descriptors", message_.descriptors.size(), n * bytes);
  }

  const Message& message_;
};

}  // namespace gms_ransac
