#include "tools/calibrate/lens/still_board.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace copresence::calibrate {
namespace {

constexpr double kStillPx = 1.5;    // a corner's distance from its mean
constexpr double kCornerPx = 0.15;  // what a corner detector leaves

}  // namespace

Result<StillBoard> find_still_board(const Board& board, std::span<const ColorImage> pictures,
                                    const CameraModel& model) {
  std::vector<BoardView> views;
  for (const ColorImage& picture : pictures) {
    if (auto view = find_board(board, picture, "the board's picture")) views.push_back(std::move(*view));
  }
  if (views.empty()) {
    const std::string instead = pictures.empty() ? "" : board_seen_instead(board, pictures.front());
    return fail(ErrorCode::kNotFound,
                "no picture shows the whole board: is its size in inner corners as given?" +
                    (instead.empty() ? "" : " (" + instead + ")"));
  }
  StillBoard still;
  still.view = views[0];
  for (std::size_t i = 0; i < still.view.pixels.size(); ++i) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const BoardView& view : views) sum += view.pixels[i];
    still.view.pixels[i] = sum / static_cast<double>(views.size());
    for (const BoardView& view : views) {
      if ((view.pixels[i] - still.view.pixels[i]).norm() > kStillPx) {
        return fail(ErrorCode::kInvalid, "the board moved while it was recorded: hold it still");
      }
    }
  }
  auto pose = locate_board(still.view, model);
  if (!pose) return fail(pose.error());
  still.pose = std::move(*pose);
  return still;
}

std::optional<double> size_over_depth(const StillBoard& still, const Board& board,
                                      const calibration::DepthAverage& depth, const CameraModel& model) {
  const auto columns = static_cast<std::size_t>(board.columns);
  const std::vector<Eigen::Vector2d>& corners = still.view.pixels;
  const std::size_t last = corners.size() - 1;
  const std::vector<Eigen::Vector2d> outline{corners[0], corners[columns - 1], corners[last],
                                             corners[last - (columns - 1)]};
  const auto plane = calibration::fit_plane(depth, model, outline);
  if (!plane) return std::nullopt;
  const Eigen::Vector2d opposite = 0.5 * (still.view.on_board[0] + still.view.on_board[last]);
  const Eigen::Vector3d middle =
      still.pose.camera_from_board * Eigen::Vector3d(opposite.x(), opposite.y(), 0);
  return middle.z() / plane->z_along(middle.head<2>() / middle.z());
}

std::vector<calibration::Sighting> sightings_of(std::size_t camera, const StillBoard& board,
                                                const CameraModel& model) {
  double extent_px = 1;
  for (const Eigen::Vector2d& pixel : board.view.pixels) {
    extent_px = std::max(extent_px, (pixel - board.view.pixels[0]).norm());
  }
  // The board's distance is as uncertain as its size in the picture, and all corners share that error.
  const double relative =
      2 * kCornerPx / extent_px * std::sqrt(static_cast<double>(board.view.pixels.size()));
  std::vector<calibration::Sighting> sightings;
  for (std::size_t i = 0; i < board.view.pixels.size(); ++i) {
    const Eigen::Vector2d& on_board = board.view.on_board[i];
    calibration::Sighting sighting;
    sighting.camera = camera;
    sighting.marker = i;
    sighting.ray = unproject(model, board.view.pixels[i], 1).head<2>();
    sighting.z_m = (board.pose.camera_from_board * Eigen::Vector3d(on_board.x(), on_board.y(), 0)).z();
    sighting.ray_sigma = kCornerPx / model.fx;
    sighting.inverse_z_sigma = relative / sighting.z_m;
    sightings.push_back(sighting);
  }
  return sightings;
}

}  // namespace copresence::calibrate
