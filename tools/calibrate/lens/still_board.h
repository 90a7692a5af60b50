#pragma once

// One board held still before several cameras (thesis 2.5.2): each locates it by itself, from its known size. Only for
// cameras that see it well at the same time; the board's corners then serve as markers. Thread: pure functions.

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "tools/calibrate/geometry/plane_depth.h"
#include "tools/calibrate/geometry/sighting.h"
#include "tools/calibrate/lens/lens_fit.h"

namespace copresence::calibrate {

struct StillBoard {
  BoardView view;  ///< corners where they lie in the mean of the pictures
  ViewFit pose;
};

/// Fails  kNotFound: the whole board is in none of the pictures; kInvalid: it moved, or cannot be located.
Result<StillBoard> find_still_board(const Board& board, std::span<const ColorImage> pictures,
                                    const CameraModel& model);

/// How far away the board lies by its size, as a multiple of the depth measured there: 1 where the squares are as large
/// as `board` says. Nothing where depth shows no plane.
std::optional<double> size_over_depth(const StillBoard& still, const Board& board,
                                      const calibration::DepthAverage& depth, const CameraModel& model);

/// Its corners, in order, as markers 0, 1, 2, ...
std::vector<calibration::Sighting> sightings_of(std::size_t camera, const StillBoard& board,
                                                const CameraModel& model);

}  // namespace copresence::calibrate
