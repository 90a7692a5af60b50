#include "tools/simulate_kinect/view_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

namespace copresence::simulate_kinect {

Result<ViewPath> ViewPath::load(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) return fail(ErrorCode::kNotFound, fmt::format("{}: cannot be read", path.string()));
  ViewPath made;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (line.empty() || line.front() == '#') continue;
    std::istringstream words(line);
    Stop stop;
    words >> stop.view;
    for (int axis = 0; axis < 3; ++axis) words >> stop.eye[axis];
    for (int axis = 0; axis < 3; ++axis) words >> stop.look[axis];
    std::string more;
    if (!words || words >> more) {
      return fail(ErrorCode::kInvalid,
                  fmt::format("{}:{}: a line of a path is \"view x y z look_x look_y look_z\"", path.string(),
                              number));
    }
    if (!made.stops_.empty() && stop.view <= made.stops_.back().view) {
      return fail(ErrorCode::kInvalid, fmt::format("{}:{}: views must ascend", path.string(), number));
    }
    const Eigen::Vector3d along = stop.look - stop.eye;
    if (std::hypot(along.x(), along.z()) < 1e-6) {
      return fail(ErrorCode::kInvalid,
                  fmt::format("{}:{}: the eye may not look straight up or down", path.string(), number));
    }
    made.stops_.push_back(stop);
  }
  if (made.stops_.empty())
    return fail(ErrorCode::kInvalid, fmt::format("{}: no line of a path in it", path.string()));
  return made;
}

ViewPath::Stop ViewPath::at(double view) const {
  const auto after =
      std::find_if(stops_.begin(), stops_.end(), [&](const Stop& stop) { return stop.view > view; });
  if (after == stops_.begin()) return stops_.front();
  if (after == stops_.end()) return stops_.back();
  const Stop &a = *std::prev(after), &b = *after;
  const double t = (view - a.view) / (b.view - a.view);
  return {view, a.eye + t * (b.eye - a.eye), a.look + t * (b.look - a.look)};
}

}  // namespace copresence::simulate_kinect
