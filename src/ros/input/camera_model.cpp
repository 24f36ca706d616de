#include "input/camera_model.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "text.h"

namespace gms_ransac {

namespace {

// Focal lengths that differ by more are not of one camera. Two calibrations of one camera differ by a few percent, the
// factory values in TUM's bags by 3 at most; another camera, zoom, or size of the image makes more.
constexpr double kOtherCamera = 0.1;
// Pixels are square to a few percent, those of interlaced video to a tenth.
constexpr double kOblongPixels = 0.1;
// Share of the image. The principal points of TUM's, EuRoC's and KITTI's cameras lie within 4 % of the centre. A raw
// KITTI image is cropped when it is rectified: there K is 12 % from the centre and P 4 %.
constexpr double kOffCentre = 0.08;
// Beyond it no lens is known to have its principal point; a size, binning or region that is not that of the matrix puts
// it at a quarter, at two thirds or at the edge.
constexpr double kFarOffCentre = 0.15;
// Focal lengths that no lens has, in lengths of the longer side: 157 degrees of a pinhole camera, and one.
constexpr double kShortestFocalLength = 0.1, kLongestFocalLength = 57;

bool sameCalibration(const sensor_msgs::CameraInfo& a, const sensor_msgs::CameraInfo& b) {
  return a.width == b.width && a.height == b.height && a.distortion_model == b.distortion_model && a.D == b.D &&
         a.K == b.K && a.P == b.P && a.binning_x == b.binning_x && a.binning_y == b.binning_y && a.roi == b.roi;
}

/// The size of the image that `info` describes, after region of interest and binning; 0x0 when it does not say.
cv::Size describedSize(const sensor_msgs::CameraInfo& info) {
  const bool has_region = info.roi.width != 0 && info.roi.height != 0;
  // Divided as they came, unsigned: the least int over -1 would end the process.
  return {static_cast<int>((has_region ? info.roi.width : info.width) / std::max(info.binning_x, 1u)),
          static_cast<int>((has_region ? info.roi.height : info.height) / std::max(info.binning_y, 1u))};
}

/// Distance of the principal point from the centre of the image, as a share of its width or height.
double offCentre(const sensor_msgs::CameraInfo& info, CameraIntrinsics intrinsics, cv::Size image_size) {
  applyRegionAndBinning(info, intrinsics);
  return std::max(std::abs(intrinsics.cx / image_size.width - 0.5), std::abs(intrinsics.cy / image_size.height - 0.5));
}

/// Distance of a point from the middle, as a share of the sides.
double offMiddle(const cv::Point2d& point, cv::Size size) {
  return std::max(std::abs(point.x / size.width - 0.5), std::abs(point.y / size.height - 0.5));
}

/// The whole image that the principal point of a received one belongs to.
struct WholeImage {
  cv::Size size;
  cv::Point2d principal_point;

  WholeImage(const CameraIntrinsics& k, const sensor_msgs::CameraInfo* info, cv::Size received)
      : size(received), principal_point(k.cx, k.cy) {
    if (info == nullptr || info->width == 0 || info->height == 0 || info->roi.width == 0 || info->roi.height == 0) {
      return;
    }
    size = cv::Size(static_cast<int>(info->width), static_cast<int>(info->height));
    principal_point = {k.cx * std::max(info->binning_x, 1U) + info->roi.x_offset,
                       k.cy * std::max(info->binning_y, 1U) + info->roi.y_offset};
  }
};

/// Binning and region, where there are any, to be compared with what the matrix is for.
std::string binningAndRegion(const sensor_msgs::CameraInfo* info) {
  if (info == nullptr) return std::string();
  std::ostringstream text;
  text << " (binning " << info->binning_x << "x" << info->binning_y << ", region of interest " << info->roi.width << "x"
       << info->roi.height << " at " << info->roi.x_offset << ", " << info->roi.y_offset << ")";
  return text.str();
}

/// Empty unless no camera has this matrix with images of this size; says why, and what to do.
std::string impossibleMatrix(const CameraIntrinsics& k, const std::string& source, const sensor_msgs::CameraInfo* info,
                             cv::Size size) {
  std::ostringstream text;
  text.precision(3);
  const double focal_length = 0.5 * (k.fx + k.fy) / std::max(size.width, size.height);
  if (focal_length < kShortestFocalLength || focal_length > kLongestFocalLength) {
    text << "the focal length is " << 0.5 * (k.fx + k.fy) << " pixels by " << source << ", which no camera has with "
         << sizeText(size) << " images: give K in pixels of this size" << binningAndRegion(info);
    return text.str();
  }
  const WholeImage whole(k, info, size);
  const cv::Point2d& at = whole.principal_point;
  if (offMiddle(at, whole.size) <= kFarOffCentre) return std::string();
  text << "the principal point is at " << 100 * at.x / whole.size.width << " % of the width and "
       << 100 * at.y / whole.size.height << " % of the height of the " << sizeText(whole.size) << " image by " << source
       << ", and cameras have it in the middle: ";
  const bool would_fit_turned = offMiddle(at, {whole.size.height, whole.size.width}) <= kFarOffCentre;
  if (would_fit_turned && whole.size.width != whole.size.height) {
    text << "the images were turned by 90 degrees, and so must be K";
  } else {
    text << "K must be that of images of this size, with binning and region of interest counted once"
         << binningAndRegion(info);
  }
  return text.str();
}

bool mayBeOneCamera(const CameraIntrinsics& a, const CameraIntrinsics& b) {
  return std::abs(std::log(a.fx / b.fx)) <= kOtherCamera && std::abs(std::log(a.fy / b.fy)) <= kOtherCamera;
}

std::string missingRays(const Camera& camera) {
  const int missing = camera.pixelsWithoutInverse();
  if (missing == 0) return std::string();
  std::ostringstream text;
  text << "the distortion coefficients define no ray for about " << missing << " pixels ("
       << std::lround(100.0 * missing / camera.imageSize().area())
       << " %), whose matches are not used; calibrate with views that reach the corners";
  return text.str();
}

}  // namespace

CameraModelSource::CameraModelSource(const Parameters& parameters, const std::string& image_topic,
                                     const std::string& info_topic)
    : override_(parameters.camera),
      input_is_rectified_(parameters.input_is_rectified),
      or_set_(parameters.input == InputKind::kStereo ? "" : " or set ~camera/fx, fy, cx and cy"),
      image_topic_(image_topic),
      info_topic_(info_topic),
      throttle_(parameters.name) {}

std::shared_ptr<const CameraModel> CameraModelSource::get(const sensor_msgs::CameraInfoConstPtr& info,
                                                          cv::Size image_size) {
  const bool same_info = info == info_ || (info && info_ && sameCalibration(*info, *info_));
  if (model_ && image_size == size_ && same_info) return model_;
  size_ = image_size;
  info_ = info;
  model_ = makeAndTell(info.get(), image_size);
  return model_;
}

std::shared_ptr<const CameraModel> CameraModelSource::makeAndTell(const sensor_msgs::CameraInfo* info,
                                                                  cv::Size image_size) {
  auto model = std::make_shared<CameraModel>();
  try {
    make(info, image_size, *model);
  } catch (const std::exception& error) {
    model->problem = "the camera_info on " + info_topic_ + " cannot be used: " + error.what();
  }
  model->source = override_.calibrated() ? "the parameters ~camera" : "the camera_info on " + info_topic_;
  model->doubt = doubtOf(*model, info, image_size);
  const CameraIntrinsics& k = model->camera.intrinsics();
  // The sentence itself is the key: sizes that alternate say two things, not one per image.
  std::ostringstream text;
  if (!model->problem.empty()) {
    text << "no pose for images on " << image_topic_ << ": " << model->problem;
    throttle_.warn(text.str(), text.str());
  } else {
    const bool guessed = input_is_rectified_ == Rectified::kAuto && !override_.calibrated();
    text << "images on " << image_topic_ << " are taken as "
         << (model->rectified() ? "free of distortion" : "distorted")
         << (guessed ? " (set ~input_is_rectified if that is wrong)" : "") << ", with fx " << k.fx << ", fy " << k.fy
         << ", cx " << k.cx << ", cy " << k.cy << " from " << model->source;
    throttle_.info(text.str(), text.str());
  }
  model->warning = missingRays(model->camera);
  if (!model->warning.empty()) throttle_.warn(model->warning, "images on " + image_topic_ + ": " + model->warning);
  return model;
}

std::string CameraModelSource::doubtOf(const CameraModel& model, const sensor_msgs::CameraInfo* info,
                                       cv::Size image_size) const {
  std::string doubt;
  if (info != nullptr && override_.calibrated()) doubt = contradiction(*info, image_size);
  if (doubt.empty() && model.camera.calibrated()) {
    doubt = impossibleMatrix(model.camera.intrinsics(), model.source, info, image_size);
  }
  if (doubt.empty() && info != nullptr && !override_.calibrated()) doubt = unlikelyValues(*info, image_size);
  return doubt;
}

std::string CameraModelSource::sizeMismatch(const sensor_msgs::CameraInfo& info, cv::Size image_size) const {
  const cv::Size described = describedSize(info);
  if (described == cv::Size() || described == image_size) return std::string();
  return "the camera_info on " + info_topic_ + " is for " + sizeText(described) + " images, but the image is " +
         sizeText(image_size);
}

std::string CameraModelSource::contradiction(const sensor_msgs::CameraInfo& info, cv::Size image_size) const {
  const std::string advice = "; ~camera is used: remove it from the parameter server if another launch left it there";
  const std::string mismatch = sizeMismatch(info, image_size);
  if (!mismatch.empty()) return mismatch + advice;
  // Either matrix may describe the images: the parameters must fit one of them.
  std::vector<CameraIntrinsics> given;
  for (CameraIntrinsics each : {ofK(info), ofP(info)}) {
    if (!each.calibrated()) continue;
    applyRegionAndBinning(info, each);
    if (mayBeOneCamera(each, override_)) return std::string();
    given.push_back(each);
  }
  if (given.empty()) return std::string();
  std::ostringstream text;
  text << "the parameters ~camera have fx " << override_.fx << ", fy " << override_.fy << ", but the camera_info on "
       << info_topic_ << " has fx " << given[0].fx << ", fy " << given[0].fy << ": that is another camera" << advice;
  return text.str();
}

std::string CameraModelSource::unlikelyValues(const sensor_msgs::CameraInfo& info, cv::Size image_size) const {
  const double of_k = offCentre(info, ofK(info), image_size), of_p = offCentre(info, ofP(info), image_size);
  const bool distorted = !isRectified(info, image_topic_, input_is_rectified_);
  if (input_is_rectified_ == Rectified::kAuto && info.P[0] > 0 && distorted && of_k > kOffCentre && 2 * of_p < of_k) {
    std::ostringstream text;
    text.precision(2);
    text << "the principal point in K of the camera_info on " << info_topic_ << " is " << 100 * of_k
         << " % of the image from its centre, that in P " << 100 * of_p
         << " %: if the images are rectified and K is that of the raw ones, set ~input_is_rectified to true";
    return text.str();
  }
  const auto& K = info.K;
  const bool given = K[0] > 0 && K[4] > 0, oblong = given && std::abs(std::log(K[0] / K[4])) > kOblongPixels;
  if (oblong && info.binning_x == info.binning_y) {
    std::ostringstream text;
    text << "the camera_info on " << info_topic_ << " has fx " << K[0] << " and fy " << K[4]
         << ", but pixels are square: unless the image was stretched, calibrate again with more views";
    return text.str();
  }
  // As in the official bags of TUM RGB-D. The driver sends five zeros; without coefficients a camera, such as a
  // rendered one, is known to have no distortion.
  const bool zeros = !info.D.empty() && std::all_of(info.D.begin(), info.D.end(), [](double d) { return d == 0; });
  if (K[0] != 525 || K[4] != 525 || K[2] != 319.5 || K[5] != 239.5 || !zeros) return std::string();
  return "the camera_info on " + info_topic_ +
         " holds the factory values of the OpenNI driver (fx 525, cx 319.5, cy 239.5, no distortion), not a "
         "calibration: rotation and direction are less accurate; calibrate the camera" +
         or_set_ + ", or replay a TUM bag with tum.launch calibration:=1, 2 or 3";
}

void CameraModelSource::make(const sensor_msgs::CameraInfo* info, cv::Size image_size, CameraModel& model) const {
  if (override_.calibrated()) {
    CameraIntrinsics intrinsics = override_;
    if (input_is_rectified_ == Rectified::kTrue) intrinsics.distortion.clear();
    model.camera = Camera(intrinsics, image_size);
  } else if (info == nullptr) {
    model.problem = "no camera_info has arrived on " + info_topic_ + " yet; publish or remap one" + or_set_;
  } else {
    fromInfo(*info, image_size, model);
  }
}

void CameraModelSource::fromInfo(const sensor_msgs::CameraInfo& info, cv::Size image_size, CameraModel& model) const {
  CameraIntrinsics intrinsics = intrinsicsOf(info, image_topic_, input_is_rectified_, or_set_);
  if (!intrinsics.calibrated()) {
    model.problem = "the camera_info on " + info_topic_ +
                    " is not calibrated (fx is 0 in K and in P); calibrate the camera" + or_set_;
    return;
  }
  model.problem = sizeMismatch(info, image_size);
  if (!model.problem.empty()) {
    model.problem += "; remap the matching camera_info" + or_set_;
    return;
  }
  intrinsics.distortion_model = excerpt(intrinsics.distortion_model);  // an unknown one will be quoted
  model.camera = Camera(intrinsics, image_size);
}

}  // namespace gms_ransac
