#include "render_client/viewpoint/eye.h"

namespace copresence::viewpoint {

ViewPose pose_of_eye(const ViewPose& head, const Eye& eye) {
  ViewPose pose = head;
  pose.world_from_eye = head.world_from_eye * eye.head_from_eye;
  CameraModel& model = pose.intrinsics;
  const Eigen::Vector3d& offset = eye.head_from_eye.translation;
  model.cx += model.fx * offset.x() / eye.screen_distance_m;
  model.cy += model.fy * offset.y() / eye.screen_distance_m;
  const PixelGrid& grid = eye.pixels;
  model.width /= grid.column_step;
  model.height /= grid.row_step;
  model.fx /= grid.column_step;
  model.fy /= grid.row_step;
  model.cx = (model.cx - grid.first_column) / grid.column_step;
  model.cy = (model.cy - grid.first_row) / grid.row_step;
  return pose;
}

}  // namespace copresence::viewpoint
