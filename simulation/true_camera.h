#pragma once

// What a perfect camera sees of a world: true depth and colour from any model and pose at any time. It is the
// ground truth of this project, and what KinectNoise and ColorResponse spoil.
//
// The still part is traced once, when the camera is made; a look traces only where the figure can be.
// Thread: one thread per camera; several cameras may share a world.

#include <memory>

#include "common/frame/camera_model.h"
#include "common/frame/rigid3.h"
#include "common/result.h"
#include "simulation/figure_view.h"
#include "simulation/room_view.h"
#include "simulation/sight.h"
#include "simulation/true_view.h"
#include "simulation/world.h"

namespace copresence::simulation {

class TrueCamera {
 public:
  /// Traces everything that never moves. Fails  kInvalid for a model that check() refuses or a pose that is
  /// not rigid.
  static Result<TrueCamera> make(std::shared_ptr<const World> world, const CameraModel& model,
                                 const Rigid3& world_from_camera);

  /// The view at a time. It is the camera's own and changes at the next look.
  const TrueView& look(double phase);

  /// The same in a fraction of the time and but for rounding: depth to some micrometres, a few pixels on edges.
  const TrueView& glance(double phase);

  /// The view without the figure.
  const TrueView& still() const { return room_.still(); }

  /// Whether anything moves in its world.
  bool sees_motion() const { return !world_->figure().empty(); }

  const CameraModel& model() const { return sight_.model; }
  const Rigid3& world_from_camera() const { return sight_.world_from_camera; }

 private:
  TrueCamera(std::shared_ptr<const World> world, const CameraModel& model, const Rigid3& world_from_camera);
  const TrueView& draw(double phase, FigureView::How how);

  std::shared_ptr<const World> world_;
  Sight sight_;
  RoomView room_;
  FigureView drawn_;
  TrueView view_;
};

}  // namespace copresence::simulation
