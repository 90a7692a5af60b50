#pragma once

// A simulated Kinect as a device of OpenNI2: 640x480 pixels at 30 frames per second, depth in 1 mm
// registered to colour. Timestamps are microseconds of the system clock.
// Thread: OpenNI2 calls a device from its users' threads. While streams are started, a thread of
// the device creates their frames.

#include <atomic>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "capture_server/drivers/contract/push_device.h"
#include "capture_server/drivers/contract/simulated_uri.h"
#include "capture_server/drivers/simulated/shared_projectors.h"
#include "simulation/sensor/simulated_kinect.h"

namespace copresence::drivers {

/// The state of a camera according to its control file. Tests use such files to make cameras fail.
enum class Control {
  kWork,       ///< No control file was named, or it has none of the following words.
  kUnplugged,  ///< The control file does not exist.
  kStall,      ///< The word "stall": the camera sends no frames and reports no error.
  kCrash,      ///< The word "crash": the driver ends its process.
  kHang,       ///< The word "hang": the driver never returns.
};
Control read_control(const std::string& path);

class SimulatedDevice final : public PushDevice {
 public:
  static constexpr int kWidth = 640, kHeight = 480;  // pixels

  /// A camera with its precomputed frames. The camera outlives the device, for fast reopening.
  using Camera = std::shared_ptr<simulation::SimulatedKinect>;

  /// `make_camera` is called when the first stream starts. The function returns null on failure,
  /// and its first call takes seconds. `projectors` is the state that the cameras of a world share.
  /// Without this state all projectors are on.
  SimulatedDevice(SimulatedUri uri, std::function<Camera()> make_camera,
                  std::optional<SharedProjectors> projectors);

  OniStatus getProperty(int property, void* data, int* size) override;
  OniStatus setProperty(int property, const void* data, int size) override;
  OniBool isImageRegistrationModeSupported(OniImageRegistrationMode mode) override;
  OniStatus get_of(PushStream& stream, int property, void* data, int* size) override;
  OniStatus begin(PushStream& stream) override;
  void end(PushStream& stream) override;

 private:
  Lens lens_of(OniSensorType) const override;
  void share_projector_state(bool is_running);
  simulation::Projectors projectors_on() const;
  void create_frames(const std::stop_token& stop);
  void send_frame(std::uint64_t number, std::uint64_t timestamp_us, int index);
  std::vector<std::pair<OniSensorType, PushStream::Picture>> next_pictures();

  const SimulatedUri uri_;
  const std::function<Camera()> make_camera_;
  std::optional<SharedProjectors> projectors_;
  std::atomic<bool> is_projector_on_ = true;
  Camera camera_;
  std::mutex mutex_;
  std::list<PushStream*> streams_;  // The started streams.
  std::jthread thread_;
};

}  // namespace copresence::drivers
