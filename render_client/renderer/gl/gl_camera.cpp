#include "render_client/renderer/gl/gl_camera.h"

#include <algorithm>
#include <cassert>
#include <vector>

#include "render_client/renderer/cpu/planar_blocks.h"
#include "render_client/renderer/merge_rules.h"
#include "render_client/renderer/shading.h"

namespace copresence::renderer {
namespace {

using gl::Format;
using gl::Reader;

int cells(int pixels) {
  return (pixels + kCell - 1) / kCell;
}

struct Ray {
  float x = 0, y = 0;  // At z = 1.
};

Image<Ray> ray_image(const CameraModel& model) {
  Image<Ray> image(model.width, model.height);
  const std::vector<Eigen::Vector2f> by_pixel = rays(model);
  std::transform(by_pixel.begin(), by_pixel.end(), image.pixels().begin(), [](const Eigen::Vector2f& ray) {
    return Ray{ray.x(), ray.y()};
  });
  return image;
}

// Returns the number of 16x16 blocks that are needed to contain all quads, as in InverseDepth.
int patches(int pixels) {
  return (pixels + 14) / 16;
}

GlPlanes make_planes(gl::Context& context, const CameraModel& model) {
  const auto of_level = [&](int level) {
    const int in_patch = 16 / kBlockSizes[level + kFirstGlLevel];
    return gl::Texture(context, Format::kRgba32f, in_patch * patches(model.width),
                       in_patch * patches(model.height));
  };
  return {of_level(0), of_level(1), of_level(2)};
}

}  // namespace

GlCamera::GlCamera(gl::Context& context, const CameraModel& model, int largest_block)
    : context_(&context),
      largest_block_(largest_block),
      model_(model),
      rays_(context, Format::kRg32f, model.width, model.height),
      depth_(context, Format::kR16ui, model.width, model.height),
      state_(context, Format::kR8ui, model.width, model.height),
      color_(context, Format::kRgba8, model.width, model.height),
      inverse_(context, Format::kR32f, model.width, model.height),
      incidences_(context, Format::kR32f, cells(model.width), cells(model.height)),
      texture_(context, Format::kRgba8, model.width, model.height),
      planes_(make_planes(context, model)),
      command_(context, sizeof(gl::DrawCommand)),
      indices_(context, sizeof(std::uint32_t) * 6 * model.width * model.height) {
  rays_.upload(ray_image(model));
  incidences_.set_filter(gl::Filter::kLinear);
  texture_.set_filter(gl::Filter::kLinear);
}

void GlCamera::update(const CameraView& camera, Shaders& shaders) {
  const RgbdFrame& frame = *camera.frame;
  assert(camera.model.width == width() && camera.model.height == height());
  assert(frame.depth.width() == width() && frame.depth.height() == height());
  const bool same_model = camera.model == model_;
  const bool same_frame = same_model && version_ == camera.version && frame_ == camera.frame &&
                          unit_ == camera.unit && noise_ == camera.noise;
  if (same_frame && color_correction_ == camera.color_correction) return;
  if (!same_model) rays_.upload(ray_image(camera.model));
  if (!same_frame) {
    depth_.upload(frame.depth);
    state_.upload(frame.state);
    if (frame.color) color_.upload(*frame.color);
    const auto units_per_metre = static_cast<float>(1.0 / metres_per_unit(camera.unit));
    const SurfaceLimits limits(camera.noise, static_cast<float>(1.0 / camera.model.fx));
    shaders.planar_blocks.run(depth_, units_per_metre, limits, planes_);
    context_->barrier(Reader::kFetch);
    if (frame.color) {
      shaders.incidence.run(depth_, planes_, camera.model, units_per_metre, incidences_);
    } else {
      measure_shading(frame.depth, camera.unit, camera.model, shading_);
      incidences_.upload(shading_);
    }
    shaders.stitching.run(depth_, planes_, units_per_metre, largest_block_, inverse_);
    context_->barrier(Reader::kFetch);
    shaders.mesh.run(inverse_, planes_, limits, largest_block_, command_, indices_);
    context_->barrier(Reader::kFetch | Reader::kCommand | Reader::kIndices);
  }
  shaders.texture.run(incidences_, depth_, state_, frame.color ? &color_ : nullptr, camera.color_correction,
                      texture_);
  context_->barrier(Reader::kFetch);
  model_ = camera.model;
  version_ = camera.version;
  frame_ = camera.frame;
  unit_ = camera.unit;
  noise_ = camera.noise;
  color_correction_ = camera.color_correction;
}

void GlCamera::draw(const Eigen::Matrix4f& clip_from_camera, DrawMesh& program,
                    gl::Framebuffer& layer) const {
  program.run(inverse_, rays_, texture_, clip_from_camera, command_, indices_, layer);
}

}  // namespace copresence::renderer
