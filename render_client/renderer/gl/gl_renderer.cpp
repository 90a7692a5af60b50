#include "render_client/renderer/gl/gl_renderer.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "common/gl/framebuffer.h"
#include "common/gl/texture.h"
#include "render_client/renderer/gl/gl_camera.h"
#include "render_client/renderer/gl/gl_programs.h"

namespace copresence::renderer {
namespace {

using gl::Format;
using gl::Reader;

// The fragments and depths of all cameras, for one size of the view and one number of cameras.
struct Layers {
  gl::Texture fragments, depths;
  std::vector<gl::Framebuffer> by_camera;  // Empty until attach().

  Layers(gl::Context& context, int width, int height, int count)
      : fragments(context, Format::kRgba8, width, height, count),
        depths(context, Format::kDepth32f, width, height, count) {}

  // Makes a framebuffer for each camera. Requires that the textures fit into the card's memory.
  void attach(gl::Context& context) {
    for (int i = 0; i < fragments.layers(); ++i)
      by_camera.emplace_back(context, std::initializer_list<const gl::Texture*>{&fragments}, &depths, i);
  }
};

// The pictures of one eye, for one size of the view.
struct Target {
  // `merged` is not softened, `scratch` along rows only.
  gl::Texture merged, scratch, color, depth, camera, quality, origin;

  Target(gl::Context& context, int width, int height)
      : merged(context, Format::kRgba8, width, height),
        scratch(context, Format::kRgba8, width, height),
        color(context, Format::kRgba8, width, height),
        depth(context, Format::kR32f, width, height),
        camera(context, Format::kR8ui, width, height),
        quality(context, Format::kR32f, width, height),
        origin(context, Format::kR8ui, width, height) {}
};

// Returns the matrix from the eye's frame to clip coordinates. Pixel centres are at integer
// coordinates, and the first row is at the top. The depth buffer is linear in w = 1/z, so that the
// merge can compute w by one multiplication. It is 0 at the near plane and 1 at the far plane.
Eigen::Matrix4d clip_from_eye(const ViewPose& eye) {
  const CameraModel& intrinsics = eye.intrinsics;
  const double per_w = 1.0 / (1.0 / eye.near_m - 1.0 / eye.far_m);
  Eigen::Matrix4d clip = Eigen::Matrix4d::Zero();
  clip(0, 0) = 2 * intrinsics.fx / intrinsics.width;
  clip(0, 2) = 2 * (intrinsics.cx + 0.5) / intrinsics.width - 1;
  clip(1, 1) = 2 * intrinsics.fy / intrinsics.height;
  clip(1, 2) = 2 * (intrinsics.cy + 0.5) / intrinsics.height - 1;
  clip(2, 2) = 2 * per_w / eye.near_m - 1;
  clip(2, 3) = -2 * per_w;
  clip(3, 2) = 1;
  return clip;
}

ViewUniforms view_uniforms(const ViewPose& eye) {
  const CameraModel& intrinsics = eye.intrinsics;
  return {.w_near_far = Eigen::Vector2d(1 / eye.near_m, 1 / eye.far_m).cast<float>(),
          .ray_from_pixel = Eigen::Vector4d(1 / intrinsics.fx, 1 / intrinsics.fy,
                                            -intrinsics.cx / intrinsics.fx, -intrinsics.cy / intrinsics.fy)
                                .cast<float>()};
}

MergeLayers::Camera merge_camera(const CameraView& camera, const ViewPose& eye) {
  const Rigid3 camera_from_eye = camera.world_from_camera.inverse() * eye.world_from_eye;
  return {.axis = camera_from_eye.matrix().row(2).transpose().cast<float>(),
          .calibration_error_m = static_cast<float>(camera.calibration_error_m),
          .noise = camera.noise};
}

class GlRenderer final : public Renderer {
 public:
  GlRenderer(gl::Context& context, const GlRendererSettings& settings, GlCamera::Shaders shaders,
             DrawMesh draw)
      : context_(context),
        settings_(settings),
        shaders_(std::move(shaders)),
        draw_(std::move(draw)),
        fade_(context),
        merge_(context),
        soften_(context),
        extend_(context) {}

  std::string_view name() const override { return "gl"; }

  void set_unseen(const UnseenStyle& style) override { style_ = style; }

  void set_merge(MergeMode mode) override { mode_ = mode; }

  bool set_wireframe(bool wireframe) override {
    wireframe_ = wireframe;
    return true;
  }

  void prepare(std::span<const CameraView> cameras) override {
    assert(cameras.size() <= kMostViews);
    make_cameras(cameras);
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      if (is_drawn(cameras[i], style_)) cameras_[i].update(cameras[i], shaders_);
    }
  }

  Result<void> render(std::span<const CameraView> cameras, const ViewPose& eye, HostPixels wanted,
                      MergedView& view) override {
    assert(eye.near_m > 0 && eye.near_m < eye.far_m);
    assert(view.target >= 0);
    prepare(cameras);
    const auto index = static_cast<std::size_t>(view.target);
    if (auto made = make_room(cameras.size(), eye.intrinsics.width, eye.intrinsics.height, index); !made)
      return made;
    Target& target = *targets_[index];
    if (cameras.empty()) {
      show_nothing(target);
    } else {
      draw_layers(cameras, eye);
      if (auto faded = fade_layers(cameras); !faded) return faded;
      if (auto merged = merge_layers(cameras, eye, wanted, target); !merged) return merged;
      if (treats_unseen(wanted)) {
        if (auto extended = extend(cameras, eye, target); !extended) return extended;
      }
    }
    read_back(wanted, target, view);
    return context_.check("drawing the view");
  }

 private:
  Result<void> make_room(std::size_t cameras, int width, int height, std::size_t index) {
    if (targets_.size() <= index) targets_.resize(index + 1);
    std::optional<Target>& target = targets_[index];
    if (!target || target->color.width() != width || target->color.height() != height) {
      target.reset();  // Frees memory before the new target needs it.
      layers_.reset();
      target.emplace(context_, width, height);
    }
    const bool fits = layers_ && layers_->by_camera.size() == cameras &&
                      layers_->fragments.width() == width && layers_->fragments.height() == height;
    if (cameras > 0 && !fits) {
      layers_.reset();
      layers_.emplace(context_, width, height, static_cast<int>(cameras));
      auto made = context_.check("making room for the cameras and the view (a smaller --size needs less)");
      if (!made) {
        layers_.reset();
        target.reset();
        return made;
      }
      layers_->attach(context_);
    }
    return {};
  }

  void make_cameras(std::span<const CameraView> cameras) {
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      const CameraModel& model = cameras[i].model;
      if (i == cameras_.size()) {
        cameras_.emplace_back(context_, model, settings_.largest_block);
      } else if (cameras_[i].width() != model.width || cameras_[i].height() != model.height) {
        cameras_[i] = GlCamera(context_, model, settings_.largest_block);
      }
    }
    if (cameras_.size() > cameras.size()) cameras_.erase(cameras_.begin() + cameras.size(), cameras_.end());
  }

  void draw_layers(std::span<const CameraView> cameras, const ViewPose& eye) {
    const Eigen::Matrix4d clip_from_world = clip_from_eye(eye) * eye.world_from_eye.inverse().matrix();
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      gl::Framebuffer& layer = layers_->by_camera[i];
      layer.clear_color(0, {0, 0, 0, 0});
      layer.clear_depth(1);
      layer.draw_lines(wireframe_);
      if (!is_drawn(cameras[i], style_)) continue;
      cameras_[i].draw((clip_from_world * cameras[i].world_from_camera.matrix()).cast<float>(), draw_, layer);
    }
  }

  Result<void> fade_layers(std::span<const CameraView> cameras) {
    faded_.clear();
    for (const CameraView& camera : cameras) {
      faded_.push_back({camera.opacity * (camera.is_remembered ? style_.brightness() : 1),
                        rank(camera.opacity, camera.is_remembered)});
    }
    if (std::all_of(faded_.begin(), faded_.end(),
                    [](const FadeLayers::Layer& layer) { return layer.rank == Rank::kLive; })) {
      return {};
    }
    auto faded = fade_.run(faded_, layers_->fragments);
    context_.barrier(Reader::kFetch | Reader::kFramebuffer);
    return faded;
  }

  Result<void> merge_layers(std::span<const CameraView> cameras, const ViewPose& eye, HostPixels wanted,
                            const Target& target) {
    merge_cameras_.clear();
    for (const CameraView& camera : cameras) merge_cameras_.push_back(merge_camera(camera, eye));
    const ViewUniforms uniforms = view_uniforms(eye);
    if (auto merged = merge_.run(merge_cameras_, mode_, uniforms, layers_->fragments, layers_->depths,
                                 wanted.depth || treats_unseen(wanted),
                                 {target.merged, target.depth, target.camera, target.quality});
        !merged) {
      return merged;
    }
    context_.barrier(Reader::kFetch);
    auto softened = soften_.run(merge_cameras_, uniforms.w_near_far, layers_->fragments, layers_->depths,
                                target.merged, target.scratch, target.color);
    context_.barrier(Reader::kFetch | Reader::kFramebuffer | Reader::kHost);
    return softened;
  }

  // Returns whether the pixels that no camera shows need a colour or an origin.
  bool treats_unseen(HostPixels wanted) const {
    return wanted.depth || style_.show != UnseenStyle::Show::kBlack || !(style_.background == Rgb8{});
  }

  Result<void> extend(std::span<const CameraView> cameras, const ViewPose& eye, const Target& target) {
    extend_cameras_.clear();
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      const CameraView& camera = cameras[i];
      const Rigid3 camera_from_eye = camera.world_from_camera.inverse() * eye.world_from_eye;
      extend_cameras_.push_back({.camera_from_eye = camera_from_eye.matrix().topRows<3>().cast<float>(),
                                 .model = camera.model,
                                 .is_drawn = camera.opacity > 0 && !camera.is_remembered,
                                 .is_remembered = camera.is_remembered,
                                 .inverse = &cameras_[i].inverse(),
                                 .colors = camera.frame->color ? &cameras_[i].texture() : nullptr,
                                 .opacity = camera.opacity});
    }
    return extend_.run(extend_cameras_, view_uniforms(eye), static_cast<float>(eye.near_m), style_,
                       target.color, target.depth, target.camera, target.origin);
  }

  void show_nothing(Target& target) const {
    const Rgb8 background = style_.background;
    target.color.upload(Image<Rgba8>(target.color.width(), target.color.height(),
                                     {background.r, background.g, background.b, 0}));
    target.origin.upload(Image<Origin>(target.origin.width(), target.origin.height(), Origin::kEmpty));
    target.depth.clear();
    target.quality.clear();
    target.camera.upload(Image<std::uint8_t>(target.camera.width(), target.camera.height(), kNoCamera));
  }

  static void read_back(HostPixels wanted, const Target& target, MergedView& view) {
    view.width = target.color.width();
    view.height = target.color.height();
    view.texture = target.color.id();
    const auto fetch = [](bool asked_for, const gl::Texture& texture, auto& image) {
      if (asked_for) {
        texture.read(image);
      } else {
        image.resize(0, 0);
      }
    };
    fetch(wanted.color, target.color, view.color);
    fetch(wanted.depth, target.depth, view.depth_m);
    fetch(wanted.depth, target.camera, view.camera);
    fetch(wanted.depth, target.quality, view.quality);
    fetch(wanted.depth, target.origin, view.origin);
    view.shares.reset();
  }

  gl::Context& context_;
  GlRendererSettings settings_;
  GlCamera::Shaders shaders_;
  DrawMesh draw_;
  FadeLayers fade_;
  MergeLayers merge_;
  SoftenSilhouettes soften_;
  ExtendBackground extend_;
  UnseenStyle style_;
  MergeMode mode_ = MergeMode::kBlend;
  bool wireframe_ = false;
  std::vector<GlCamera> cameras_;
  std::vector<FadeLayers::Layer> faded_;
  std::vector<MergeLayers::Camera> merge_cameras_;
  std::vector<ExtendBackground::Camera> extend_cameras_;
  std::optional<Layers> layers_;
  std::vector<std::optional<Target>> targets_;  // Indexed by MergedView::target.
};

}  // namespace

Result<std::unique_ptr<Renderer>> make_gl_renderer(gl::Context& context, const GlRendererSettings& settings) {
  auto planar_blocks = FindPlanarBlocks::make(context);
  if (!planar_blocks) return fail(planar_blocks.error());
  auto incidence = MeasureIncidence::make(context);
  if (!incidence) return fail(incidence.error());
  auto stitching = StitchPlanarBlocks::make(context);
  if (!stitching) return fail(stitching.error());
  auto mesh = BuildMesh::make(context);
  if (!mesh) return fail(mesh.error());
  auto texture = MakeCameraTexture::make(context);
  if (!texture) return fail(texture.error());
  auto draw = DrawMesh::make(context);
  if (!draw) return fail(draw.error());
  return std::make_unique<GlRenderer>(
      context, settings,
      GlCamera::Shaders{std::move(*planar_blocks), std::move(*incidence), std::move(*stitching),
                        std::move(*mesh), std::move(*texture)},
      std::move(*draw));
}

}  // namespace copresence::renderer
