#include "simulation/true_camera.h"

namespace copresence::simulation {

Result<TrueCamera> TrueCamera::make(std::shared_ptr<const World> world, const CameraModel& model,
                                    const Rigid3& world_from_camera) {
  if (auto usable = check(model); !usable) return fail(usable.error());
  if (!world_from_camera.is_rigid())
    return fail(ErrorCode::kInvalid, "a camera's pose is no rigid transform");
  return TrueCamera(std::move(world), model, world_from_camera);
}

TrueCamera::TrueCamera(std::shared_ptr<const World> world, const CameraModel& model,
                       const Rigid3& world_from_camera)
    : world_(std::move(world)),
      sight_(model, world_from_camera),
      room_(world_, sight_),
      drawn_(world_, sight_),
      view_(room_.still()) {}

const TrueView& TrueCamera::look(double phase) {
  return draw(phase, FigureView::How::kByRays);
}

const TrueView& TrueCamera::glance(double phase) {
  return draw(phase, FigureView::How::kByTriangles);
}

const TrueView& TrueCamera::draw(double phase, FigureView::How how) {
  const Figure& figure = world_->figure();
  if (figure.empty()) return view_;
  drawn_.erase(room_, view_);
  const std::vector<Eigen::Isometry3f> pose = figure.pose(phase);
  std::vector<Capsule> capsules;
  for (std::size_t i = 0; i < pose.size(); ++i) {
    const Capsule& capsule = figure.capsules[i];
    capsules.push_back({pose[i] * capsule.from, pose[i] * capsule.to, capsule.radius});
  }
  room_.cast_shadows(capsules, view_.color);
  drawn_.draw(sight_, room_, pose, capsules, how, view_);
  return view_;
}

}  // namespace copresence::simulation
