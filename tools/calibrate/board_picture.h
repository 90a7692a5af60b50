#pragma once

// The board as it was found in each picture, for people: what `intrinsics` works on. Thread: a value.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "common/frame/image.h"
#include "common/result.h"
#include "tools/calibrate/lens/board.h"
#include "tools/calibrate/lens/lens_fit.h"

namespace copresence::calibrate {

/// Collects pictures, small, as they come; they are too many and too large to keep.
class BoardPictures {
 public:
  void add(const BoardView& view, const ColorImage& picture);

  /// At most 24 of the views that the fit used, the worst first, each with its corners and its error in pixels, and
  /// last what all of them cover.
  /// Fails  kInvalid where the name's end is that of no picture, kUnavailable where it cannot be written.
  Result<void> write(const LensFit& fit, const std::filesystem::path& file) const;

 private:
  struct Small {
    ColorImage picture;
    std::vector<Eigen::Vector2d> corners;  // in the small picture's pixels
  };
  std::map<std::string, Small> pictures_;  // by name
};

}  // namespace copresence::calibrate
