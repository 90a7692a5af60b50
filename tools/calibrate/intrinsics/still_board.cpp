#include "tools/calibrate/intrinsics/still_board.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace copresence::calibrate {
namespace {

constexpr double kStillPx = 1.5;    // Largest distance of a corner from its mean.
constexpr double kCornerPx = 0.15;  // Error of a corner detector.

}  // namespace

Result<StillBoard> find_still_board(const Board& board, std::span<const ColorImage> pictures,
                                    const CameraModel& model) {
  std::vector<BoardView> views;
  for (const ColorImage& picture : pictures) {
    if (auto view = find_board(board, picture, "the board's picture")) views.push_back(std::move(*view));
  }
  if (views.empty()) {
    const std::string instead = pictures.empty() ? "" : describe_other_board(board, pictures.front());
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

std::optional<double> size_over_depth(const StillBoard& still, const Board& board, const DepthAverage& depth,
                                      const CameraModel& model) {
  const auto columns = static_cast<std::size_t>(board.columns);
  const std::vector<Eigen::Vector2d>& corners = still.view.pixels;
  const std::size_t last = corners.size() - 1;
  const std::vector<Eigen::Vector2d> outline{corners[0], corners[columns - 1], corners[last],
                                             corners[last - (columns - 1)]};
  const auto plane = fit_plane(depth, model, outline);
  if (!plane) return std::nullopt;
  const Eigen::Vector2d opposite = 0.5 * (still.view.on_board[0] + still.view.on_board[last]);
  const Eigen::Vector3d middle =
      still.pose.camera_from_board * Eigen::Vector3d(opposite.x(), opposite.y(), 0);
  return middle.z() / plane->z_along(middle.head<2>() / middle.z());
}

std::vector<Observation> observations_of(std::size_t camera, const StillBoard& board,
                                         const CameraModel& model) {
  double extent_px = 1;
  for (const Eigen::Vector2d& pixel : board.view.pixels) {
    extent_px = std::max(extent_px, (pixel - board.view.pixels[0]).norm());
  }
  // The board's distance has the same relative error as its size in pixels, at all corners.
  const double relative =
      2 * kCornerPx / extent_px * std::sqrt(static_cast<double>(board.view.pixels.size()));
  std::vector<Observation> observations;
  for (std::size_t i = 0; i < board.view.pixels.size(); ++i) {
    const Eigen::Vector2d& on_board = board.view.on_board[i];
    Observation observation;
    observation.camera = camera;
    observation.marker = i;
    observation.ray = unproject(model, board.view.pixels[i], 1).head<2>();
    observation.z_m = (board.pose.camera_from_board * Eigen::Vector3d(on_board.x(), on_board.y(), 0)).z();
    observation.ray_sigma = kCornerPx / model.fx;
    observation.inverse_z_sigma = relative / observation.z_m;
    observations.push_back(observation);
  }
  return observations;
}

}  // namespace copresence::calibrate
