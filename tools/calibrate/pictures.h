#pragma once

// Pictures that show a result: the corners of a board, markers, and the agreement of surfaces.
// Thread: pure functions; one thread per object.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "common/frame/image.h"
#include "common/frame/rigid3.h"
#include "common/result.h"
#include "tools/calibrate/geometry/world_fit.h"
#include "tools/calibrate/intrinsics/intrinsics_fit.h"
#include "tools/calibrate/markers/marker_observations.h"
#include "tools/calibrate/refinement/surface.h"

namespace copresence::calibrate {

/// Validator for CLI::Option::check(): accepts names of PNG and JPEG files that can be written. All
/// writers below require such a name, and fail with kUnavailable if the file cannot be written.
CLI::Validator picture_file_name();

/// Collects pictures of a board, scaled down: full pictures would need too much memory.
class BoardPictures {
 public:
  void add(const BoardView& view, const ColorImage& picture);

  /// Shows up to 23 views that the fit used, the worst first, each with its corners and its error
  /// in pixels. The last tile shows the area that the corners of all views cover.
  Result<void> write(const IntrinsicsFit& fit, const std::filesystem::path& file) const;

 private:
  struct Small {
    ColorImage picture;
    std::vector<Eigen::Vector2d> corners;  // Corners in pixels of the small picture.
  };
  std::map<std::string, Small> pictures_;
};

/// The markers that one camera found.
struct MarkedPicture {
  std::string camera;
  ColorImage picture;
  std::vector<FoundMarker> markers;
  std::vector<MarkerDepth> depths;
};

/// Shows the cameras' pictures, two per row. Each marker has an outline, its name, its distance,
/// and the distance between this camera's measurement and the common position. Colours: green up to
/// 10 mm, yellow up to 30 mm, red above 30 mm or if unused.
Result<void> write_marked_pictures(std::span<const MarkedPicture> cameras, const RigNames& names,
                                   std::span<const Observation> observations, const WorldFit& fit,
                                   const std::filesystem::path& file);

/// One camera's surface, to be compared with that of another. The caller keeps both alive.
struct SurfaceComparison {
  std::string label;
  const Surface& surface;
  Rigid3 world_from_camera;
  const Surface& other;
  Rigid3 world_from_other;
};

inline constexpr double kFullColor_mm = 20;

/// Shows comparisons, two per row, with a colour scale. Green: both cameras see the surface at the
/// same position. Red: the other camera's surface is kFullColor_mm or more behind. Blue: the other
/// camera's surface is in front. Pink: the other camera sees through the surface. Grey: the other
/// camera does not see the surface.
Result<void> write_agreement_picture(std::span<const SurfaceComparison> all,
                                     const std::filesystem::path& file);

}  // namespace copresence::calibrate
