#include "priors/tf_source.h"

#include "tf_lookup.h"

namespace gms_ransac {

bool TfSource::covers(const PriorQuery& query) {
  Eigen::Isometry3d unused;
  return tf_.get(fixed_frame_, query.camera_frame, query.to, unused).empty();
}

RotationAnswer TfSource::measure(const PriorQuery& query) {
  Eigen::Isometry3d start, end;
  RotationAnswer answer;
  answer.problem = tf_.get(fixed_frame_, query.camera_frame, query.from, start);
  if (answer.problem.empty()) answer.problem = tf_.get(fixed_frame_, query.camera_frame, query.to, end);
  if (answer.problem.empty()) answer.prior = priorOfPoses(start.linear().transpose() * end.linear());
  return answer;
}

}  // namespace gms_ransac
