#include "render_client/renderer/gl/gl_programs.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <utility>

#include "render_client/renderer/cpu/planar_blocks.h"
#include "render_client/renderer/extension_rules.h"
#include "render_client/renderer/merge_rules.h"
#include "shaders/build_mesh.comp.h"
#include "shaders/draw_mesh.frag.h"
#include "shaders/draw_mesh.vert.h"
#include "shaders/extend_blocks.comp.h"
#include "shaders/extend_colors.comp.h"
#include "shaders/extend_estimate.comp.h"
#include "shaders/extend_smooth.comp.h"
#include "shaders/extend_view.comp.h"
#include "shaders/fade_layers.comp.h"
#include "shaders/find_planar_blocks.comp.h"
#include "shaders/make_camera_texture.comp.h"
#include "shaders/measure_incidence.comp.h"
#include "shaders/merge_layers.comp.h"
#include "shaders/soften_silhouettes.comp.h"
#include "shaders/stitch_planar_blocks.comp.h"

namespace copresence::renderer {
namespace {

using gl::Access;
using gl::Define;

// Returns a GLSL literal of exactly this value.
std::string literal(float value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.9e", double(value));
  return text.data();
}

std::string element(const char* array, std::size_t index) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%s[%zu]", array, index);
  return text.data();
}

}  // namespace

Result<FindPlanarBlocks> FindPlanarBlocks::make(gl::Context& context) {
  auto program = gl::Program::compute(context, shaders::find_planar_blocks_comp);
  if (!program) return fail(program.error());
  return FindPlanarBlocks(std::move(*program));
}

void FindPlanarBlocks::run(const gl::Texture& depth, float units_per_metre, const SurfaceLimits& limits,
                           const GlPlanes& planes) {
  depth.bind(0);
  for (int level = 0; level < 3; ++level) planes[level].bind_image(level, Access::kWrite);
  program_.set("units_per_metre", units_per_metre);
  program_.set("gap", limits.gap);
  program_.set("slope", limits.slope);
  program_.set("planar", limits.planar);
  program_.set("curvature", limits.curvature);
  program_.dispatch(planes[2].width(), planes[2].height());
}

Result<MeasureIncidence> MeasureIncidence::make(gl::Context& context) {
  const std::array defines = {Define{"CELL", std::to_string(kCell)},
                              Define{"CELL_PIXELS", std::to_string(kCellPixels)},
                              Define{"UNKNOWN_INCIDENCE", literal(kUnknownIncidence)}};
  auto program = gl::Program::compute(context, shaders::measure_incidence_comp, defines);
  if (!program) return fail(program.error());
  return MeasureIncidence(std::move(*program));
}

void MeasureIncidence::run(const gl::Texture& depth, const GlPlanes& planes, const CameraModel& model,
                           float units_per_metre, const gl::Texture& incidences) {
  constexpr int kLevel = 1;
  static_assert(kBlockSizes[kLevel + kFirstGlLevel] == kCell);
  depth.bind(0);
  planes[kLevel].bind(1);
  incidences.bind_image(0, Access::kWrite);
  program_.set("units_per_metre", units_per_metre);
  program_.set("focal", Eigen::Vector2d(model.fx, model.fy).cast<float>().eval());
  program_.set("center", Eigen::Vector2d(model.cx, model.cy).cast<float>().eval());
  program_.dispatch_over(incidences.width(), incidences.height());
}

Result<MakeCameraTexture> MakeCameraTexture::make(gl::Context& context) {
  const std::array defines = {
      Define{"CELL", std::to_string(kCell)}, Define{"FILLED_WEIGHT", literal(kFilledWeight)},
      Define{"BORDER_SHARE", literal(kBorderShare)}, Define{"AMBIENT", literal(kAmbient)}};
  auto program = gl::Program::compute(context, shaders::make_camera_texture_comp, defines);
  if (!program) return fail(program.error());
  return MakeCameraTexture(std::move(*program));
}

void MakeCameraTexture::run(const gl::Texture& incidences, const gl::Texture& depth, const gl::Texture& state,
                            const gl::Texture* color, const Eigen::Matrix<float, 3, 4>& color_correction,
                            const gl::Texture& camera_texture) {
  incidences.bind(0);
  state.bind(1);
  if (color) color->bind(2);
  depth.bind(3);
  camera_texture.bind_image(0, Access::kWrite);
  program_.set("has_color", color ? 1 : 0);
  program_.set("color_correction", color_correction);
  program_.dispatch_over(camera_texture.width(), camera_texture.height());
}

Result<StitchPlanarBlocks> StitchPlanarBlocks::make(gl::Context& context) {
  auto program = gl::Program::compute(context, shaders::stitch_planar_blocks_comp);
  if (!program) return fail(program.error());
  return StitchPlanarBlocks(std::move(*program));
}

void StitchPlanarBlocks::run(const gl::Texture& depth, const GlPlanes& planes, float units_per_metre,
                             int largest_block, const gl::Texture& inverse) {
  depth.bind(0);
  for (int level = 0; level < 3; ++level) planes[level].bind(1 + level);
  inverse.bind_image(0, Access::kWrite);
  program_.set("units_per_metre", units_per_metre);
  program_.set("largest_block", largest_block);
  program_.dispatch(planes[2].width(), planes[2].height());
}

Result<BuildMesh> BuildMesh::make(gl::Context& context) {
  auto program = gl::Program::compute(context, shaders::build_mesh_comp);
  if (!program) return fail(program.error());
  return BuildMesh(std::move(*program));
}

void BuildMesh::run(const gl::Texture& inverse, const GlPlanes& planes, const SurfaceLimits& limits,
                    int largest_block, gl::Buffer& command, const gl::Buffer& indices) {
  command.write(std::span<const gl::DrawCommand>(std::array{gl::DrawCommand{}}));
  inverse.bind(0);
  for (int level = 0; level < 3; ++level) planes[level].bind(1 + level);
  command.bind_storage(0);
  indices.bind_storage(1);
  program_.set("gap", limits.gap);
  program_.set("slope", limits.slope);
  program_.set("largest_block", largest_block);
  program_.dispatch_over(inverse.width(), inverse.height());
}

Result<DrawMesh> DrawMesh::make(gl::Context& context) {
  auto program = gl::Program::graphics(context, shaders::draw_mesh_vert, shaders::draw_mesh_frag);
  if (!program) return fail(program.error());
  return DrawMesh(std::move(*program));
}

void DrawMesh::run(const gl::Texture& inverse, const gl::Texture& rays, const gl::Texture& camera_texture,
                   const Eigen::Matrix4f& clip_from_camera, const gl::Buffer& command,
                   const gl::Buffer& indices, gl::Framebuffer& layer) {
  inverse.bind(0);
  rays.bind(1);
  camera_texture.bind(2);
  program_.set("clip_from_camera", clip_from_camera);
  layer.draw_indirect(program_, indices, command);
}

Result<void> FadeLayers::run(std::span<const Layer> layers, const gl::Texture& fragments) {
  auto compiled = programs_.find(layers.size());
  if (compiled == programs_.end()) {
    const std::array defines = {Define{"LAYERS", std::to_string(layers.size())}};
    auto program = gl::Program::compute(*context_, shaders::fade_layers_comp, defines);
    if (!program) return fail(program.error());
    compiled = programs_.emplace(layers.size(), std::move(*program)).first;
  }
  gl::Program& program = compiled->second;
  fragments.bind_image(0, Access::kReadWrite);
  for (std::size_t i = 0; i < layers.size(); ++i) {
    program.set(element("opacity", i).c_str(), layers[i].opacity);
    program.set(element("rank", i).c_str(), static_cast<int>(layers[i].rank));
  }
  program.dispatch_over(fragments.width(), fragments.height());
  return {};
}

Result<void> MergeLayers::run(std::span<const Camera> cameras, MergeMode mode, const ViewUniforms& view,
                              const gl::Texture& fragments, const gl::Texture& depths, bool wants_depth,
                              const Target& target) {
  auto compiled = programs_.find(cameras.size());
  if (compiled == programs_.end()) {
    const std::array defines = {Define{"LAYERS", std::to_string(cameras.size())}};
    auto program = gl::Program::compute(*context_, shaders::merge_layers_comp, defines);
    if (!program) return fail(program.error());
    compiled = programs_.emplace(cameras.size(), std::move(*program)).first;
  }
  gl::Program& program = compiled->second;
  fragments.bind(0);
  depths.bind(1);
  target.color.bind_image(0, Access::kWrite);
  target.depth.bind_image(1, Access::kWrite);
  target.camera.bind_image(2, Access::kWrite);
  target.quality.bind_image(3, Access::kWrite);
  program.set("wants_depth", wants_depth ? 1 : 0);
  program.set("nearest_only", mode == MergeMode::kNearest ? 1 : 0);
  program.set("tie_ratio", tie_ratio(mode));
  program.set("w_near_far", view.w_near_far);
  program.set("ray_from_pixel", view.ray_from_pixel);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    program.set(element("camera_axis", i).c_str(), cameras[i].axis);
    program.set(element("calibration_error", i).c_str(), cameras[i].calibration_error_m);
    program.set(element("noise_per_square", i).c_str(), uncertainty_per_square(cameras[i].noise));
    program.set(element("precision_factor", i).c_str(), precision(cameras[i].noise));
  }
  program.dispatch_over(target.color.width(), target.color.height());
  return {};
}

Result<void> SoftenSilhouettes::run(std::span<const MergeLayers::Camera> cameras,
                                    const Eigen::Vector2f& w_near_far, const gl::Texture& fragments,
                                    const gl::Texture& depths, const gl::Texture& merged,
                                    const gl::Texture& scratch, const gl::Texture& softened) {
  auto compiled = programs_.find(cameras.size());
  if (compiled == programs_.end()) {
    const std::array defines = {Define{"LAYERS", std::to_string(cameras.size())},
                                Define{"SHARE", literal(1.0F / kSilhouetteDivisor)}};
    auto program = gl::Program::compute(*context_, shaders::soften_silhouettes_comp, defines);
    if (!program) return fail(program.error());
    compiled = programs_.emplace(cameras.size(), std::move(*program)).first;
  }
  fragments.bind(0);
  depths.bind(1);
  float coarsest = 0;
  for (const MergeLayers::Camera& camera_texture : cameras)
    coarsest = std::max(coarsest, inverse_step(camera_texture.noise));
  compiled->second.set("w_near_far", w_near_far);
  compiled->second.set("apart", kSilhouetteSteps * coarsest);
  const auto soften = [&](const Eigen::Vector2i& direction, const gl::Texture& from, const gl::Texture& to) {
    from.bind(2);
    to.bind_image(0, Access::kWrite);
    compiled->second.set("direction", direction);
    compiled->second.dispatch_over(to.width(), to.height());
    context_->barrier(gl::Reader::kFetch);
  };
  soften({1, 0}, merged, scratch);
  soften({0, 1}, scratch, softened);
  return {};
}

Result<void> ExtendBackground::compile(std::size_t cameras) {
  const std::array defines = {Define{"BLOCK", std::to_string(kExtensionBlock)},
                              Define{"SAME_SURFACE", literal(kSameSurface)},
                              Define{"OWN_SURFACE", literal(kOwnSurface)},
                              Define{"MOST_SLOPE", literal(kMostSlope)},
                              Define{"MOST_CHANGE", literal(kMostChange)},
                              Define{"FARTHEST_M", literal(kFarthestM)},
                              Define{"OWN_WEIGHT", literal(kOwnWeight)},
                              Define{"FADE_SHARE", literal(kFadeShare)},
                              Define{"MIXED_COLORS", std::to_string(kMixedColors)},
                              Define{"LEAST_VISIBLE_SHARE", literal(kLeastVisibleShare)},
                              Define{"LAYERS", std::to_string(cameras)}};
  const auto make = [&](std::string_view shader, std::optional<gl::Program>& program) -> Result<void> {
    if (program) return {};
    auto made = gl::Program::compute(*context_, shader, defines);
    if (!made) return fail(made.error());
    program.emplace(std::move(*made));
    return {};
  };
  if (auto made = make(shaders::extend_blocks_comp, summarise_); !made) return made;
  if (auto made = make(shaders::extend_estimate_comp, estimate_); !made) return made;
  if (auto made = make(shaders::extend_smooth_comp, smooth_); !made) return made;
  if (auto made = make(shaders::extend_colors_comp, take_colors_); !made) return made;
  if (fill_.contains(cameras)) return {};
  auto made = gl::Program::compute(*context_, shaders::extend_view_comp, defines);
  if (!made) return fail(made.error());
  fill_.emplace(cameras, std::move(*made));
  return {};
}

void ExtendBackground::estimate_blocks(const gl::Texture& color, const gl::Texture& depth) {
  const int width = blocks_->gaps.width(), height = blocks_->gaps.height();
  color.bind(0);
  depth.bind(1);
  blocks_->surfaces.bind_image(0, Access::kWrite);
  blocks_->gaps.bind_image(1, Access::kWrite);
  summarise_->dispatch_over(width, height);
  context_->barrier(gl::Reader::kFetch);
  blocks_->surfaces.bind(0);
  blocks_->gaps.bind(1);
  blocks_->estimates.bind_image(0, Access::kWrite);
  estimate_->dispatch_over(width, height);
  context_->barrier(gl::Reader::kFetch);
  static_assert(kSmoothingRounds % 2 == 0, "the result is in `estimates`");
  const gl::Texture *from = &blocks_->estimates, *to = &blocks_->surfaces;
  for (int round = 0; round < kSmoothingRounds; ++round) {
    from->bind(0);
    to->bind_image(0, Access::kWrite);
    smooth_->dispatch_over(width, height);
    context_->barrier(gl::Reader::kFetch);
    std::swap(from, to);
  }
}

void ExtendBackground::take_colors(std::span<const Camera> cameras, const ViewUniforms& view,
                                   float brightness, const gl::Texture& color, const gl::Texture& depth,
                                   const gl::Texture& origin) {
  depth.bind(0);
  origin.bind(1);
  color.bind_image(0, Access::kWrite);
  take_colors_->set("ray_from_pixel", view.ray_from_pixel);
  // The first camera of the list counts, so it comes last.
  for (std::size_t i = cameras.size(); i-- > 0;) {
    const Camera& camera = cameras[i];
    if (!camera.is_drawn || !camera.colors) continue;
    camera.inverse->bind(2);
    camera.colors->bind(3);
    const CameraModel& model = camera.model;
    const auto& k = model.distortion;
    take_colors_->set("camera_from_eye", camera.camera_from_eye);
    take_colors_->set("intrinsics",
                      Eigen::Vector4f(Eigen::Vector4d(model.fx, model.fy, model.cx, model.cy).cast<float>()));
    take_colors_->set("radial_tangential",
                      Eigen::Vector4f(Eigen::Vector4d(k[0], k[1], k[2], k[3]).cast<float>()));
    take_colors_->set("rational", Eigen::Vector4f(Eigen::Vector4d(k[4], k[5], k[6], k[7]).cast<float>()));
    take_colors_->set("brightness", brightness * camera.opacity);
    take_colors_->dispatch_over(color.width(), color.height());
    context_->barrier(gl::Reader::kFetch);
  }
}

Result<void> ExtendBackground::run(std::span<const Camera> cameras, const ViewUniforms& view, float near_m,
                                   const UnseenStyle& style, const gl::Texture& color,
                                   const gl::Texture& depth, const gl::Texture& camera,
                                   const gl::Texture& origin) {
  if (auto compiled = compile(cameras.size()); !compiled) return compiled;
  const int width = (color.width() + kExtensionBlock - 1) / kExtensionBlock;
  const int height = (color.height() + kExtensionBlock - 1) / kExtensionBlock;
  if (!blocks_ || blocks_->gaps.width() != width || blocks_->gaps.height() != height) {
    blocks_.reset();
    blocks_.emplace(Blocks{gl::Texture(*context_, gl::Format::kRgba32f, width, height),
                           gl::Texture(*context_, gl::Format::kRgba32f, width, height),
                           gl::Texture(*context_, gl::Format::kR8ui, width, height)});
  }
  const bool extends = style.show != UnseenStyle::Show::kBlack;
  if (extends) estimate_blocks(color, depth);
  gl::Program& fill = fill_.at(cameras.size());
  blocks_->estimates.bind(0);
  blocks_->gaps.bind(1);
  camera.bind(2);
  color.bind_image(0, Access::kWrite);
  depth.bind_image(1, Access::kReadWrite);
  origin.bind_image(2, Access::kWrite);
  fill.set("extends", extends ? 1 : 0);
  fill.set("brightness", style.brightness());
  fill.set(
      "background",
      Eigen::Vector3f(Eigen::Vector3f(style.background.r, style.background.g, style.background.b) / 255));
  fill.set("ray_from_pixel", view.ray_from_pixel);
  fill.set("near", near_m);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const CameraModel& model = cameras[i].model;
    fill.set(element("camera_from_eye", i).c_str(), cameras[i].camera_from_eye);
    fill.set(element("intrinsics", i).c_str(),
             Eigen::Vector4f(Eigen::Vector4d(model.fx, model.fy, model.cx, model.cy).cast<float>()));
    fill.set(element("is_remembered", i).c_str(), cameras[i].is_remembered ? 1 : 0);
    fill.set(element("picture", i).c_str(),
             cameras[i].is_drawn ? Eigen::Vector2f(Eigen::Vector2i(model.width, model.height).cast<float>())
                                 : Eigen::Vector2f(Eigen::Vector2f::Zero()));
  }
  fill.dispatch_over(color.width(), color.height());
  context_->barrier(gl::Reader::kFetch);
  if (extends) take_colors(cameras, view, style.brightness(), color, depth, origin);
  context_->barrier(gl::Reader::kFetch | gl::Reader::kFramebuffer | gl::Reader::kHost);
  return {};
}

}  // namespace copresence::renderer
