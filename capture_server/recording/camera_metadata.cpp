#include "capture_server/recording/camera_metadata.h"

#include <cassert>
#include <nlohmann/json.hpp>

namespace copresence::recording {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMostBytes = 64 * 1024;

const Json* find(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

bool read(const Json* value, double& out) {
  if (!value || !value->is_number()) return false;
  out = value->get<double>();
  return true;
}

bool read(const Json* value, int& out) {
  if (!value || !value->is_number_integer()) return false;
  const auto number = value->get<std::int64_t>();
  if (number < 0 || number > 65535) return false;
  out = static_cast<int>(number);
  return true;
}

bool read(const Json& rows, Rigid3& out) {
  if (!rows.is_array() || rows.size() != 4) return false;
  Eigen::Matrix4d m;
  for (std::size_t r = 0; r < 4; ++r) {
    if (!rows[r].is_array() || rows[r].size() != 4) return false;
    for (std::size_t c = 0; c < 4; ++c) {
      if (!read(&rows[r][c], m(static_cast<int>(r), static_cast<int>(c)))) return false;
    }
  }
  if (m.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) return false;
  out = {m.topLeftCorner<3, 3>(), m.topRightCorner<3, 1>()};
  return out.is_rigid();
}

// Reads a camera model's members from an object. Returns the first mistake, or an empty text.
std::string read(const Json& object, CameraModel& m) {
  if (!read(find(object, "width"), m.width) || !read(find(object, "height"), m.height) ||
      !read(find(object, "fx"), m.fx) || !read(find(object, "fy"), m.fy) || !read(find(object, "cx"), m.cx) ||
      !read(find(object, "cy"), m.cy)) {
    return "width, height, fx, fy, cx and cy must all be there";
  }
  if (const Json* distortion = find(object, "distortion")) {
    if (!distortion->is_array() || distortion->size() > m.distortion.size()) return "\"distortion\"";
    for (std::size_t i = 0; i < distortion->size(); ++i) {
      if (!read(&(*distortion)[i], m.distortion[i])) return "\"distortion\"";
    }
  }
  const auto usable = check(m);
  return usable ? std::string() : usable.error().what;
}

nlohmann::ordered_json model_json(const CameraModel& m) {
  return {{"width", m.width}, {"height", m.height},        {"fx", m.fx}, {"fy", m.fy}, {"cx", m.cx},
          {"cy", m.cy},       {"distortion", m.distortion}};
}

nlohmann::ordered_json transform_json(const Rigid3& transform) {
  const Eigen::Matrix4d m = transform.matrix();
  nlohmann::ordered_json rows;
  for (int r = 0; r < 4; ++r) rows.push_back({m(r, 0), m(r, 1), m(r, 2), m(r, 3)});
  return rows;
}

tl::unexpected<Error> corrupt(const std::string& what) {
  return fail(ErrorCode::kCorrupt, "the recording's camera metadata is damaged: " + what);
}

}  // namespace

std::string to_json(const CameraMetadata& note) {
  assert(check(note.model));
  nlohmann::ordered_json json = {{"name", note.name}};
  json.update(model_json(note.model));
  json["registered"] = note.registered;
  json["unit_um"] = static_cast<int>(note.unit);
  if (note.world_from_camera) json["world_from_camera"] = transform_json(*note.world_from_camera);
  if (note.color) {
    assert(check(note.color->model));
    json["color"] = model_json(note.color->model);
    json["color"]["color_from_depth"] = transform_json(note.color->color_from_depth);
  }
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

Result<CameraMetadata> parse_camera_metadata(std::string_view text) {
  if (text.size() > kMostBytes) return corrupt("more than 64 KiB");
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return corrupt("not a JSON object");

  CameraMetadata note;
  if (const Json* name = find(json, "name")) {
    if (!name->is_string()) return corrupt("\"name\" is no text");
    note.name = name->get<std::string>();
  }
  if (const std::string wrong = read(json, note.model); !wrong.empty()) return corrupt(wrong);

  const Json* registered = find(json, "registered");
  if (!registered || !registered->is_boolean()) return corrupt("\"registered\" must be true or false");
  note.registered = registered->get<bool>();

  int unit_um = 0;
  if (!read(find(json, "unit_um"), unit_um) || (unit_um != 100 && unit_um != 1000)) {
    return corrupt("\"unit_um\" must be 100 or 1000");
  }
  note.unit = static_cast<DepthUnit>(unit_um);

  if (const Json* pose = find(json, "world_from_camera")) {
    Rigid3 world_from_camera;
    if (!read(*pose, world_from_camera)) return corrupt("\"world_from_camera\" is no rigid transform");
    note.world_from_camera = world_from_camera;
  }
  if (const Json* color = find(json, "color")) {
    if (!color->is_object()) return corrupt("\"color\" is no object");
    ColorCameraMetadata& camera = note.color.emplace();
    if (const std::string wrong = read(*color, camera.model); !wrong.empty()) return corrupt(wrong);
    const Json* transform = find(*color, "color_from_depth");
    if (!transform || !read(*transform, camera.color_from_depth)) {
      return corrupt("\"color_from_depth\" is no rigid transform");
    }
  }
  return note;
}

}  // namespace copresence::recording
