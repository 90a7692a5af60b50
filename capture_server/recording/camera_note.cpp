#include "capture_server/recording/camera_note.h"

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

tl::unexpected<Error> corrupt(const char* what) {
  return fail(ErrorCode::kCorrupt, std::string("the recording's camera note is damaged: ") + what);
}

}  // namespace

std::string to_json(const CameraNote& note) {
  assert(check(note.model));
  const CameraModel& m = note.model;
  nlohmann::ordered_json json = {{"name", note.name},
                                 {"width", m.width},
                                 {"height", m.height},
                                 {"fx", m.fx},
                                 {"fy", m.fy},
                                 {"cx", m.cx},
                                 {"cy", m.cy},
                                 {"distortion", m.distortion},
                                 {"registered", note.registered},
                                 {"unit_um", static_cast<int>(note.unit)}};
  if (note.world_from_camera) {
    const Eigen::Matrix4d pose = note.world_from_camera->matrix();
    auto& rows = json["world_from_camera"];
    for (int r = 0; r < 4; ++r) rows.push_back({pose(r, 0), pose(r, 1), pose(r, 2), pose(r, 3)});
  }
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

Result<CameraNote> parse_camera_note(std::string_view text) {
  if (text.size() > kMostBytes) return corrupt("more than 64 KiB");
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return corrupt("not a JSON object");

  CameraNote note;
  CameraModel& m = note.model;
  if (const Json* name = find(json, "name")) {
    if (!name->is_string()) return corrupt("\"name\" is no text");
    note.name = name->get<std::string>();
  }
  if (!read(find(json, "width"), m.width) || !read(find(json, "height"), m.height) ||
      !read(find(json, "fx"), m.fx) || !read(find(json, "fy"), m.fy) || !read(find(json, "cx"), m.cx) ||
      !read(find(json, "cy"), m.cy)) {
    return corrupt("width, height, fx, fy, cx and cy must all be there");
  }
  if (const Json* distortion = find(json, "distortion")) {
    if (!distortion->is_array() || distortion->size() > m.distortion.size()) return corrupt("\"distortion\"");
    for (std::size_t i = 0; i < distortion->size(); ++i) {
      if (!read(&(*distortion)[i], m.distortion[i])) return corrupt("\"distortion\"");
    }
  }
  if (auto usable = check(m); !usable) return corrupt(usable.error().what.c_str());

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
  return note;
}

}  // namespace copresence::recording
