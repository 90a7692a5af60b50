#pragma once

// Which places of a figure a camera sees, pixel by pixel: what finding the figure hands to drawing it.
//
// Thread: a value.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace copresence::simulation {

/// Where in a pixel its colour is looked at, in pixels from its middle: no two in one row or column.
inline const std::array<Eigen::Vector2f, 4> kFigureLooks{
    Eigen::Vector2f(-0.125f, -0.375f), Eigen::Vector2f(0.375f, -0.125f), Eigen::Vector2f(0.125f, 0.375f),
    Eigen::Vector2f(-0.375f, 0.125f)};

/// A pixel in whose middle a part is nearest, and which place of it that is.
struct Hit {
  std::uint32_t pixel = 0, triangle = 0;
  float far = 0;       ///< distance in lengths of the pixel's direction: depth, metres
  float u = 0, v = 0;  ///< weights of the triangle's second and third vertex
};

struct FigureHits {
  using Looks = std::array<std::int32_t, kFigureLooks.size()>;

  FigureHits(std::size_t picture_width, std::size_t picture_height, std::size_t part_count);

  /// Forgets the figure.
  void clear();

  /// Enters the parts' pixels into part_of, and finds runs and the outline.
  void close();

  std::size_t width, height;
  std::vector<std::vector<Hit>> parts;
  /// A row's pixels from the first to the last that may show something of the figure.
  struct Run {
    std::size_t first = 0, count = 0;
  };
  std::vector<Run> runs;
  std::vector<std::int8_t> part_of;    ///< per pixel of the picture, or -1
  std::vector<std::uint32_t> outline;  ///< pixels beside which another part is seen, or the room
  std::vector<Looks> looks;            ///< the same pixels', the part seen there or -1
};

}  // namespace copresence::simulation
