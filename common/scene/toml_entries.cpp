#include "common/scene/toml_entries.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace copresence::scene {
namespace {

namespace fs = std::filesystem;

// Writes the fewest digits that read back as the same number, with a decimal point or an exponent.
template <class Number>
std::string exact(Number value) {
  std::string text = fmt::format("{}", value + Number{0});  // Adding 0 turns -0 into 0.
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

template <class Range>
std::string list(const Range& numbers) {
  std::vector<std::string> texts;
  for (const auto number : numbers) texts.push_back(exact(number));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

std::string pose(const Rigid3& transform) {
  const Eigen::Matrix4d m = transform.matrix().array() + 0.0;
  std::string text;
  for (int r = 0; r < 4; ++r) {
    text += fmt::format("{}[{:.12g}, {:.12g}, {:.12g}, {:.12g}]", r == 0 ? "" : ", ", m(r, 0), m(r, 1),
                        m(r, 2), m(r, 3));
  }
  return "[" + text + "]";
}

std::string color_affine(const Eigen::Matrix<float, 3, 4>& m) {
  std::vector<std::string> rows;
  for (int r = 0; r < 3; ++r) rows.push_back(list(std::array{m(r, 0), m(r, 1), m(r, 2), m(r, 3)}));
  return fmt::format("[{}]", fmt::join(rows, ", "));
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (byte < 0x20 || byte == 0x7F) {
      out += fmt::format("\\u{:04X}", byte);
    } else {
      out += c;
    }
  }
  return out + '"';
}

std::optional<std::string> distortion(const CameraModel& model) {
  if (!model.is_distorted()) return std::nullopt;
  return list(model.distortion);
}

std::string color_camera(const ColorCamera& color) {
  const CameraModel& m = color.model;
  return fmt::format(
      "{{ width = {}, height = {}, fx = {}, fy = {}, cx = {}, cy = {}, {}color_from_depth = {} }}", m.width,
      m.height, exact(m.fx), exact(m.fy), exact(m.cx), exact(m.cy),
      m.is_distorted() ? fmt::format("distortion = {}, ", list(m.distortion)) : "",
      pose(color.color_from_depth));
}

std::string source_text(const std::string& source, const fs::path& folder) {
  return is_path(source) ? path_text(source, folder) : quoted(source);
}

}  // namespace

bool is_path(std::string_view source) {
  const auto is_of_scheme = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); };
  const auto end = std::find_if_not(source.begin(), source.end(), is_of_scheme);
  const bool has_scheme = end != source.begin() && end != source.end() && *end == ':';
  return !source.empty() && !has_scheme;
}

std::vector<Entry> entries(const Camera& camera, const fs::path& folder) {
  const auto where = [](bool there, auto&& text) { return there ? std::optional(text()) : std::nullopt; };
  const CameraModel& m = camera.model;
  return {
      {"name", quoted(camera.name)},
      {"address", where(!camera.address.empty(), [&] { return quoted(camera.address); })},
      {"width", std::to_string(m.width)},
      {"height", std::to_string(m.height)},
      {"fx", exact(m.fx)},
      {"fy", exact(m.fy)},
      {"cx", exact(m.cx)},
      {"cy", exact(m.cy)},
      {"distortion", distortion(m)},
      {"world_from_camera",
       where(camera.world_from_camera.has_value(), [&] { return pose(*camera.world_from_camera); })},
      {"source", where(!camera.source.empty(), [&] { return source_text(camera.source, folder); })},
      {"color", where(camera.color.has_value(), [&] { return color_camera(*camera.color); })},
      {"color_matching",
       where(camera.color_matching.has_value(), [&] { return color_affine(*camera.color_matching); })},
      {"calibration_error_mm",
       where(camera.calibration_error_mm.has_value(), [&] { return exact(*camera.calibration_error_mm); })},
  };
}

std::array<std::pair<std::string, std::string>, 2> entries(const Box& clip) {
  return {{{"min", toml_text(clip.min)}, {"max", toml_text(clip.max)}}};
}

std::string path_text(const std::string& path, const fs::path& folder) {
  if (fs::path(path).is_absolute()) return quoted(path);
  std::error_code ignored;
  const fs::path here = fs::current_path(ignored);
  const fs::path from = (here / folder).lexically_normal();
  return quoted((here / path).lexically_normal().lexically_proximate(from).string());
}

std::string toml_text(const Eigen::Vector3d& v) {
  return list(std::array{v.x(), v.y(), v.z()});
}

}  // namespace copresence::scene
