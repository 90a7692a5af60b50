#pragma once

// Fills the narrow holes of a sensor's depth images (filling_rules.h) and sets their state to
// kFilled. Holes would tear gaps into meshes and cost bits in codecs. Measured depth is never
// changed. All methods have the interface HoleFiller, with implementations for CPU and GL.
// Thread: one thread at a time per object. A GL filler is created, used and destroyed by one
// thread, to which its context belongs.

#include <array>
#include <memory>
#include <string_view>

#include "common/frame/depth_unit.h"
#include "common/frame/rgbd_frame.h"
#include "common/result.h"

namespace copresence::hole_filling {

enum class Method {
  kOff,     ///< No holes are filled.
  kMedian,  ///< Two median passes, after Maimone and Fuchs.
  /// Mean weighted by pixel distance. It smears foreground (thesis 3.2, second version).
  kBilateral,
  /// Mean weighted by pixel, depth and colour distance. This method does not bridge surfaces
  /// (thesis section 3.2, third version).
  kJoint,
};
inline constexpr std::array kMethods{Method::kOff, Method::kMedian, Method::kBilateral, Method::kJoint};

enum class Compute {
  kAuto,  ///< GL if it runs on hardware and has shaders for the method, else the CPU.
  kGl,
  kCpu,
};

std::string_view name(Method method);  ///< "off", "median", "bilateral" or "joint".

/// The format of the frames that a filler gets.
struct FrameFormat {
  int width = 640, height = 480;  ///< In pixels.
  DepthUnit unit = DepthUnit::kMillimetre;
  DepthRange range;  ///< No hole is filled with depth outside this range.
  DepthNoise noise = {};
};

class HoleFiller {
 public:
  virtual ~HoleFiller() = default;

  virtual std::string_view name() const = 0;  ///< "cpu" or "gl", as in --compute.

  /// True if any thread may call fill(), one at a time. False if only the thread that called open()
  /// may call fill().
  virtual bool is_free_of_threads() const { return true; }

  /// Fills the narrow holes of `frame`. Depth and state change only in holes. Requires depth and
  /// state of the format's size, depth 0 exactly where the state is kHole, and colour of the same
  /// size or none. Fails only if the graphics driver fails.
  virtual Result<void> fill(RgbdFrame& frame) = 0;
};

/// Opens a filler. Fails with kInvalid if the format is impossible. Fails with kUnsupported if GL
/// is requested, but is missing or has no shaders for the method.
Result<std::unique_ptr<HoleFiller>> open(Method method, Compute compute, const FrameFormat& format);

}  // namespace copresence::hole_filling
