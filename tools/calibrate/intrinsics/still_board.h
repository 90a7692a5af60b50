#pragma once

// Finds poses from a board that stands still in view of several cameras (thesis 2.5.2). Each camera
// locates the board by its known size. The corners serve as markers. Thread: pure functions.

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "tools/calibrate/geometry/observation.h"
#include "tools/calibrate/geometry/plane_depth.h"
#include "tools/calibrate/intrinsics/intrinsics_fit.h"

namespace copresence::calibrate {

struct StillBoard {
  BoardView view;  ///< The board's corners, averaged over all pictures.
  ViewFit pose;
};

/// Fails with kNotFound if no picture shows the whole board. Fails with kInvalid if the board moved
/// or has no pose.
Result<StillBoard> find_still_board(const Board& board, std::span<const ColorImage> pictures,
                                    const CameraModel& model);

/// Returns the board's distance computed from its size, divided by its measured depth. This ratio
/// is 1 if the squares have the size in `board`. Returns nothing if the measured depth is not
/// planar.
std::optional<double> size_over_depth(const StillBoard& still, const Board& board, const DepthAverage& depth,
                                      const CameraModel& model);

/// The corners, in order, as observations of the markers 0, 1, 2, ...
std::vector<Observation> observations_of(std::size_t camera, const StillBoard& board,
                                         const CameraModel& model);

}  // namespace copresence::calibrate
