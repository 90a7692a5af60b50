#include "render_client/camera_setup.h"

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
  setup.color_matching = known->color_matching;
  if (known->calibration_error_mm) setup.calibration_error_m = *known->calibration_error_mm * 1e-3;
  return setup;
}

renderer::CameraView camera_view(const CameraSetup& setup, const RgbdFrame& frame, std::uint64_t version,
                                 const color_matching::ColorCorrection& found) {
  renderer::CameraView view;
  view.frame = &frame;
  view.version = version;
  view.model = setup.model;
  view.unit = setup.unit;
  view.noise = setup.noise;
  view.world_from_camera = setup.pose(frame.metadata);
  view.color_matching = setup.color_matching.value_or(found);
  view.calibration_error_m = setup.calibration_error_m;
  return view;
}

color_matching::PosedFrame posed_frame(const CameraSetup& setup, const RgbdFrame& frame) {
  return {
      &frame, setup.model, setup.unit, setup.noise, setup.pose(frame.metadata), setup.calibration_error_m};
}

}  // namespace copresence::client
