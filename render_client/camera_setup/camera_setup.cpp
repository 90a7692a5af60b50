#include "render_client/camera_setup/camera_setup.h"

#include <fmt/format.h>

namespace copresence::client {

CameraSetup resolve_setup(const StreamDescription& stream, const scene::Scene* scene) {
  CameraSetup setup;
  setup.model = stream.model;
  setup.unit = stream.unit;
  setup.noise = stream.noise;
  setup.has_pose = stream.has_pose;
  const scene::Camera* const known = scene ? scene->find(stream.camera) : nullptr;
  if (!known) return setup;
  if (known->model.width == stream.model.width && known->model.height == stream.model.height) {
    setup.model = known->model;
  } else {
    setup.remark = fmt::format(
        "camera \"{}\" streams {}x{}, but the scene file's intrinsics are for {}x{}: the stream's are used",
        stream.camera, stream.model.width, stream.model.height, known->model.width, known->model.height);
  }
  setup.fixed_pose = known->world_from_camera;
  setup.has_pose = setup.has_pose || known->world_from_camera.has_value();
  setup.color_correction = known->color_matching;
  if (known->calibration_error_mm) setup.calibration_error_m = *known->calibration_error_mm * 1e-3;
  return setup;
}

}  // namespace copresence::client
