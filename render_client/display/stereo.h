#pragma once

// Stereo on an ordinary screen: the eyes of the viewer, and the picture that a 3-D screen or a pair
// of glasses separates again. Thread: pure functions.

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "common/frame/image.h"
#include "render_client/viewpoint/eye.h"

namespace copresence::display {

enum class StereoMode {
  kNone,      ///< One picture, from the middle of the head.
  kSide,      ///< The left half shows the left eye's picture, the right half that of the right eye.
  kTop,       ///< The upper half shows the left eye's picture, the lower half that of the right eye.
  kAnaglyph,  ///< Red is from the left eye, green and blue are from the right eye.
  kRows,      ///< The first, third, ... row shows the left eye's picture, the others the right eye's.
};
inline constexpr std::array kStereoModes = {StereoMode::kNone, StereoMode::kSide, StereoMode::kTop,
                                            StereoMode::kAnaglyph, StereoMode::kRows};

const char* name_of(StereoMode mode);  ///< As --stereo takes it: none, side, top, anaglyph or rows.
std::optional<StereoMode> parse_stereo(std::string_view name);

struct Stereo {
  StereoMode mode = StereoMode::kNone;
  double eye_distance_m = 0.063;  ///< A negative distance exchanges the eyes.
  double screen_distance_m = 2;   ///< Points at this distance appear in the plane of the screen.
};

/// Returns the eyes whose pictures compose() combines, the left one first. The picture of an eye in a
/// half of the display has half as many columns or rows as the display.
std::vector<viewpoint::Eye> eyes_of(const Stereo& stereo);

/// Combines the pictures of eyes_of() to the picture of the display. Requires another mode than
/// kNone and pictures of equal size.
void compose(StereoMode mode, const Image<Rgba8>& left, const Image<Rgba8>& right, Image<Rgba8>& display);

StereoMode next(StereoMode mode);  ///< In the order of kStereoModes, then from the beginning.

}  // namespace copresence::display
