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
  if (!is_on_) set(true);
}

bool Projector::set(bool on) {
  const int ours = on;
  const std::uint64_t of_prime_sense = on;
  return device_.setProperty(drivers::kProjector, ours) == openni::STATUS_OK ||
         device_.setProperty(XN_MODULE_PROPERTY_EMITTER_STATE, of_prime_sense) == openni::STATUS_OK;
}

Result<void> Projector::begin() {
  // The projector is switched off first, so that a camera that cannot do this fails at once.
  if (!set(false)) {
    return fail(ErrorCode::kUnsupported,
                "it cannot switch its projector off; start without --projector-slot");
  }
  is_on_ = false;
  follow_schedule();
  return {};
}

bool Projector::follow_schedule() {
  const bool wanted = schedule_.is_on(clock_now());
  if (wanted == is_on_ || !set(wanted)) return false;  // After a failure the next call tries again.
  is_on_ = wanted;
  exposed_since_ = std::chrono::steady_clock::now() + settles_;
  return true;
}

bool Projector::is_exposed(Instant at) const {
  return is_on_ && at >= exposed_since_ && schedule_.is_on(clock_now());
}

Duration Projector::until_change() const {
  return schedule_.until_change(clock_now());
}

}  // namespace copresence::sensor
