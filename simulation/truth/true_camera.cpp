#include "simulation/truth/true_camera.h"

#include <utility>
#include <vector>

#include "simulation/truth/figure_view.h"
#include "simulation/truth/ray_tracer.h"
#include "simulation/truth/static_view.h"

namespace copresence::simulation {

Result<TrueCamera> TrueCamera::make(std::shared_ptr<const LitScene> scene, const CameraModel& model,
                                    const Rigid3& world_from_camera) {
  if (auto usable = check(model); !usable) return fail(usable.error());
  if (!world_from_camera.is_rigid())
    return fail(ErrorCode::kInvalid, "the pose of a camera is not a rigid transform");
  return TrueCamera(std::move(scene), model, world_from_camera);
}

TrueCamera::TrueCamera(std::shared_ptr<const LitScene> scene, const CameraModel& model,
                       const Rigid3& world_from_camera)
    : scene_(std::move(scene)),
      pixels_(std::make_unique<const PixelRays>(model, world_from_camera)),
      background_(std::make_unique<StaticView>(scene_, *pixels_)),
      figure_(std::make_unique<FigureView>(scene_, *pixels_)),
      view_(background_->view()) {}

TrueCamera::~TrueCamera() = default;
TrueCamera::TrueCamera(TrueCamera&&) noexcept = default;
TrueCamera& TrueCamera::operator=(TrueCamera&&) noexcept = default;

const TrueView& TrueCamera::background() const {
  return background_->view();
}
const CameraModel& TrueCamera::model() const {
  return pixels_->model;
}
const Rigid3& TrueCamera::world_from_camera() const {
  return pixels_->world_from_camera;
}

const TrueView& TrueCamera::trace(double phase) {
  const Figure& figure = scene_->figure();
  if (figure.empty()) return view_;
  figure_->erase(*background_, view_);
  const std::vector<Eigen::Isometry3f> pose = figure.pose(phase);
  std::vector<Capsule> capsules;
  for (std::size_t i = 0; i < pose.size(); ++i) {
    const Capsule& capsule = figure.capsules[i];
    capsules.push_back({pose[i] * capsule.from, pose[i] * capsule.to, capsule.radius});
  }
  background_->cast_figure_shadow(capsules, view_.color);
  figure_->draw(*pixels_, *background_, pose, capsules, view_);
  return view_;
}

}  // namespace copresence::simulation
