#include "tools/calibrate/intrinsics/camera_info.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace copresence::calibrate {
namespace {

constexpr std::uintmax_t kMostBytes = 1 << 20;  // Largest file size; ROS writes less than 2000 bytes.

// OpenCV's coefficients are k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 tx ty. The camera model uses eight.
constexpr std::size_t kMostCoefficients = 14;

// Keys of ROS (first), OpenCV and Kalibr for the same value.
using RigNames = std::initializer_list<const char*>;
const RigNames kWidth{"image_width", "width"}, kHeight{"image_height", "height"},
    kMatrix{"camera_matrix", "K", "k", "cameraMatrix"},
    kCoefficients{"distortion_coefficients", "D", "d", "distCoeffs"}, kName{"camera_name"};

// Keeps letters and digits in lower case: "Plumb Bob", "plumb_bob" and "plumb-bob" are equal.
std::string plain(const std::string& name) {
  std::string out;
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c))) {
      out += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  return out;
}

bool is_sampled(const std::string& name, std::initializer_list<std::string_view> names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool is_polynomial(const std::string& model) {
  return is_sampled(model, {"", "plumbbob", "rationalpolynomial", "rational", "none", "radtan",
                            "radialtangential", "brown", "brownconrady", "opencv", "pinhole", "perspective"});
}

bool is_fisheye(const std::string& model) {
  return is_sampled(model, {"equidistant", "fisheye", "equi", "kannalabrandt", "kannalabrandt4", "kb4",
                            "opencvfisheye", "omni", "omnidirectional", "mei", "unified", "eucm",
                            "doublesphere", "ds", "fov", "ftheta", "scaramuzza", "stereographic"});
}

// Reads one file and keeps the first error.
class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : path_(path) {}

  const std::optional<Error>& error() const { return error_; }

  /// Returns an undefined node if none of the keys exists.
  static YAML::Node find(const YAML::Node& node, RigNames names) {
    for (const char* name : names) {
      if (node.IsMap() && node[name]) return node[name];
    }
    return YAML::Node(YAML::NodeType::Undefined);
  }

  template <class Value>
  Value value(const YAML::Node& node, RigNames names) {
    const YAML::Node found = find(node, names);
    Value out{};
    if (!found.IsDefined()) {
      wrong(node, fmt::format("\"{}\" is missing", *names.begin()));
    } else if (!YAML::convert<Value>::decode(found, out)) {
      wrong(found, fmt::format("\"{}\" is not what it should be", *names.begin()));
    }
    return out;
  }

  /// Reads `[..]` of ROS messages, or `{rows: .., cols: .., data: [..]}` of ROS and OpenCV files.
  std::vector<double> numbers(const YAML::Node& node, RigNames names) {
    const YAML::Node found = find(node, names);
    if (found.IsDefined() && found.IsMap()) return value<std::vector<double>>(found, {"data"});
    return value<std::vector<double>>(node, names);
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

std::string name_in(const YAML::Node& root) {
  const YAML::Node found = Reader::find(root, kName);
  if (found.IsDefined() && found.IsScalar()) return found.Scalar();
  const YAML::Node header = Reader::find(root, {"header"});  // Only messages have a header.
  if (!header.IsDefined() || !header.IsMap()) return {};
  const YAML::Node frame = Reader::find(header, {"frame_id"});
  return frame.IsDefined() && frame.IsScalar() ? frame.Scalar() : "";
}

// The calibrator of ROS Melodic wrote the distortion model as camera_model. In other files,
// camera_model is "pinhole".
YAML::Node model_in(const YAML::Node& root) {
  const YAML::Node model = Reader::find(root, {"distortion_model"});
  return model.IsDefined() ? model : Reader::find(root, {"camera_model"});
}

void read_distortion(Reader& reader, const YAML::Node& root, CameraModel& model) {
  const YAML::Node named = model_in(root);
  const std::string name = named.IsDefined() && named.IsScalar() ? named.Scalar() : "";
  const std::string kind = plain(name);
  if (is_fisheye(kind)) {
    return reader.wrong(
        named, fmt::format("\"{}\" is a fisheye lens, which cannot be used here: take the camera_info of "
                           "its rectified pictures, or a lens of less than about 120 degrees",
                           name));
  }
  if (!is_polynomial(kind)) {
    return reader.wrong(
        named, fmt::format("the distortion model \"{}\" is not known; plumb_bob and rational_polynomial "
                           "are",
                           name));
  }
  if (kind == "none" && !Reader::find(root, kCoefficients).IsDefined()) return;
  const auto d = reader.numbers(root, kCoefficients);
  if (reader.error()) return;
  const YAML::Node where = Reader::find(root, kCoefficients);
  const auto is_zero = [](double number) { return number == 0; };
  if (std::all_of(d.begin(), d.end(), is_zero)) return;
  if (kind == "none") {
    return reader.wrong(where, "the distortion model is \"none\", but there are coefficients that are not 0");
  }
  if (d.size() < 4 || d.size() > kMostCoefficients) {
    return reader.wrong(
        where, fmt::format("there are {} distortion coefficients, but plumb_bob has 4 or 5 (k1 k2 p1 p2 "
                           "k3) and rational_polynomial 8 to 14",
                           d.size()));
  }
  const std::size_t used = std::min(d.size(), model.distortion.size());
  if (!std::all_of(d.begin() + static_cast<std::ptrdiff_t>(used), d.end(), is_zero)) {
    return reader.wrong(
        where,
        "the distortion has thin-prism or tilt coefficients (the ninth and later), which cannot be used "
        "here: calibrate the camera without them");
  }
  std::copy_n(d.begin(), used, model.distortion.begin());
}

// Rejects messages for binned or cropped pictures: the intrinsics are those of the whole sensor.
void check_whole_picture(Reader& reader, const YAML::Node& root) {
  for (const char* key : {"binning_x", "binning_y"}) {
    const YAML::Node found = Reader::find(root, {key});
    int binning = 0;
    if (!found.IsDefined() || !YAML::convert<int>::decode(found, binning) || binning <= 1) continue;
    reader.wrong(found,
                 fmt::format("the pictures are reduced by {} {}, but intrinsics are those of full pictures: "
                             "take the camera_info of full pictures",
                             key, binning));
  }
  const YAML::Node region = Reader::find(root, {"roi"});
  if (!region.IsDefined() || !region.IsMap()) return;
  const auto side = [&](const char* key) {
    const YAML::Node found = Reader::find(region, {key});
    int value = 0;
    return found.IsDefined() && YAML::convert<int>::decode(found, value) ? value : 0;
  };
  if (side("width") == 0 && side("height") == 0) return;
  reader.wrong(
      region,
      "the pictures are a part (\"roi\") of what the numbers are of: take the camera_info of whole pictures");
}

CameraInfo read(Reader& reader, const YAML::Node& root) {
  CameraInfo camera;
  if (!root.IsMap()) {
    reader.wrong(root, "\"image_width\" is missing");
    return camera;
  }
  camera.name = name_in(root);
  CameraModel& model = camera.model;
  model.width = reader.value<int>(root, kWidth);
  model.height = reader.value<int>(root, kHeight);
  const auto k = reader.numbers(root, kMatrix);
  if (reader.error()) return camera;
  const YAML::Node where = Reader::find(root, kMatrix);
  if (k.size() != 9) {
    reader.wrong(where, "\"camera_matrix\" must have nine numbers");
    return camera;
  }
  if (k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1) {
    reader.wrong(where, "\"camera_matrix\" must be [fx, 0, cx, 0, fy, cy, 0, 0, 1]");
    return camera;
  }
  model.fx = k[0];
  model.cx = k[2];
  model.fy = k[4];
  model.cy = k[5];
  read_distortion(reader, root, model);
  check_whole_picture(reader, root);
  if (const auto checked = check(model); !checked) reader.wrong(root, checked.error().what);
  if (const double skew = k[1]; skew != 0 && !reader.error()) {
    const double rim = std::max(std::abs(model.cy), std::abs(model.height - model.cy)) / model.fy;
    camera.remark = fmt::format(
        "the camera_matrix has a skew of {:g}, which is left out: pixels at the top and bottom are up to "
        "{:.1f} px off",
        skew, std::abs(skew) * rim);
  }
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
  std::string yaml = text;
  constexpr std::string_view kMark = "\xef\xbb\xbf";
  if (yaml.starts_with(kMark)) yaml.erase(0, kMark.size());
  if (yaml.starts_with("%YAML")) yaml[0] = '#';  // OpenCV writes %YAML:1.0, which is invalid.
  if (yaml.starts_with("<?xml")) {
    return fail(
        ErrorCode::kCorrupt,
        fmt::format("{}:1: is XML; save it as YAML (with OpenCV: a name that ends in .yaml)", path.string()));
  }
  try {
    const YAML::Node root = YAML::Load(yaml);
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
  if (const auto size = std::filesystem::file_size(path, ignored); size > kMostBytes) {
    return fail(ErrorCode::kCorrupt, fmt::format("{}: has {} bytes, too many for a camera_info (at most {})",
                                                 path.string(), size, kMostBytes));
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
