#pragma once

// The figure as one camera sees it at one instant, drawn over the room.
//
// Only cells of pixels that spheres around the figure's parts cover are traced.
//
// Thread: one thread per object; several may share a world.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "capture_server/simulation/room_view.h"
#include "capture_server/simulation/sight.h"
#include "capture_server/simulation/true_view.h"
#include "capture_server/simulation/world.h"

namespace copresence::simulation {

class FigureView {
 public:
  FigureView(std::shared_ptr<const World> world, const Sight& sight);

  /// Puts the room back into `view` wherever draw() may have put the figure.
  void erase(const RoomView& room, TrueView& view);

  /// Draws it where the room is not nearer. `pose`: world from each part; `capsules`: the parts in the world, for their shadows on each
  /// other. Requires an erased view, and the sight that the object was made with.
  void draw(const Sight& sight, const RoomView& room, std::span<const Eigen::Isometry3f> pose,
            std::span<const Capsule> capsules, TrueView& view);

 private:
  struct Sphere {
    Eigen::Vector3f center;
    float radius = 0;
  };

  void bound_parts();
  void find_cells(const Sight& sight, std::span<const Eigen::Isometry3f> pose);
  template <class Visit>
  void for_each_run(Visit&& visit) const;
  void draw_parts(const Sight& sight, const RoomView& room, std::span<const Eigen::Isometry3f> pose,
                  std::span<const Capsule> capsules, TrueView& view);
  Eigen::Vector2f uv_change(std::size_t pixel, std::size_t distance) const;
  Eigen::Vector3f mean_albedo(const Material& material, std::size_t pixel) const;
  void smooth_outline(const Sight& sight, const RoomView& room, TrueView& view);

  std::shared_ptr<const World> world_;
  PosedScene posed_;
  std::size_t width_, height_;                 // of the picture
  std::vector<std::vector<Sphere>> bounds_;    // per part, in its own frame: together they hold all of it
  Image<std::uint8_t> cells_;                  // rows of cells in which the figure may be
  std::vector<std::int8_t> part_of_;           // per pixel: the figure's part, or -1
  std::vector<Eigen::Vector3f> figure_light_;  // per pixel, valid where part_of_ >= 0
  std::vector<Eigen::Vector2f> figure_uv_;     // likewise
  std::vector<Ray> rays_;
};

}  // namespace copresence::simulation
