#pragma once

// Ground truth: true depth and colour of a scene from any camera model and pose at any time. The
// static part of the scene is traced once, when the camera is created. After that, only pixels that
// may show the figure are traced.
// Thread: one thread at a time per camera; several cameras may share a scene.

#include <memory>

#include "common/frame/camera_model.h"
#include "common/frame/image.h"
#include "common/frame/rigid3.h"
#include "common/result.h"
#include "simulation/truth/lit_scene.h"

namespace copresence::simulation {

class FigureView;
class StaticView;
struct PixelRays;

/// The view of a perfect camera at one instant.
struct TrueView {
  Image<float> depth_m;  ///< Depth along the optical axis at the pixel's centre; 0 where there is no surface.
  ColorImage color;      ///< In sRGB, anti-aliased.
  Image<float> infrared;  ///< Share of the projector's light that is reflected to the camera.
};

class TrueCamera {
 public:
  /// Fails with kInvalid if check() rejects the model or the pose is not rigid.
  static Result<TrueCamera> make(std::shared_ptr<const LitScene> scene, const CameraModel& model,
                                 const Rigid3& world_from_camera);
  ~TrueCamera();
  TrueCamera(TrueCamera&&) noexcept;
  TrueCamera& operator=(TrueCamera&&) noexcept;

  /// Returns the view at `phase` of the figure's motion, valid until the next call.
  const TrueView& trace(double phase);

  /// Returns the view without the figure.
  const TrueView& background() const;

  /// True if the scene has a figure, so that trace() depends on the phase.
  bool sees_motion() const { return !scene_->figure().empty(); }

  const CameraModel& model() const;
  const Rigid3& world_from_camera() const;

 private:
  TrueCamera(std::shared_ptr<const LitScene> scene, const CameraModel& model,
             const Rigid3& world_from_camera);

  std::shared_ptr<const LitScene> scene_;
  std::unique_ptr<const PixelRays> pixels_;
  std::unique_ptr<StaticView> background_;
  std::unique_ptr<FigureView> figure_;
  TrueView view_;
};

}  // namespace copresence::simulation
