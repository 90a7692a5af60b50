#pragma once

// Markers pointed at by a person, as in thesis 3.1: in a window, or in a file that an earlier session left.
//
// The file has one line per marker and camera, `camera marker x y`, pixels; # begins a comment.

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/frame/image.h"
#include "common/result.h"
#include "tools/calibrate/markers/found_marker.h"

namespace copresence::calibrate {

/// Camera's name -> its markers.
using Clicks = std::map<std::string, std::vector<FoundMarker>>;

/// Standard deviation of a click, pixels.
inline constexpr double kClickSigma = 1.5;

/// Fails  kNotFound, or kInvalid with `FILE:LINE: what`: a line of another form, one marker twice in one camera.
Result<Clicks> load_clicks(const std::filesystem::path& file);

/// Fails  kUnavailable where the file cannot be written.
Result<void> save_clicks(const Clicks& clicks, const std::filesystem::path& file);

/// Shows a camera's picture in a window and waits for clicks: the first is marker click1, the next click2, and so
/// on, names that no printed marker has; the space bar leaves out a marker that this camera does not see, backspace takes the last one back, return ends.
/// Fails  kUnavailable where no window can be opened, kRefused when it is closed.
Result<std::vector<FoundMarker>> ask_for_clicks(const std::string& camera, const ColorImage& picture);

/// The state behind that window, without the window.
class ClickList {
 public:
  void click(double x, double y);
  void skip() { places_.push_back(std::nullopt); }
  void undo() {
    if (!places_.empty()) places_.pop_back();
  }
  int next() const {
    return static_cast<int>(places_.size()) + 1;
  }  ///< number of the marker that is asked for
  std::vector<FoundMarker> markers() const;

 private:
  std::vector<std::optional<Eigen::Vector2d>> places_;
};

}  // namespace copresence::calibrate
