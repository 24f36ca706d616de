// The room camera goes from pixels to rays and back. A new lens is a Distortion here; nobody else knows its
// coefficients.
//
// The distortion models of camera.h and their inverse, in normalised image coordinates.
#pragma once

#include <string>

#include <Eigen/Core>

#include "gms_ransac/camera.h"

namespace gms_ransac {

/// The model of camera.h that is meant: Kalibr and some drivers use words of their own. An unknown one is returned.
std::string commonModelName(const std::string& model);

/// True for the models whose rays pass one unit sphere or two.
bool hasSpheres(const std::string& model);
/// How much larger the image of a pinhole camera with the focal length of `intrinsics` is at its centre: 1 + xi for the
/// models with a sphere, else 1.
double magnificationOf(const CameraIntrinsics& intrinsics);

/// x_distorted = T(x r_d(r) / r + tangential and thin-prism terms) with T the tilt of the sensor: the models of
/// OpenCV's calibration. For a fisheye lens r_d(r) is a polynomial of the angle atan(r). The models with a sphere (one:
/// Mei & Rives 2007, eq. 5; two: Usenko, Demmel & Cremers 2018, eq. 40) move x towards the centre first; the result is
/// in units of their focal length at the centre.
class Distortion {
 public:
  explicit Distortion(const CameraIntrinsics& intrinsics);

  Eigen::Vector2d distort(const Eigen::Vector2d& ideal) const;
  /// False, with `ideal` undefined, where the model has no inverse: beyond the radius up to which r_d grows, and where
  /// no pinhole camera sees.
  bool undistort(const Eigen::Vector2d& distorted, Eigen::Vector2d& ideal) const;

 private:
  struct Radial {
    double factor;  ///< r_d / r
    double slope;   ///< d r_d / d r
  };
  Radial radial(double squared_radius) const;
  /// The same for the projection from the unit spheres onto the plane that the lens distorts; 1 and 1 without spheres.
  Radial sphere(double squared_radius) const;
  /// Derivative of `at.factor * point` by the point.
  static Eigen::Matrix2d byPoint(const Radial& at, const Eigen::Vector2d& point);
  Eigen::Vector2d distortOnPlane(const Eigen::Vector2d& plane, Eigen::Matrix2d& derivative) const;
  /// All but the tilt, and its derivative.
  Eigen::Vector2d distortOnLens(const Eigen::Vector2d& ideal, Eigen::Matrix2d& derivative) const;
  /// Newton's step, or the largest half of it that brings `ideal` closer to its target; false when none does.
  bool stepCloser(Eigen::Vector2d step, const Eigen::Vector2d& target, Eigen::Vector2d& ideal,
                  Eigen::Matrix2d& derivative, Eigen::Vector2d& residual) const;
  double radiusOfGrowth() const;
  /// Distorted radius beyond which the search stops.
  double farthestOnRim() const;

  bool fisheye_;
  double xi_ = 0, alpha_ = 0;                 ///< of the spheres; one sphere: alpha is 0; none: both are
  double numerator_[5] = {1, 0, 0, 0, 0};     ///< of r_d / r in powers of r^2; fisheye: of r_d / angle, angle^2
  double denominator_[4] = {1, 0, 0, 0};      ///< of r_d / r
  double p1_ = 0, p2_ = 0;                    ///< tangential
  double prism_x_[2] = {}, prism_y_[2] = {};  ///< thin prism: factors of r^2 and r^4
  Eigen::Matrix3d tilt_ = Eigen::Matrix3d::Identity(), untilt_ = Eigen::Matrix3d::Identity();
  double largest_radius_;  ///< ideal
  double reach_;           ///< distorted
};

}  // namespace gms_ransac
