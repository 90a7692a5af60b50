#pragma once

// An eye that stays at home: the default where there is no window.

#include "render_client/viewpoint/viewpoint.h"

namespace copresence::viewpoint {

class FixedView final : public Viewpoint {
 public:
  explicit FixedView(const Rigid3& world_from_eye = {}) : eye_{world_from_eye} {}

  Eye at(std::uint64_t, Instant) override { return eye_; }
  void set_home(const Rigid3& world_from_home) override { eye_.world_from_eye = world_from_home; }

 private:
  Eye eye_;
};

}  // namespace copresence::viewpoint
