#pragma once

// An eye moved by hand: it circles a pivot, slides across the picture, goes nearer and farther. Knows no
// window: the program turns its events into these verbs. Distances are shares of the picture's height, so
// that what is under the pointer stays there at any window size.

#include <Eigen/Core>

#include "render_client/viewpoint/viewpoint.h"

namespace copresence::viewpoint {

class OrbitView final : public Viewpoint {
 public:
  /// `up` is the world's; the pivot lies `pivot_m` before the eye at home. `fov_degrees` is vertical: what
  /// pan() needs. Requires up of some length, pivot_m > 0, 0 < fov_degrees < 180.
  OrbitView(const Eigen::Vector3d& up, double pivot_m, double fov_degrees);

  /// Moves the eye to the new home, unless the person has moved it away from the old one: then it stays.
  /// The first home always takes the eye there, since nothing was to be seen before.
  void set_home(const Rigid3& world_from_home) override;
  /// Takes the eye to the home that was set last.
  void go_home();

  /// The scene turns with the pointer, half a turn over the picture's height; never over the top.
  void orbit(double right, double down);
  /// The scene at the pivot's distance moves with the pointer.
  void pan(double right, double down);
  /// Nearer to the pivot, a tenth of the way with each notch of a wheel; negative: away.
  void zoom(double notches);

  Eye at(std::uint64_t, Instant) override { return {world_from_eye_}; }

 private:
  Eigen::Vector3d pivot() const { return world_from_eye_ * Eigen::Vector3d(0, 0, distance_m_); }
  void turn_about_pivot(const Eigen::Vector3d& axis, double angle);

  Eigen::Vector3d up_;
  double pivot_m_;
  double metres_per_height_;  // height of what is seen at a distance of one metre
  bool has_home_ = false;
  Rigid3 world_from_home_;
  Rigid3 world_from_eye_;
  double distance_m_;
};

}  // namespace copresence::viewpoint
