#pragma once

// What a perfect camera sees of a world: true depth and colour from any model and pose at any time. It is the
// ground truth of this project, and what KinectNoise and ColorResponse spoil.
//
// The still part is traced once, when the camera is made; a look traces only where the figure can be.
// Thread: one thread per camera; several cameras may share a world.

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "capture_server/simulation/world.h"
#include "common/frame/camera_model.h"
#include "common/frame/image.h"
#include "common/frame/rigid3.h"
#include "common/result.h"

namespace copresence::simulation {

struct TrueView {
  Image<float> depth_m;  ///< along the optical axis at the pixel's centre; 0 where nothing is
  ColorImage color;      ///< sRGB, smoothed over the pixel
  Image<float>
      infrared;  ///< share of a projector's light at the camera that comes back: surface times cosine; 0 to 1
};

class TrueCamera {
 public:
  /// Traces everything that never moves. Fails  kInvalid for a model that check() refuses or a pose that is
  /// not rigid.
  static Result<TrueCamera> make(std::shared_ptr<const World> world, const CameraModel& model,
                                 const Rigid3& world_from_camera);

  /// The view at a time. It is the camera's own and changes at the next look.
  const TrueView& look(double phase);

  /// The view without the figure.
  const TrueView& still() const { return still_; }

  const CameraModel& model() const { return model_; }
  const Rigid3& world_from_camera() const { return world_from_camera_; }

 private:
  struct Sphere {
    Eigen::Vector3f center;
    float radius = 0;
  };
  struct Block {
    int x = 0, y = 0;  // top left pixel of four that share one shadow value
  };

  TrueCamera(std::shared_ptr<const World> world, const CameraModel& model, const Rigid3& world_from_camera);

  void trace_still();
  void find_shadow_blocks();
  void cast_shadows(const std::vector<Capsule>& capsules);
  void bound_parts();
  void find_cells(const std::vector<Eigen::Isometry3f>& pose);
  template <class Visit>
  void for_each_run(Visit&& visit) const;
  void draw_figure(const std::vector<Eigen::Isometry3f>& pose, const std::vector<Capsule>& capsules);
  Eigen::Vector2f uv_change(std::size_t pixel, std::size_t distance) const;
  Eigen::Vector3f mean_albedo(const Material& material, std::size_t pixel) const;
  void smooth_outline();
  Eigen::Vector3f still_light(const Ray& ray, const Eigen::Vector3f& direction, Eigen::Vector3f& of_lamp,
                              bool mirrors) const;

  std::shared_ptr<const World> world_;
  CameraModel model_;
  Rigid3 world_from_camera_;
  Eigen::Vector3f eye_;
  std::vector<Eigen::Vector3f> directions_;  // per pixel, world frame, length 1 along the optical axis
  Eigen::Vector3f pixel_x_, pixel_y_;        // change of direction from one pixel to the next

  TrueView still_;
  std::vector<Eigen::Vector3f> still_light_, still_lamp_;  // linear; the lamp's part of it
  std::vector<Block> blocks_;
  ShadowPoints shadow_points_;
  std::vector<float> hidden_;

  PosedScene posed_;
  TrueView view_;
  std::vector<std::vector<Sphere>> bounds_;    // per part, in its own frame: together they hold all of it
  Image<std::uint8_t> cells_;                  // rows of kCell pixels in which the figure may be
  std::vector<std::int8_t> part_of_;           // per pixel: the figure's part, or -1
  std::vector<Eigen::Vector3f> figure_light_;  // per pixel, valid where part_of_ >= 0
  std::vector<Eigen::Vector2f> figure_uv_;     // likewise
  std::vector<Eigen::Vector3f> room_light_;    // per pixel: the still light with the figure's shadow
  ColorImage room_color_;                      // the same as seen
  std::vector<Ray> rays_;
};

}  // namespace copresence::simulation
