#include "capture_server/sensor/projector.h"

#include <PS1080.h>

#include "capture_server/drivers/contract/device_properties.h"

namespace copresence::sensor {
namespace {

ProjectorSchedule::Time clock_now() {
  return std::chrono::duration_cast<ProjectorSchedule::Time>(
      std::chrono::system_clock::now().time_since_epoch());
}

}  // namespace

Projector::~Projector() {
  if (!shines_) set(true);
}

bool Projector::set(bool shines) {
  const int ours = shines;
  const std::uint64_t of_prime_sense = shines;
  return device_.setProperty(drivers::kProjector, ours) == openni::STATUS_OK ||
         device_.setProperty(XN_MODULE_PROPERTY_EMITTER_STATE, of_prime_sense) == openni::STATUS_OK;
}

Result<void> Projector::begin() {
  // Dark first: a camera that cannot be dark says so at once, not in a quarter of a minute.
  if (!set(false)) {
    return fail(ErrorCode::kUnsupported,
                "it cannot switch its projector off; start without --projector-slot");
  }
  shines_ = false;
  obey();
  return {};
}

bool Projector::obey() {
  const bool wanted = schedule_.shines(clock_now());
  if (wanted == shines_ || !set(wanted)) return false;  // what fails is tried again at the next call
  shines_ = wanted;
  lit_since_ = std::chrono::steady_clock::now() + settles_;
  return true;
}

bool Projector::lit(Instant at) const {
  return shines_ && at >= lit_since_ && schedule_.shines(clock_now());
}

Duration Projector::until_change() const {
  return schedule_.until_change(clock_now());
}

}  // namespace copresence::sensor
