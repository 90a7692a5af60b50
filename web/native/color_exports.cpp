// Colour matching between the cameras, for a worker of its own.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/wire/message_codec.h"
#include "render_client/color_matching/color_matcher.h"
#include "web/native/exports.h"

namespace copresence::web {
namespace {

struct MatchedCamera {
  std::optional<StreamDescription> stream;
  RgbdFrame frame;
  bool has_frame = false;  // Whether the frame takes part in the next comparison.
};

struct Matching {
  explicit Matching(std::size_t count) : cameras(count), steady(count) {}
  std::vector<MatchedCamera> cameras;
  color_matching::SteadyCorrections steady;
};

std::optional<Matching>& matching() {
  static std::optional<Matching> state;
  return state;
}

}  // namespace

COPRESENCE_EXPORT(begin_matching) int begin_matching(std::uint32_t cameras) {
  matching().emplace(cameras);
  return succeed(JsonObject());
}

// The input is the welcome message of a camera. The result has the memory for its frames. Requires
// begin_matching().
COPRESENCE_EXPORT(set_matched_stream) int set_matched_stream(std::uint32_t bytes, std::uint32_t number) {
  const auto welcome = wire::decode_welcome(input(bytes).subspan(wire::kHeaderBytes));
  if (!welcome) return fail_with(welcome.error());
  MatchedCamera& camera = matching()->cameras[number];
  camera.stream = welcome->description;
  camera.has_frame = false;
  const int width = camera.stream->model.width, height = camera.stream->model.height;
  camera.frame.depth.resize(width, height);
  camera.frame.state.resize(width, height);
  ColorImage& colors = camera.frame.color.emplace();
  colors.resize(width, height);
  return succeed(JsonObject()
                     .add_memory("depth", camera.frame.depth.pixels())
                     .add_memory("states", camera.frame.state.pixels())
                     .add_memory("colors", colors.pixels()));
}

// Says that the memory of a camera has a frame for the next comparison. `rows` are those of its pose.
COPRESENCE_EXPORT(add_matched_frame)
int add_matched_frame(std::uint32_t number, double a, double b, double c, double d, double e, double f,
                      double g, double h, double i, double j, double k, double l) {
  MatchedCamera& camera = matching()->cameras[number];
  Rigid3& pose = camera.frame.metadata.world_from_camera;
  pose.rotation << a, b, c, e, f, g, i, j, k;
  pose.translation << d, h, l;
  camera.has_frame = true;
  return succeed(JsonObject());
}

// Compares the added frames. The result has the rows of each known correction, by camera number.
COPRESENCE_EXPORT(match_colors) int match_colors(double elapsed) {
  Matching& state = *matching();
  std::vector<color_matching::PosedFrame> frames;
  for (MatchedCamera& camera : state.cameras) {
    color_matching::PosedFrame& posed = frames.emplace_back();
    if (!camera.has_frame) continue;
    camera.has_frame = false;
    posed = {&camera.frame, camera.stream->model, camera.stream->unit, camera.stream->noise,
             camera.frame.metadata.world_from_camera};
  }
  state.steady.follow(color_matching::match_colors(frames), instant_of(elapsed).time_since_epoch());
  JsonObject out;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!state.steady.is_known(i)) continue;
    const color_matching::ColorCorrection correction = state.steady.correction(i);
    std::array<double, 12> rows;
    for (int entry = 0; entry < 12; ++entry) rows[entry] = correction(entry / 4, entry % 4);
    out.add(std::to_string(i), std::span<const double>(rows));
  }
  return succeed(out);
}

}  // namespace copresence::web
