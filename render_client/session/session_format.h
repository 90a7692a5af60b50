#pragma once

// The names by which a session recording connects tracks and stream descriptions. A stream has a
// label, which is the name of its camera. The track of depth is called LABEL depth, the track of
// colour LABEL colour, and the attached stream description LABEL.stream. If a label is taken, the
// next stream gets "LABEL (2)" and so on. See docs/internals/session_recording.md. Private to this
// module.

#include <string>
#include <string_view>

namespace copresence::session {

inline constexpr std::string_view kDepthSuffix = " depth", kColorSuffix = " colour",
                                  kDescriptionSuffix = ".stream";

inline std::string depth_track_name(const std::string& label) {
  return label + std::string(kDepthSuffix);
}
inline std::string color_track_name(const std::string& label) {
  return label + std::string(kColorSuffix);
}
inline std::string description_name(const std::string& label) {
  return label + std::string(kDescriptionSuffix);
}

}  // namespace copresence::session
