#include "render_client/renderer/cpu/cpu_renderer.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "render_client/renderer/cpu/background_extension.h"
#include "render_client/renderer/cpu/camera_surface.h"
#include "render_client/renderer/cpu/lanes.h"
#include "render_client/renderer/cpu/silhouettes.h"
#include "render_client/renderer/cpu/tile_merge.h"
#include "render_client/renderer/extension_rules.h"

namespace copresence::renderer {
namespace {

constexpr int kTileRows = 16;
constexpr int kGapColumns = 32;
static_assert(kTileRows % kExtensionBlock == 0, "a tile has whole blocks");

// The surface of a camera's frame and its projection into the view.
class ProjectedSurface {
 public:
  explicit ProjectedSurface(int largest_block) : surface_(largest_block) {}

  void update(const CameraView& camera) { surface_.update(camera); }

  void project(const ViewPose& eye, const Rigid3& world_from_camera) {
    matrix = projection_matrix(eye, world_from_camera);
    vertices.resize(mesh().vertices());
    extents.resize(mesh().patches.size());
    project_patches(mesh(), 0, mesh().patches.size(), matrix, static_cast<float>(eye.near_m), vertices,
                    extents);
  }

  void sort_into_tiles(int width, int height) {
    tiles.resize((height + kTileRows - 1) / kTileRows);
    for (auto& tile : tiles) tile.clear();
    const auto last_row = static_cast<float>(height - 1);
    for (std::size_t p = 0; p < extents.size(); ++p) {
      const PatchExtent& extent = extents[p];
      if (extent.behind) continue;
      int first = 0, last = static_cast<int>(tiles.size()) - 1;
      if (extent.in_front) {
        // The margin of one pixel allows for the tolerance of the rasteriser.
        if (extent.right < -1 || extent.left > static_cast<float>(width) || extent.bottom < -1 ||
            extent.top > static_cast<float>(height)) {
          continue;
        }
        first = static_cast<int>(std::clamp(extent.top - 1, 0.0F, last_row)) / kTileRows;
        last = static_cast<int>(std::clamp(extent.bottom + 1, 0.0F, last_row)) / kTileRows;
      }
      for (int tile = first; tile <= last; ++tile) tiles[tile].push_back(static_cast<std::uint32_t>(p));
    }
  }

  void hide() { tiles.clear(); }

  const DepthMesh& mesh() const { return surface_.mesh(); }
  const CameraTexture& texture() const { return surface_.texture(); }
  CameraPictures pictures() const { return {&surface_.texture(), &surface_.inverse()}; }

  ProjectionMatrix matrix;
  std::vector<ViewVertex> vertices;
  std::vector<PatchExtent> extents;
  std::vector<std::vector<std::uint32_t>> tiles;

 private:
  CameraSurface surface_;
};

class CpuRenderer : public Renderer {
 public:
  CpuRenderer(Executor& workers, const CpuRendererSettings& settings)
      : workers_(workers), settings_(settings) {}

  std::string_view name() const override { return "cpu"; }

  void set_unseen(const UnseenStyle& style) override { style_ = style; }

  void set_merge(MergeMode mode) override { merge_ = mode; }

  bool set_wireframe(bool) override { return false; }

  void prepare(std::span<const CameraView> cameras) override {
    make_surfaces(cameras.size());
    workers_.run(static_cast<int>(cameras.size()), [&](int i, int) {
      if (is_drawn(cameras[i], style_)) surfaces_[i].update(cameras[i]);
    });
  }

  Result<void> render(std::span<const CameraView> cameras, const ViewPose& eye, HostPixels wanted,
                      MergedView& view) override {
    make_surfaces(cameras.size());
    shape_view(eye, wanted, view);
    workers_.run(static_cast<int>(cameras.size()), [&](int i, int) {
      if (!is_drawn(cameras[i], style_)) return surfaces_[i].hide();
      surfaces_[i].update(cameras[i]);
      surfaces_[i].project(eye, cameras[i].world_from_camera);
      surfaces_[i].sort_into_tiles(view.width, view.height);
    });
    merge_cameras_.clear();
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      merge_cameras_.push_back(merge_camera(cameras[i], eye, surfaces_[i].texture(), style_.brightness()));
      merge_cameras_.back().index = static_cast<int>(i);
    }
    const MergeSettings settings{wanted, style_.background, silhouette_step(), merge_};
    const int tiles = (view.height + kTileRows - 1) / kTileRows;
    pixels_.assign(tiles, {});
    borders_.resize(tiles);
    if (inverse_.width() > 0) extension_.begin(view.width, view.height);
    workers_.run(tiles,
                 [&](int tile, int worker) { draw_tile(tile, scratch_[worker], eye, settings, view); });
    if (wanted.color) {
      for (int tile = 1; tile < tiles; ++tile) {
        soften_between_tiles(borders_[tile - 1].last, borders_[tile].first, tile * kTileRows,
                             settings.silhouette_step, view);
      }
    }
    std::size_t extended = 0;
    if (inverse_.width() > 0) {
      pictures_.clear();
      for (std::size_t i = 0; i < cameras.size(); ++i) pictures_.push_back(surfaces_[i].pictures());
      extended = extension_.apply(eye, cameras, pictures_, inverse_, style_, workers_, view);
    }
    view.shares.reset();
    if (wanted.color) view.shares = shares(extended, view.color.pixels().size());
    return {};
  }

 private:
  // A worker's data for one tile: the cameras that have patches in it, and their fragments.
  struct Scratch {
    std::vector<MergeCamera> cameras;
    std::vector<Tile> tiles;
    std::vector<std::uint8_t> gaps;  // By kGapColumns columns.
  };
  // Counts the pixels of a tile.
  struct Pixels {
    std::size_t shown = 0;       // Pixels that show any camera.
    std::size_t remembered = 0;  // Pixels that show a remembered background.
  };

  float silhouette_step() const {
    float coarsest = 0;
    for (const MergeCamera& camera : merge_cameras_)
      coarsest = std::max(coarsest, inverse_step(camera.noise));
    return kSilhouetteSteps * coarsest;
  }

  void make_surfaces(std::size_t cameras) {
    assert(cameras <= kMostViews);
    while (surfaces_.size() < cameras) surfaces_.emplace_back(settings_.largest_block);
    scratch_.resize(workers_.count());
    for (Scratch& scratch : scratch_) scratch.tiles.resize(cameras);
  }

  void shape_view(const ViewPose& eye, HostPixels wanted, MergedView& view) {
    view.width = eye.intrinsics.width;
    view.height = eye.intrinsics.height;
    view.texture = 0;
    const auto shape = [&](auto& image, bool is_wanted) {
      image.resize(is_wanted ? view.width : 0, is_wanted ? view.height : 0);
    };
    shape(view.color, wanted.color);
    shape(view.depth_m, wanted.depth);
    shape(view.camera, wanted.depth);
    shape(view.quality, wanted.depth);
    shape(view.origin, wanted.depth);
    shape(inverse_, wanted.color && style_.show != UnseenStyle::Show::kBlack);
  }

  void draw_tile(int number, Scratch& scratch, const ViewPose& eye, const MergeSettings& settings,
                 MergedView& view) {
    const int top = number * kTileRows;
    const int rows = std::min(kTileRows, view.height - top);
    scratch.cameras.clear();
    for (const Rank rank : {Rank::kLive, Rank::kStale, Rank::kRemembered}) {
      // A camera gives way to those of a lower rank. So it is drawn only where they leave gaps.
      const std::size_t before = scratch.cameras.size();
      bool has_gaps = false;
      for (const MergeCamera& camera : merge_cameras_) {
        const ProjectedSurface& surface = surfaces_[camera.index];
        if (camera.rank != rank || surface.tiles.empty() || surface.tiles[number].empty()) continue;
        if (before > 0 && !std::exchange(has_gaps, true))
          find_gaps({scratch.tiles.data(), before}, scratch.gaps);
        Tile& tile = scratch.tiles[scratch.cameras.size()];
        scratch.cameras.push_back(camera);
        tile.begin(view.width, top, rows, static_cast<float>(eye.far_m), surface.texture().width() - 1,
                   surface.texture().height() - 1);
        for (const std::uint32_t p : surface.tiles[number]) {
          if (before > 0 && !reaches_gap(surface.extents[p], scratch.gaps)) continue;
          draw_patch(surface.mesh(), surface.mesh().patches[p], surface.extents[p], surface.vertices,
                     surface.matrix, static_cast<float>(eye.near_m), tile);
        }
      }
    }
    const std::span<Tile> tiles(scratch.tiles.data(), scratch.cameras.size());
    if (tiles.empty()) {
      show_nothing(number, top, rows, settings, view);
    } else {
      give_way(scratch.cameras, tiles);
      pixels_[number].remembered = count_remembered(scratch.cameras, tiles);
      pixels_[number].shown = merge_tile(scratch.cameras, tiles, settings, view, inverse_, borders_[number]);
    }
    if (settings.wanted.depth) mark_origins(top, rows, view);
    if (inverse_.width() > 0) extension_.survey(inverse_, top, rows);
  }

  void mark_origins(int top, int rows, MergedView& view) const {
    for (int y = top; y < top + rows; ++y) {
      for (int x = 0; x < view.width; ++x) {
        const std::uint8_t camera = view.camera(x, y);
        view.origin(x, y) = camera == kNoCamera                                ? Origin::kEmpty
                            : merge_cameras_[camera].rank == Rank::kRemembered ? Origin::kRemembered
                                                                               : Origin::kSeen;
      }
    }
  }

  OriginShares shares(std::size_t extended, std::size_t pixels) const {
    Pixels sum;
    for (const Pixels& tile : pixels_) {
      sum.shown += tile.shown;
      sum.remembered += tile.remembered;
    }
    const auto share = [pixels](std::size_t count) {
      return static_cast<float>(count) / static_cast<float>(pixels);
    };
    return {share(sum.shown - sum.remembered), share(sum.remembered), share(extended),
            share(pixels - sum.shown - extended)};
  }

  void show_nothing(int tile, int top, int rows, const MergeSettings& settings, MergedView& view) {
    const Rgb8 background = settings.background;
    for (int y = top; y < top + rows; ++y) {
      const auto fill_row = [y](auto& image, auto value) {
        if (image.width() > 0) std::fill(image.row(y).begin(), image.row(y).end(), value);
      };
      fill_row(inverse_, 0.0F);
      fill_row(view.color, Rgba8{background.r, background.g, background.b, 0});
      fill_row(view.depth_m, 0.0F);
      fill_row(view.camera, kNoCamera);
      fill_row(view.quality, 0.0F);
    }
    for (BorderRow* const row : {&borders_[tile].first, &borders_[tile].last}) {
      row->nearest.assign(view.width, 0.0F);
      row->color.resize(view.width);
    }
  }

  // Finds the columns of kGapColumns pixels in which a pixel has no fragment in any of the tiles.
  static void find_gaps(std::span<const Tile> tiles, std::vector<std::uint8_t>& gaps) {
    const Tile& first = tiles[0];
    gaps.assign((first.width() + kGapColumns - 1) / kGapColumns, 0);
    for (int y = first.top(); y < first.top() + first.rows(); ++y) {
      for (int x = 0; x < first.width(); x += kLanes) {
        Ints empty = ramp() < static_cast<float>(first.width() - x);
        for (const Tile& tile : tiles) empty &= load<Floats>(tile.depths(y) + x) <= tile.empty();
        if (bits(empty)) gaps[x / kGapColumns] = 1;
      }
    }
  }

  static bool reaches_gap(const PatchExtent& extent, std::span<const std::uint8_t> gaps) {
    if (!extent.in_front) return true;
    const auto column = [&](float x) {
      const auto last = static_cast<float>(gaps.size() - 1);
      return static_cast<std::size_t>(std::clamp(x / kGapColumns, 0.0F, last));
    };
    // The margin of one pixel allows for the tolerance of the rasteriser.
    const std::size_t left = column(extent.left - 1), right = column(extent.right + 1);
    return std::any_of(gaps.begin() + left, gaps.begin() + right + 1,
                       [](std::uint8_t gap) { return gap != 0; });
  }

  static void give_way(std::span<const MergeCamera> cameras, std::span<Tile> tiles) {
    for (std::size_t i = 0; i < tiles.size(); ++i) {
      for (std::size_t other = 0; other < tiles.size(); ++other) {
        if (cameras[other].rank < cameras[i].rank) tiles[i].give_way_to(tiles[other]);
      }
    }
  }

  // The number of pixels that show a remembered background. Requires give_way().
  static std::size_t count_remembered(std::span<const MergeCamera> cameras, std::span<const Tile> tiles) {
    std::vector<const Tile*> remembered;
    for (std::size_t i = 0; i < tiles.size(); ++i) {
      if (cameras[i].rank == Rank::kRemembered) remembered.push_back(&tiles[i]);
    }
    if (remembered.empty()) return 0;
    std::size_t pixels = 0;
    const Tile& first = *remembered[0];
    int left = first.left(), right = first.right();
    for (const Tile* tile : remembered) {
      left = std::min(left, tile->left());
      right = std::max(right, tile->right());
    }
    for (int y = first.top(); y < first.top() + first.rows(); ++y) {
      for (int x = left / kLanes * kLanes; x < right; x += kLanes) {
        Ints shown{};
        for (const Tile* tile : remembered) shown |= load<Floats>(tile->depths(y) + x) > tile->empty();
        shown &= ramp() < static_cast<float>(first.width() - x);
        pixels += static_cast<std::size_t>(std::popcount(bits(shown)));
      }
    }
    return pixels;
  }

  Executor& workers_;
  CpuRendererSettings settings_;
  std::vector<ProjectedSurface> surfaces_;
  std::vector<MergeCamera> merge_cameras_;
  std::vector<Scratch> scratch_;  // By worker.
  UnseenStyle style_;
  MergeMode merge_ = MergeMode::kBlend;
  BackgroundExtension extension_;
  std::vector<CameraPictures> pictures_;
  InverseDepthView inverse_;    // Inverse depths of the nearest fragments; used if surfaces are extended.
  std::vector<Pixels> pixels_;  // By tile.
  std::vector<TileBorders> borders_;  // By tile.
};

}  // namespace

std::unique_ptr<Renderer> make_cpu_renderer(Executor& workers, const CpuRendererSettings& settings) {
  return std::make_unique<CpuRenderer>(workers, settings);
}

}  // namespace copresence::renderer
