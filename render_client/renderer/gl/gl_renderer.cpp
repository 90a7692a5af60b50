#include "render_client/renderer/gl/gl_renderer.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>
#include <vector>

#include "common/gl/framebuffer.h"
#include "common/gl/texture.h"
#include "render_client/renderer/gl/gl_programs.h"
#include "render_client/renderer/gl/gl_source.h"

namespace copresence::renderer {
namespace {

using gl::Format;
using gl::Reader;

// What is made for a size of the view and a number of cameras.
struct Layers {
  gl::Texture fragments, depths;
  std::vector<gl::Framebuffer> by_camera;  // empty until attach()

  Layers(gl::Context& context, int width, int height, int count)
      : fragments(context, Format::kRgba8, width, height, count),
        depths(context, Format::kDepth32f, width, height, count) {}

  // Requires that the graphics card had room for the textures.
  void attach(gl::Context& context) {
    for (int i = 0; i < fragments.layers(); ++i)
      by_camera.emplace_back(context, std::initializer_list<const gl::Texture*>{&fragments}, &depths, i);
  }
};

// What is made for a size of the view.
struct Target {
  gl::Texture merged, color, depth, camera, quality;  // `merged` before its outlines are softened

  Target(gl::Context& context, int width, int height)
      : merged(context, Format::kRgba8, width, height),
        color(context, Format::kRgba8, width, height),
        depth(context, Format::kR32f, width, height),
        camera(context, Format::kR8ui, width, height),
        quality(context, Format::kR32f, width, height) {}
};

// Clip coordinates whose pixels' centres are whole numbers and whose rows run from the top. Depth is linear
// in w = 1/z, from 0 at near to 1 at far, so that the merge gets w back by one multiplication.
Eigen::Matrix4d clip_from_eye(const VirtualCamera& eye) {
  const CameraModel& lens = eye.lens;
  const double per_w = 1.0 / (1.0 / eye.near_m - 1.0 / eye.far_m);
  Eigen::Matrix4d clip = Eigen::Matrix4d::Zero();
  clip(0, 0) = 2 * lens.fx / lens.width;
  clip(0, 2) = 2 * (lens.cx + 0.5) / lens.width - 1;
  clip(1, 1) = 2 * lens.fy / lens.height;
  clip(1, 2) = 2 * (lens.cy + 0.5) / lens.height - 1;
  clip(2, 2) = 2 * per_w / eye.near_m - 1;
  clip(2, 3) = -2 * per_w;
  clip(3, 2) = 1;
  return clip;
}

MergeLayers::Eye merge_eye(const VirtualCamera& eye) {
  const CameraModel& lens = eye.lens;
  return {
      .w_near_far = Eigen::Vector2d(1 / eye.near_m, 1 / eye.far_m).cast<float>(),
      .ray_from_pixel =
          Eigen::Vector4d(1 / lens.fx, 1 / lens.fy, -lens.cx / lens.fx, -lens.cy / lens.fy).cast<float>()};
}

MergeLayers::Source merge_source(const CameraView& camera, const VirtualCamera& eye) {
  const Rigid3 camera_from_eye = camera.world_from_camera.inverse() * eye.world_from_eye;
  return {.axis = camera_from_eye.matrix().row(2).transpose().cast<float>(),
          .calibration_error_m = static_cast<float>(camera.calibration_error_m),
          .noise = camera.noise};
}

class GlRenderer final : public Renderer {
 public:
  GlRenderer(gl::Context& context, const GlRendererSettings& settings, GlSource::Shaders shaders,
             DrawMesh draw)
      : context_(context),
        settings_(settings),
        shaders_(std::move(shaders)),
        draw_(std::move(draw)),
        fade_(context),
        merge_(context),
        soften_(context) {}

  std::string_view name() const override { return "gl"; }

  void prepare(std::span<const CameraView> cameras) override {
    assert(cameras.size() <= kMostCameras);
    make_sources(cameras);
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      if (cameras[i].opacity > 0) sources_[i].update(cameras[i], shaders_);
    }
  }

  Result<void> render(std::span<const CameraView> cameras, const VirtualCamera& eye, HostPixels wanted,
                      MergedView& view) override {
    assert(eye.near_m > 0 && eye.near_m < eye.far_m);
    prepare(cameras);
    if (auto made = make_layers(cameras.size(), eye.lens.width, eye.lens.height); !made) return made;
    if (cameras.empty()) {
      show_nothing();
    } else {
      draw_layers(cameras, eye);
      if (auto faded = fade_layers(cameras); !faded) return faded;
      if (auto merged = merge_layers(cameras, eye, wanted); !merged) return merged;
    }
    read_back(wanted, view);
    return context_.check("drawing the view");
  }

 private:
  Result<void> make_layers(std::size_t cameras, int width, int height) {
    if (!target_ || target_->color.width() != width || target_->color.height() != height) {
      target_.reset();
      layers_.reset();
      target_.emplace(context_, width, height);
    }
    if (cameras > 0 && (!layers_ || layers_->by_camera.size() != cameras)) {
      layers_.reset();  // before the new ones ask for memory
      layers_.emplace(context_, width, height, static_cast<int>(cameras));
      auto made = context_.check("making room for the cameras and the view (a smaller --size needs less)");
      if (!made) {
        layers_.reset();
        target_.reset();
        return made;
      }
      layers_->attach(context_);
    }
    return {};
  }

  void make_sources(std::span<const CameraView> cameras) {
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      const CameraModel& model = cameras[i].model;
      if (i == sources_.size()) {
        sources_.emplace_back(context_, model, settings_.largest_block);
      } else if (sources_[i].width() != model.width || sources_[i].height() != model.height) {
        sources_[i] = GlSource(context_, model, settings_.largest_block);
      }
    }
    if (sources_.size() > cameras.size()) sources_.erase(sources_.begin() + cameras.size(), sources_.end());
  }

  void draw_layers(std::span<const CameraView> cameras, const VirtualCamera& eye) {
    const Eigen::Matrix4d clip_from_world = clip_from_eye(eye) * eye.world_from_eye.inverse().matrix();
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      gl::Framebuffer& layer = layers_->by_camera[i];
      layer.clear_color(0, {0, 0, 0, 0});
      layer.clear_depth(1);
      if (!(cameras[i].opacity > 0)) continue;
      sources_[i].draw((clip_from_world * cameras[i].world_from_camera.matrix()).cast<float>(), draw_, layer);
    }
  }

  Result<void> fade_layers(std::span<const CameraView> cameras) {
    opacities_.clear();
    for (const CameraView& camera : cameras) opacities_.push_back(camera.opacity);
    if (std::all_of(opacities_.begin(), opacities_.end(), [](float opacity) { return opacity >= 1; }))
      return {};
    auto faded = fade_.run(opacities_, layers_->fragments);
    context_.barrier(Reader::kFetch | Reader::kFramebuffer);
    return faded;
  }

  Result<void> merge_layers(std::span<const CameraView> cameras, const VirtualCamera& eye,
                            HostPixels wanted) {
    merge_sources_.clear();
    for (const CameraView& camera : cameras) merge_sources_.push_back(merge_source(camera, eye));
    const MergeLayers::Eye seen = merge_eye(eye);
    if (auto merged = merge_.run(merge_sources_, seen, layers_->fragments, layers_->depths, wanted.depth,
                                 {target_->merged, target_->depth, target_->camera, target_->quality});
        !merged) {
      return merged;
    }
    context_.barrier(Reader::kFetch);
    auto softened = soften_.run(merge_sources_, seen.w_near_far, layers_->fragments, layers_->depths,
                                target_->merged, target_->color);
    context_.barrier(Reader::kFetch | Reader::kFramebuffer | Reader::kHost);
    return softened;
  }

  void show_nothing() {
    target_->color.clear();
    target_->depth.clear();
    target_->quality.clear();
    target_->camera.upload(Image<std::uint8_t>(target_->camera.width(), target_->camera.height(), kNoCamera));
  }

  void read_back(HostPixels wanted, MergedView& view) const {
    view.width = target_->color.width();
    view.height = target_->color.height();
    view.texture = target_->color.id();
    const auto fetch = [](bool asked_for, const gl::Texture& texture, auto& image) {
      if (asked_for) {
        texture.read(image);
      } else {
        image.resize(0, 0);
      }
    };
    fetch(wanted.color, target_->color, view.color);
    fetch(wanted.depth, target_->depth, view.depth_m);
    fetch(wanted.depth, target_->camera, view.camera);
    fetch(wanted.depth, target_->quality, view.quality);
  }

  gl::Context& context_;
  GlRendererSettings settings_;
  GlSource::Shaders shaders_;
  DrawMesh draw_;
  FadeLayers fade_;
  MergeLayers merge_;
  SoftenOutlines soften_;
  std::vector<GlSource> sources_;  // by camera
  std::vector<float> opacities_;
  std::vector<MergeLayers::Source> merge_sources_;
  std::optional<Layers> layers_;
  std::optional<Target> target_;
};

}  // namespace

Result<std::unique_ptr<Renderer>> make_gl_renderer(gl::Context& context, const GlRendererSettings& settings) {
  auto flat_blocks = FindFlatBlocks::make(context);
  if (!flat_blocks) return fail(flat_blocks.error());
  auto tilts = MeasureTilts::make(context);
  if (!tilts) return fail(tilts.error());
  auto outlines = OutlineFlatBlocks::make(context);
  if (!outlines) return fail(outlines.error());
  auto mesh = BuildMesh::make(context);
  if (!mesh) return fail(mesh.error());
  auto look = MakeSource::make(context);
  if (!look) return fail(look.error());
  auto draw = DrawMesh::make(context);
  if (!draw) return fail(draw.error());
  return std::make_unique<GlRenderer>(
      context, settings,
      GlSource::Shaders{std::move(*flat_blocks), std::move(*tilts), std::move(*outlines), std::move(*mesh),
                        std::move(*look)},
      std::move(*draw));
}

}  // namespace copresence::renderer
