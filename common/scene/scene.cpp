#include "common/scene/scene.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>

#include "common/scene/toml_entries.h"
#include "common/text/excerpt.h"
#include "common/text/text_file.h"
#include "common/toml/parse_toml.h"

namespace copresence::scene {
namespace {

// Largest distance of a camera from the origin along each axis, in metres, as in a stream.
constexpr double kFarthestM = 10'000;
// Limits in bytes. A name has the same limit as capture_server's --name.
constexpr std::size_t kMostOfAName = 64, kMostOfAnAddress = 300, kMostOfASource = 1024, kMostOfAPath = 1024;

// Reads the tables of one file. Only the first error is kept.
class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : path_(path) {}

  const std::optional<Error>& error() const { return error_; }

  void wrong(const toml::node& where, const std::string& what) {
    if (error_) return;
    error_ =
        Error{ErrorCode::kInvalid, fmt::format("{}:{}: {}", path_.string(), where.source().begin.line, what)};
  }

  void only_keys(const toml::table& table, std::initializer_list<std::string_view> known) {
    for (const auto& [key, value] : table) {
      if (std::find(known.begin(), known.end(), key.str()) == known.end()) {
        wrong(value, fmt::format("unknown key \"{}\"; known here are {}", text::excerpt(key.str()),
                                 fmt::join(known, ", ")));
      }
    }
  }

  std::optional<double> number(const toml::table& table, std::string_view key) {
    const toml::node* node = table.get(key);
    return node ? number(*node, key) : std::nullopt;
  }

  double required_number(const toml::table& table, std::string_view key) {
    const toml::node* node = table.get(key);
    if (!node) wrong(table, fmt::format("\"{}\" is missing", key));
    return node ? number(*node, key).value_or(0) : 0;
  }

  std::string text(const toml::table& table, std::string_view key, std::size_t most_bytes) {
    const toml::node* node = table.get(key);
    if (!node) return {};
    const auto value = node->value_exact<std::string>();
    if (!value) wrong(*node, fmt::format("\"{}\" must be a text in quotes", key));
    if (value && value->size() > most_bytes) {
      wrong(*node, fmt::format("\"{}\" has {} bytes; {} are allowed", key, value->size(), most_bytes));
      return {};
    }
    return value.value_or("");
  }

  /// Reads a list of kCount numbers. Returns nothing if the key is missing.
  template <std::size_t kCount>
  std::optional<std::array<double, kCount>> numbers(const toml::table& table, std::string_view key) {
    const toml::node* node = table.get(key);
    return node ? numbers<kCount>(*node, key) : std::nullopt;
  }

  /// Reads kRows lists of kColumns numbers. Returns nothing if the key is missing.
  template <int kRows, int kColumns>
  std::optional<Eigen::Matrix<double, kRows, kColumns>> matrix(const toml::table& table,
                                                               std::string_view key) {
    const toml::node* node = table.get(key);
    if (!node) return std::nullopt;
    const toml::array* rows = node->as_array();
    if (!rows || rows->size() != kRows) {
      wrong(*node, fmt::format("\"{}\" must be {} rows of {} numbers", key, kRows, kColumns));
      return std::nullopt;
    }
    Eigen::Matrix<double, kRows, kColumns> m;
    for (int r = 0; r < kRows; ++r) {
      const auto row = numbers<kColumns>(*rows->get(static_cast<std::size_t>(r)), key);
      if (!row) return std::nullopt;
      for (int c = 0; c < kColumns; ++c) m(r, c) = (*row)[static_cast<std::size_t>(c)];
    }
    return m;
  }

  std::optional<Rigid3> pose(const toml::table& table, std::string_view key) {
    const auto m = matrix<4, 4>(table, key);
    if (!m) return std::nullopt;
    const Rigid3 rigid{m->topLeftCorner<3, 3>(), m->topRightCorner<3, 1>()};
    // Many people and tools write few digits, so the nearest rotation is used.
    constexpr double kRounding = 0.01;
    if (!rigid.is_rigid(kRounding) || m->row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
      wrong(*table.get(key),
            fmt::format("\"{}\" is not a rigid transform: its upper left 3x3 must be a rotation and "
                        "its last row 0 0 0 1",
                        key));
      return std::nullopt;
    }
    if (rigid.translation.cwiseAbs().maxCoeff() > kFarthestM) {
      wrong(*table.get(key),
            fmt::format("\"{}\" is more than {:g} m away from the origin: poses are in metres", key,
                        kFarthestM));
      return std::nullopt;
    }
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(rigid.rotation, Eigen::ComputeFullU | Eigen::ComputeFullV);
    return Rigid3{svd.matrixU() * svd.matrixV().transpose(), rigid.translation};
  }

  CameraModel model(const toml::table& table) {
    CameraModel camera;
    camera.width = size(table, "width");
    camera.height = size(table, "height");
    camera.fx = required_number(table, "fx");
    camera.fy = required_number(table, "fy");
    camera.cx = required_number(table, "cx");
    camera.cy = required_number(table, "cy");
    if (const toml::node* node = table.get("distortion")) {
      const toml::array* list = node->as_array();
      if (!list || list->size() > camera.distortion.size()) {
        wrong(*node, "\"distortion\" must be a list of up to eight numbers: k1 k2 p1 p2 k3 k4 k5 k6");
      } else {
        for (std::size_t i = 0; i < list->size(); ++i) {
          camera.distortion[i] = number(*list->get(i), "distortion").value_or(0);
        }
      }
    }
    if (const auto checked = check(camera); !checked) wrong(table, checked.error().what);
    return camera;
  }

 private:
  std::optional<double> number(const toml::node& node, std::string_view key) {
    const auto value = node.value<double>();
    if (!value || !std::isfinite(*value)) {
      wrong(node, fmt::format("\"{}\" must be a finite number", key));
      return std::nullopt;
    }
    return value;
  }

  template <std::size_t kCount>
  std::optional<std::array<double, kCount>> numbers(const toml::node& node, std::string_view key) {
    const toml::array* list = node.as_array();
    if (!list || list->size() != kCount) {
      wrong(node, fmt::format("\"{}\" must have {} numbers here", key, kCount));
      return std::nullopt;
    }
    std::array<double, kCount> out{};
    for (std::size_t i = 0; i < kCount; ++i) {
      const auto value = number(*list->get(i), key);
      if (!value) return std::nullopt;
      out[i] = *value;
    }
    return out;
  }

  int size(const toml::table& table, std::string_view key) {
    const double value = required_number(table, key);
    return value >= 0 && value <= 65536 && value == std::floor(value) ? static_cast<int>(value) : 0;
  }

  const std::filesystem::path& path_;
  std::optional<Error> error_;
};

Camera read_camera(Reader& reader, const toml::table& table, const std::filesystem::path& folder) {
  reader.only_keys(table, {"name", "address", "width", "height", "fx", "fy", "cx", "cy", "distortion",
                           "world_from_camera", "source", "color", "color_matching", "calibration_error_mm"});
  Camera camera;
  camera.name = reader.text(table, "name", kMostOfAName);
  if (camera.name.empty()) reader.wrong(table, "a [[camera]] needs a \"name\"");
  camera.address = reader.text(table, "address", kMostOfAnAddress);
  camera.model = reader.model(table);
  camera.world_from_camera = reader.pose(table, "world_from_camera");
  camera.source = reader.text(table, "source", kMostOfASource);
  if (is_path(camera.source)) camera.source = (folder / camera.source).lexically_normal().string();
  if (const toml::node* node = table.get("color")) {
    const toml::table* color = node->as_table();
    if (!color) {
      reader.wrong(*node, "\"color\" must be a table: { width = ..., height = ..., fx = ..., ... }");
    } else {
      reader.only_keys(*color, {"width", "height", "fx", "fy", "cx", "cy", "distortion", "color_from_depth"});
      camera.color =
          ColorCamera{reader.model(*color), reader.pose(*color, "color_from_depth").value_or(Rigid3{})};
    }
  }
  if (const auto m = reader.matrix<3, 4>(table, "color_matching")) camera.color_matching = m->cast<float>();
  camera.calibration_error_mm = reader.number(table, "calibration_error_mm");
  if (camera.calibration_error_mm && *camera.calibration_error_mm < 0) {
    reader.wrong(*table.get("calibration_error_mm"), "\"calibration_error_mm\" must not be negative");
  }
  return camera;
}

void read_clip(Reader& reader, const toml::table& table, Scene& scene) {
  reader.only_keys(table, {"min", "max"});
  const auto min = reader.numbers<3>(table, "min"), max = reader.numbers<3>(table, "max");
  if (!min || !max) return reader.wrong(table, "[clip] needs \"min\" and \"max\"");
  scene.clip =
      Box{Eigen::Map<const Eigen::Vector3d>(min->data()), Eigen::Map<const Eigen::Vector3d>(max->data())};
  if ((scene.clip->min.array() >= scene.clip->max.array()).any()) {
    reader.wrong(table, "[clip] must have each \"min\" below its \"max\"");
  }
}

Scene read_scene(Reader& reader, const toml::table& root, const std::filesystem::path& folder) {
  reader.only_keys(root, {"up", "key", "camera", "clip"});
  Scene scene;
  if (const auto up = reader.numbers<3>(root, "up")) {
    scene.up = Eigen::Map<const Eigen::Vector3d>(up->data());
    const double longest = scene.up.cwiseAbs().maxCoeff();
    if (longest < 1e-9) reader.wrong(*root.get("up"), "\"up\" must not be zero");
    scene.up = (scene.up / longest).normalized();  // The squares of large numbers would overflow.
  }
  scene.key = reader.text(root, "key", kMostOfAPath);
  if (!scene.key.empty()) scene.key = (folder / scene.key).lexically_normal().string();
  if (const toml::node* node = root.get("camera")) {
    const toml::array* cameras = node->as_array();
    if (!cameras || !cameras->is_array_of_tables()) {
      reader.wrong(*node, "cameras are written as [[camera]] tables");
    } else {
      for (const auto& entry : *cameras) {
        Camera camera = read_camera(reader, *entry.as_table(), folder);
        if (scene.find(camera.name)) {
          reader.wrong(entry, fmt::format("a second camera is called \"{}\"", camera.name));
        }
        scene.cameras.push_back(std::move(camera));
      }
    }
  }
  if (const toml::node* node = root.get("clip")) {
    if (const toml::table* table = node->as_table()) {
      read_clip(reader, *table, scene);
    } else {
      reader.wrong(*node, "[clip] must be a table");
    }
  }
  return scene;
}

}  // namespace

const Camera* Scene::find(std::string_view name) const {
  const auto found =
      std::find_if(cameras.begin(), cameras.end(), [&](const Camera& camera) { return camera.name == name; });
  return found == cameras.end() ? nullptr : &*found;
}

Result<Scene> parse(std::string_view text, const std::filesystem::path& path) {
  const auto root = parse_toml(text, path);
  if (!root) return fail(root.error());
  Reader reader(path);
  Scene scene = read_scene(reader, *root, path.parent_path());
  if (reader.error()) return fail(*reader.error());
  if (scene.cameras.empty()) {
    return fail(ErrorCode::kInvalid, fmt::format("{}: no [[camera]] in it", path.string()));
  }
  return scene;
}

Result<Scene> load(const std::filesystem::path& path) {
  const auto text = text::read_text_file(path, "a scene file");
  if (!text) return fail(text.error());
  return parse(*text, path);
}

}  // namespace copresence::scene
