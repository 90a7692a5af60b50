#pragma once

// Closes the holes of a sensor's depth images, so that meshes have no rips and codecs nothing to trip over.
//
// Only holes narrow enough to be guessed are closed (filling_rules.h); they become kFilled. Measured depth is
// never changed. Every method exists as one interface with implementations for CPU and GL, and open()
// chooses.
//
// Thread: one at a time; a GL filler, whose context belongs to a thread, is made, used and destroyed by one.

#include <array>
#include <memory>
#include <string_view>

#include "common/frame/depth_unit.h"
#include "common/frame/rgbd_frame.h"
#include "common/result.h"

namespace copresence::hole_filling {

enum class Method {
  kOff,        ///< holes stay holes
  kMedian,     ///< two median passes, after Maimone and Fuchs
  kBilateral,  ///< weighted by pixel distance alone: smears foreground into background (thesis 3.2, second
               ///< version)
  kJoint,      ///< by pixel, depth and colour distance, without bridging surfaces (thesis 3.2, third version)
};
inline constexpr std::array kMethods{Method::kOff, Method::kMedian, Method::kBilateral, Method::kJoint};

enum class Compute {
  kAuto,  ///< GL where it is not software and the method has shaders, else the CPU
  kGl,
  kCpu,
};

std::string_view name(Method method);  ///< off, median, bilateral, joint: what --hole-filling takes

/// What frames a filler will see.
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

  /// Whether fill() may be called from any thread, one at a time; else from the one that opened this.
  virtual bool is_free_of_threads() const { return true; }

  /// Closes the holes of `frame` that can be closed sensibly. Depth and state change only where the state is
  /// kHole. Requires depth and state of the format's size, depth 0 exactly where the state is kHole, and
  /// colour, where there is any, of the same size. Fails only where the graphics driver does.
  virtual Result<void> fill(RgbdFrame& frame) = 0;
};

/// Fails: kInvalid for sizes or a range that make no sense, kUnsupported where GL is asked for and there is
/// none, or the method has no shaders.
Result<std::unique_ptr<HoleFiller>> open(Method method, Compute compute, const FrameFormat& format);

}  // namespace copresence::hole_filling
