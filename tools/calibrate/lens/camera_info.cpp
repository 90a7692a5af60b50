#include "tools/calibrate/lens/camera_info.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <optional>
#include <span>
#include <vector>

namespace copresence::calibrate {
namespace {

// Reads one file; the first thing that is wrong stays.
class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : path_(path) {}

  const std::optional<Error>& error() const { return error_; }

  YAML::Node key(const YAML::Node& node, const char* name) {
    if (node.IsMap() && node[name]) return node[name];
    wrong(node, fmt::format("\"{}\" is missing", name));
    return {};
  }

  template <class Value>
  Value value(const YAML::Node& node, const char* name) {
    const YAML::Node found = error_ ? YAML::Node() : key(node, name);
    Value out{};
    if (!error_ && !YAML::convert<Value>::decode(found, out)) {
      wrong(found, fmt::format("\"{}\" is not what it should be", name));
    }
    return out;
  }

  /// The numbers of `{rows: .., cols: .., data: [..]}`.
  std::vector<double> numbers(const YAML::Node& node, const char* name) {
    const YAML::Node matrix = error_ ? YAML::Node() : key(node, name);
    return error_ ? std::vector<double>() : value<std::vector<double>>(matrix, "data");
  }

  void wrong(const YAML::Node& where, const std::string& what) {
    if (error_) return;
    error_ = Error{ErrorCode::kCorrupt,
                   fmt::format("{}:{}: {}", path_.string(),
                               where.IsDefined() ? std::max(1, where.Mark().line + 1) : 1, what)};
  }

 private:
  const std::filesystem::path& path_;
  std::optional<Error> error_;
};

CameraInfo read(Reader& reader, const YAML::Node& root) {
  CameraInfo camera;
  camera.name = root.IsMap() && root["camera_name"] ? reader.value<std::string>(root, "camera_name") : "";
  CameraModel& model = camera.model;
  model.width = reader.value<int>(root, "image_width");
  model.height = reader.value<int>(root, "image_height");
  const auto k = reader.numbers(root, "camera_matrix");
  const auto d = reader.numbers(root, "distortion_coefficients");
  const auto kind = reader.value<std::string>(root, "distortion_model");
  if (reader.error()) return camera;
  if (k.size() != 9) {
    reader.wrong(root["camera_matrix"], "\"camera_matrix\" must have nine numbers");
    return camera;
  }
  const bool fits = (kind == "rational_polynomial" && d.size() == 8) ||
                    (kind == "plumb_bob" && (d.size() == 4 || d.size() == 5));
  if (!fits) {
    reader.wrong(root["distortion_model"],
                 "the distortion must be rational_polynomial with eight numbers, or "
                 "plumb_bob with four or five");
    return camera;
  }
  model.fx = k[0];
  model.cx = k[2];
  model.fy = k[4];
  model.cy = k[5];
  std::copy(d.begin(), d.end(), model.distortion.begin());
  if (const auto checked = check(model); !checked) reader.wrong(root, checked.error().what);
  return camera;
}

std::string matrix(int rows, int columns, std::span<const double> data) {
  return fmt::format("\n  rows: {}\n  cols: {}\n  data: [{}]\n", rows, columns, fmt::join(data, ", "));
}

}  // namespace

std::string to_camera_info(const CameraInfo& camera) {
  const CameraModel& m = camera.model;
  const std::array k{m.fx, 0.0, m.cx, 0.0, m.fy, m.cy, 0.0, 0.0, 1.0};
  const std::array r{1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  const std::array p{m.fx, 0.0, m.cx, 0.0, 0.0, m.fy, m.cy, 0.0, 0.0, 0.0, 1.0, 0.0};
  YAML::Emitter name;
  name << YAML::DoubleQuoted << camera.name;
  return fmt::format("image_width: {}\nimage_height: {}\ncamera_name: {}\ncamera_matrix:{}", m.width,
                     m.height, name.c_str(), matrix(3, 3, k)) +
         "distortion_model: rational_polynomial\ndistortion_coefficients:" + matrix(1, 8, m.distortion) +
         "rectification_matrix:" + matrix(3, 3, r) + "projection_matrix:" + matrix(3, 4, p);
}

Result<CameraInfo> parse_camera_info(const std::string& text, const std::filesystem::path& path) {
  try {
    const YAML::Node root = YAML::Load(text);
    Reader reader(path);
    const CameraInfo camera = read(reader, root);
    if (reader.error()) return fail(*reader.error());
    return camera;
  } catch (const YAML::Exception& error) {
    return fail(ErrorCode::kCorrupt, fmt::format("{}:{}: {}", path.string(), error.mark.line + 1, error.msg));
  }
}

Result<CameraInfo> load_camera_info(const std::filesystem::path& path) {
  std::error_code ignored;
  std::ifstream file;
  if (std::filesystem::is_regular_file(path, ignored)) file.open(path, std::ios::binary);
  if (!file.is_open()) {
    return fail(ErrorCode::kNotFound, fmt::format("{}: cannot be read as camera_info", path.string()));
  }
  return parse_camera_info(std::string{std::istreambuf_iterator<char>(file), {}}, path);
}

Result<void> save_camera_info(const CameraInfo& camera, const std::filesystem::path& path) {
  std::ofstream file(path, std::ios::binary);
  file << to_camera_info(camera) << std::flush;
  if (!file) return fail(ErrorCode::kUnavailable, fmt::format("{}: cannot be written", path.string()));
  return {};
}

}  // namespace copresence::calibrate
