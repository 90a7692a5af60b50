#pragma once

// Closes the holes of a sensor's depth images. Holes would become rips in meshes and cost bits in
// codecs.
//
// Only holes that are narrow enough are closed (filling_rules.h); their state becomes kFilled.
// Measured depth is never changed. All methods have one interface, with implementations for CPU and
// GL; open() chooses.
//
// Thread: one at a time. A GL filler is created, used and destroyed by one thread, to which its
// context belongs.

#include <array>
#include <memory>
#include <string_view>

#include "common/frame/depth_unit.h"
#include "common/frame/rgbd_frame.h"
#include "common/result.h"

namespace copresence::hole_filling {

enum class Method {
  kOff,        ///< leaves holes as they are
  kMedian,     ///< two median passes, after Maimone and Fuchs
  kBilateral,  ///< by pixel distance alone; smears foreground into background (thesis 3.2, second version)
  kJoint,      ///< by pixel, depth and colour distance, without bridging surfaces (thesis 3.2, third version)
};
inline constexpr std::array kMethods{Method::kOff, Method::kMedian, Method::kBilateral, Method::kJoint};

enum class Compute {
  kAuto,  ///< GL if it is hardware and the method has shaders, else the CPU
  kGl,
  kCpu,
};

std::string_view name(Method method);  ///< "off", "median", "bilateral" or "joint", as in --hole-filling

/// The frames of a filler.
struct FrameFormat {
  int width = 640, height = 480;  ///< pixels
  DepthUnit unit = DepthUnit::kMillimetre;
  DepthRange range;  ///< holes are never filled with depth outside it
  DepthNoise noise = {};
};

class HoleFiller {
 public:
  virtual ~HoleFiller() = default;

  virtual std::string_view name() const = 0;  ///< "cpu" or "gl", as in --compute

  /// True if fill() may be called from any thread, one at a time. Else only from the thread that
  /// opened this.
  virtual bool is_free_of_threads() const { return true; }

  /// Closes those holes of `frame` that can be closed. Depth and state change only in holes.
  /// Requires depth and state of the format's size, depth 0 exactly where the state is kHole, and
  /// colour of the same size or none. Fails only if the graphics driver does.
  virtual Result<void> fill(RgbdFrame& frame) = 0;
};

/// Fails  kInvalid (sizes or a range that make no sense), kUnsupported (GL is requested, but it is
///      missing or the method has no shaders).
Result<std::unique_ptr<HoleFiller>> open(Method method, Compute compute, const FrameFormat& format);

}  // namespace copresence::hole_filling
