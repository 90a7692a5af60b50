#pragma once

// Lets a person click markers in a window, as in thesis 3.1. Reads and writes files of clicks.
// A file has one line per marker and camera: `camera marker x y`, in pixels. # begins a comment.

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/frame/image.h"
#include "common/result.h"
#include "tools/calibrate/markers/marker_finder.h"

namespace copresence::calibrate {

/// Clicked markers by camera name.
using Clicks = std::map<std::string, std::vector<FoundMarker>>;

/// Standard deviation of a click, pixels.
inline constexpr double kClickSigma = 1.5;

/// Fails with kNotFound if there is no such file. Fails with kInvalid and `FILE:LINE: message` for
/// a line of another form, or a marker that occurs twice in one camera.
Result<Clicks> load_clicks(const std::filesystem::path& file);

/// Fails with kUnavailable if the file cannot be written.
Result<void> save_clicks(const Clicks& clicks, const std::filesystem::path& file);

/// Shows a camera's picture in a window and waits for clicks. The markers are named click1, click2
/// and so on; printed markers have other names. The space bar skips a marker that this camera does
/// not see. Backspace removes the last click, and return ends.
/// Fails with kUnavailable if no window can be opened, and with kRefused if the user closes it.
Result<std::vector<FoundMarker>> ask_for_clicks(const std::string& camera, const ColorImage& picture);

class ClickList {
 public:
  void click(double x, double y);
  void skip() { places_.push_back(std::nullopt); }
  void undo() {
    if (!places_.empty()) places_.pop_back();
  }
  int next() const { return static_cast<int>(places_.size()) + 1; }  ///< Number of the marker to click next.
  std::vector<FoundMarker> markers() const;

 private:
  std::vector<std::optional<Eigen::Vector2d>> places_;
};

}  // namespace copresence::calibrate
