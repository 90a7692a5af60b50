#include "render_client/renderer/cpu/cpu_renderer.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <vector>

#include "render_client/renderer/cpu/band_merge.h"
#include "render_client/renderer/cpu/depth_mesh.h"
#include "render_client/renderer/cpu/source_texture.h"

namespace copresence::renderer {
namespace {

constexpr int kBandRows = 16;

// Everything that is derived from a camera's frame, until the next one comes.
class Source {
 public:
  explicit Source(int largest_block) : largest_block_(largest_block) {}

  void update(const CameraView& camera) {
    const bool new_model = !(camera.model == model_);
    if (new_model) rays_ = rays(camera.model);
    const bool new_frame = new_model || !has_frame_ || camera.version != version_ || camera.unit != unit_ ||
                           !(camera.noise == noise_);
    model_ = camera.model;
    unit_ = camera.unit;
    noise_ = camera.noise;
    version_ = camera.version;
    has_frame_ = true;
    if (new_frame) {
      const SurfaceLimits limits(noise_, static_cast<float>(1.0 / model_.fx));
      invert_depth(camera.frame->depth, metres_per_unit(unit_), inverse_);
      find_flat_blocks(inverse_, limits, flat_);
      measure_tilts(inverse_, flat_, model_, cosines_);
      list_blocks(inverse_, flat_, largest_block_, blocks_);
      if (model_.is_distorted()) {
        straightened_rays_ = rays_;
        outlines_.draw(flat_, blocks_, inverse_, &straightened_rays_);
        build_mesh(inverse_, blocks_, {straightened_rays_, true}, limits, mesh);
      } else {
        outlines_.draw(flat_, blocks_, inverse_);
        build_mesh(inverse_, blocks_, {rays_, false}, limits, mesh);
      }
    }
    if (new_frame || camera.color_matching != color_matching_) {
      color_matching_ = camera.color_matching;
      make_texture(*camera.frame, cosines_, color_matching_, texture);
    }
  }

  // Puts the mesh before the eye.
  void project(const VirtualCamera& eye, const Rigid3& world_from_camera) {
    matrix = projection_matrix(eye, world_from_camera);
    vertices.resize(mesh.vertices());
    extents.resize(mesh.patches.size());
    project_patches(mesh, 0, mesh.patches.size(), matrix, static_cast<float>(eye.near_m), vertices, extents);
  }

  // Lists the patches of every band.
  void sort_into_bands(int width, int height) {
    bands.resize((height + kBandRows - 1) / kBandRows);
    for (auto& band : bands) band.clear();
    const auto last_row = static_cast<float>(height - 1);
    for (std::size_t p = 0; p < extents.size(); ++p) {
      const PatchExtent& extent = extents[p];
      if (extent.behind) continue;
      int first = 0, last = static_cast<int>(bands.size()) - 1;
      if (extent.in_front) {
        // One pixel more on every side than the rasteriser's tolerance reaches.
        if (extent.right < -1 || extent.left > static_cast<float>(width) || extent.bottom < -1 ||
            extent.top > static_cast<float>(height)) {
          continue;
        }
        first = static_cast<int>(std::clamp(extent.top - 1, 0.0F, last_row)) / kBandRows;
        last = static_cast<int>(std::clamp(extent.bottom + 1, 0.0F, last_row)) / kBandRows;
      }
      for (int band = first; band <= last; ++band) bands[band].push_back(static_cast<std::uint32_t>(p));
    }
  }

  // Draws nothing until it is projected again.
  void hide() { bands.clear(); }

  DepthMesh mesh;
  Texture texture;
  ProjectionMatrix matrix;
  std::vector<ViewVertex> vertices;
  std::vector<PatchExtent> extents;
  std::vector<std::vector<std::uint32_t>> bands;

 private:
  int largest_block_;
  bool has_frame_ = false;
  std::uint64_t version_ = 0;
  CameraModel model_;
  DepthUnit unit_ = DepthUnit::kMillimetre;
  DepthNoise noise_;
  Eigen::Matrix<float, 3, 4> color_matching_;
  std::vector<Eigen::Vector2f> rays_, straightened_rays_;
  InverseDepth inverse_;
  FlatBlocks flat_;
  MeshBlocks blocks_;
  BlockOutlines outlines_;
  Image<float> cosines_;
};

class CpuRenderer : public Renderer {
 public:
  CpuRenderer(Executor& workers, const CpuRendererSettings& settings)
      : workers_(workers), settings_(settings) {}

  std::string_view name() const override { return "cpu"; }

  void prepare(std::span<const CameraView> cameras) override {
    make_sources(cameras.size());
    workers_.run(static_cast<int>(cameras.size()), [&](int i, int) {
      if (cameras[i].opacity > 0) sources_[i].update(cameras[i]);
    });
  }

  Result<void> render(std::span<const CameraView> cameras, const VirtualCamera& eye, HostPixels wanted,
                      MergedView& view) override {
    make_sources(cameras.size());
    shape_view(eye, wanted, view);
    workers_.run(static_cast<int>(cameras.size()), [&](int i, int) {
      if (!(cameras[i].opacity > 0)) return sources_[i].hide();
      sources_[i].update(cameras[i]);
      sources_[i].project(eye, cameras[i].world_from_camera);
      sources_[i].sort_into_bands(view.width, view.height);
    });
    merge_sources_.clear();
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      merge_sources_.push_back(merge_source(cameras[i], eye, sources_[i].texture));
    }
    workers_.run((view.height + kBandRows - 1) / kBandRows,
                 [&](int band, int worker) { draw_band(band, scratch_[worker], eye, wanted, view); });
    return {};
  }

 private:
  void make_sources(std::size_t cameras) {
    assert(cameras <= kMostCameras);
    while (sources_.size() < cameras) sources_.emplace_back(settings_.largest_block);
    scratch_.resize(workers_.count());
    for (auto& bands : scratch_) bands.resize(cameras);
  }

  static void shape_view(const VirtualCamera& eye, HostPixels wanted, MergedView& view) {
    view.width = eye.lens.width;
    view.height = eye.lens.height;
    view.texture = 0;
    const auto shape = [&](auto& image, bool is_wanted) {
      image.resize(is_wanted ? view.width : 0, is_wanted ? view.height : 0);
    };
    shape(view.color, wanted.color);
    shape(view.depth_m, wanted.depth);
    shape(view.camera, wanted.depth);
    shape(view.quality, wanted.depth);
  }

  void draw_band(int number, std::vector<Band>& bands, const VirtualCamera& eye, HostPixels wanted,
                 MergedView& view) const {
    const int top = number * kBandRows;
    const int rows = std::min(kBandRows, view.height - top);
    for (std::size_t i = 0; i < bands.size(); ++i) {
      const Source& source = sources_[i];
      bands[i].begin(view.width, top, rows, static_cast<float>(eye.far_m), source.texture.width() - 1,
                     source.texture.height() - 1);
      if (source.bands.empty()) continue;
      for (const std::uint32_t p : source.bands[number]) {
        draw_patch(source.mesh, source.mesh.patches[p], source.extents[p], source.vertices, source.matrix,
                   static_cast<float>(eye.near_m), bands[i]);
      }
    }
    let_stale_give_way(bands);
    if (!bands.empty()) {
      return merge_band(merge_sources_, bands, wanted, view);
    }
    for (int y = top; y < top + rows; ++y) {
      if (wanted.color) std::fill(view.color.row(y).begin(), view.color.row(y).end(), Rgba8{0, 0, 0, 0});
      if (wanted.depth) {
        std::fill(view.depth_m.row(y).begin(), view.depth_m.row(y).end(), 0.0F);
        std::fill(view.camera.row(y).begin(), view.camera.row(y).end(), kNoCamera);
        std::fill(view.quality.row(y).begin(), view.quality.row(y).end(), 0.0F);
      }
    }
  }

  void let_stale_give_way(std::vector<Band>& bands) const {
    for (std::size_t stale = 0; stale < bands.size(); ++stale) {
      if (merge_sources_[stale].opacity_256 == 256) continue;
      for (std::size_t live = 0; live < bands.size(); ++live) {
        if (merge_sources_[live].opacity_256 == 256) bands[stale].give_way_to(bands[live]);
      }
    }
  }

  Executor& workers_;
  CpuRendererSettings settings_;
  std::vector<Source> sources_;
  std::vector<MergeSource> merge_sources_;
  std::vector<std::vector<Band>> scratch_;  // by worker, by camera
};

}  // namespace

std::unique_ptr<Renderer> make_cpu_renderer(Executor& workers, const CpuRendererSettings& settings) {
  return std::make_unique<CpuRenderer>(workers, settings);
}

}  // namespace copresence::renderer
