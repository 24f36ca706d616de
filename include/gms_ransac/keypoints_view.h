// A gms_ransac/Keypoints message as matrices, without a copy, or as the core's Features. Header-only, without ROS
// headers.
#pragma once

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
  static constexpr size_t kLargestSide = 65535;  ///< pixels; larger images have no features
  static constexpr int kOctaves = 16;            ///< as many as there can be

  /// Throws std::invalid_argument naming the first column or keypoint that cannot be.
  explicit KeypointsView(const Message& message) : message_(message) {
    const size_t n = message.u.size();
    require("v", message.v.size(), n);
    require("octave", message.octave.size(), n);
    require("size", message.size.size(), n);
    require("angle", message.angle.size(), n);
    require("response", message.response.size(), n);
    require("sigma", message.sigma.size(), n);
    require("track_id", message.track_id.size(), n);
    if (!message.depth.empty()) require("depth", message.depth.size(), n);
    require("descriptors", message.descriptors.size(), n * kDescriptorBytes);
    if (message.width > kLargestSide || message.height > kLargestSide) refuse("the image has an impossible size");
    if (!(message.scale_factor > 1) || !std::isfinite(message.scale_factor)) refuse("scale_factor is not above 1");
    for (size_t i = 0; i < n; ++i) {
      if (!isWithin(message.u[i], message.width) || !isWithin(message.v[i], message.height)) {
        refuse("keypoint " + std::to_string(i) + " lies outside the image");
      }
      if (message.octave[i] >= kOctaves) refuse("keypoint " + std::to_string(i) + " has no possible octave");
    }
  }
  explicit KeypointsView(Message&&) = delete;  // the view would outlive it

  int size() const { return static_cast<int>(message_.u.size()); }
  /// N values each; what they are: msg/Keypoints.msg.
  Column u() const { return {message_.u.data(), size()}; }
  Column v() const { return {message_.v.data(), size()}; }
  Column sigma() const { return {message_.sigma.data(), size()}; }
  bool hasDepth() const { return !message_.depth.empty(); }
  /// Metres along the optical axis, 0: not known. Only with hasDepth().
  Column depth() const { return {message_.depth.data(), hasDepth() ? size() : 0}; }
  /// N x 32 CV_8U.
  cv::Mat descriptors() const {
    return cv::Mat(size(), kDescriptorBytes, CV_8U, const_cast<uint8_t*>(message_.descriptors.data()));
  }
  cv::KeyPoint keypoint(int i) const {
    const auto k = static_cast<size_t>(i);
    return {message_.u[k],
            message_.v[k],
            message_.size[k],
            message_.angle[k],
            message_.response[k],
            message_.octave[k],
            static_cast<int>(message_.track_id[k])};
  }
  /// A copy for HammingMatcher and MotionStatisticsFilter, packed. Needs gms_ransac_core.
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
  [[noreturn]] static void refuse(const std::string& what) { throw std::invalid_argument("Keypoints: " + what); }
  static void require(const char* column, size_t length, size_t expected) {
    if (length == expected) return;
    refuse(std::string(column) + " has " + std::to_string(length) + " entries, but " + std::to_string(expected) +
           " belong to this many keypoints (u)");
  }
  /// Pixels reach half a pixel beyond their centres. False for NaN.
  static bool isWithin(float coordinate, uint32_t side) {
    return coordinate >= -0.5f && coordinate <= static_cast<float>(side) - 0.5f;
  }

  const Message& message_;
};

}  // namespace gms_ransac
