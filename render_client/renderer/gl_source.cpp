#include "render_client/renderer/gl_source.h"

#include <algorithm>
#include <cassert>
#include <vector>

#include "render_client/renderer/merge_rules.h"

namespace copresence::renderer {
namespace {

using gl::Format;
using gl::Reader;

int cells(int pixels) {
  return (pixels + kCell - 1) / kCell;
}

struct Ray {
  float x = 0, y = 0;  // at z = 1
};

Image<Ray> ray_image(const CameraModel& model) {
  Image<Ray> image(model.width, model.height);
  const std::vector<Eigen::Vector2f> by_pixel = rays(model);
  std::transform(by_pixel.begin(), by_pixel.end(), image.pixels().begin(),
                 [](const Eigen::Vector2f& ray) { return Ray{ray.x(), ray.y()}; });
  return image;
}

float metres(DepthUnit unit) {
  return static_cast<float>(metres_per_unit(unit));
}

}  // namespace

GlSource::GlSource(gl::Context& context, const CameraModel& model)
    : context_(&context),
      model_(model),
      rays_(context, Format::kRg32f, model.width, model.height),
      depth_(context, Format::kR16ui, model.width, model.height),
      state_(context, Format::kR8ui, model.width, model.height),
      color_(context, Format::kRgba8, model.width, model.height),
      cosines_(context, Format::kR32f, cells(model.width), cells(model.height)),
      source_(context, Format::kRgba8, model.width, model.height),
      command_(context, sizeof(gl::DrawCommand)),
      indices_(context, sizeof(std::uint32_t) * 6 * model.width * model.height) {
  rays_.upload(ray_image(model));
  cosines_.set_filter(gl::Filter::kLinear);
  source_.set_filter(gl::Filter::kLinear);
}

void GlSource::update(const CameraView& camera, MeasureTilts& tilts, MakeSource& look, BuildMesh& mesh) {
  const RgbdFrame& frame = *camera.frame;
  assert(camera.model.width == width() && camera.model.height == height());
  assert(frame.depth.width() == width() && frame.depth.height() == height());
  const bool same_model = camera.model == model_;
  const bool same_frame =
      same_model && version_ == camera.version && frame_ == camera.frame && unit_ == camera.unit;
  if (same_frame && color_matching_ == camera.color_matching) return;
  if (!same_model) rays_.upload(ray_image(camera.model));
  if (!same_frame) {
    depth_.upload(frame.depth);
    state_.upload(frame.state);
    if (frame.color) color_.upload(*frame.color);
    tilts.run(depth_, camera.model, metres(camera.unit), cosines_);
    mesh.run(depth_, metres(camera.unit), static_cast<float>(1.0 / camera.model.fx), command_, indices_);
    context_->barrier(Reader::kFetch | Reader::kCommand | Reader::kIndices);
  }
  look.run(cosines_, state_, frame.color ? &color_ : nullptr, camera.color_matching, source_);
  context_->barrier(Reader::kFetch);
  model_ = camera.model;
  version_ = camera.version;
  frame_ = camera.frame;
  unit_ = camera.unit;
  color_matching_ = camera.color_matching;
}

void GlSource::draw(const Eigen::Matrix4f& clip_from_camera, DrawMesh& program,
                    gl::Framebuffer& layer) const {
  program.run(depth_, rays_, metres(unit_), source_, clip_from_camera, command_, indices_, layer);
}

}  // namespace copresence::renderer
