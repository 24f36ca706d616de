// The status of a pair in words, with what to do about it: one text for the node, for C++ and for Python.
#pragma once

#include <string>

#include "gms_ransac/match_filter_options.h"
#include "gms_ransac/match_result.h"

namespace gms_ransac {

/// Added to result and options in the text of a status.
struct StatusCircumstances {
  std::string option_prefix;    ///< before the names of options: "~" for parameters of a node
  int features_asked = -1;      ///< keypoints that the current image was searched for; negative: as in the options
  bool features_given = false;  ///< the caller's, not found in an image
  double unmasked = 1;          ///< share of the current image in which keypoints may lie
  std::string image_note;       ///< about an image with few keypoints, such as what its grey levels stand for
  std::string no_camera = "give a camera with K";  ///< why the camera is not calibrated, or what to do
};

/// A sentence without a full stop. `status`: that of the result, or another one that its reader was given.
std::string explain(Status status, const MatchResult& result, const MatchFilterOptions& options,
                    const StatusCircumstances& about = {});

}  // namespace gms_ransac
