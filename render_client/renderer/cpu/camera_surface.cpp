#include "render_client/renderer/cpu/camera_surface.h"

#include "render_client/renderer/merge_rules.h"
#include "render_client/renderer/shading.h"

namespace copresence::renderer {

void CameraSurface::update(const CameraView& camera) {
  const bool new_model = !(camera.model == model_);
  if (new_model) rays_ = rays(camera.model);
  const bool new_frame = new_model || !has_frame_ || camera.version != version_ || camera.unit != unit_ ||
                         !(camera.noise == noise_);
  model_ = camera.model;
  unit_ = camera.unit;
  noise_ = camera.noise;
  version_ = camera.version;
  has_frame_ = true;
  if (new_frame) make_mesh(camera);
  if (new_frame || camera.color_correction != color_correction_) {
    color_correction_ = camera.color_correction;
    make_texture(*camera.frame, incidences_, color_correction_, texture_);
  }
}

void CameraSurface::make_mesh(const CameraView& camera) {
  const SurfaceLimits limits(noise_, static_cast<float>(1.0 / model_.fx));
  invert_depth(camera.frame->depth, metres_per_unit(unit_), inverse_);
  find_planar_blocks(inverse_, limits, planar_);
  if (camera.frame->color) {
    measure_incidence(inverse_, planar_, model_, incidences_);
  } else {
    measure_shading(camera.frame->depth, unit_, model_, incidences_);
  }
  list_blocks(inverse_, planar_, largest_block_, blocks_);
  if (model_.is_distorted()) {
    straightened_rays_ = rays_;
    stitching_.draw(planar_, blocks_, inverse_, &straightened_rays_);
    build_mesh(inverse_, blocks_, {straightened_rays_, true}, limits, mesh_);
  } else {
    stitching_.draw(planar_, blocks_, inverse_);
    build_mesh(inverse_, blocks_, {rays_, false}, limits, mesh_);
  }
}

}  // namespace copresence::renderer
