#pragma once

// Synthetic moving pictures: a tilted plane, a box that slides over it, a little noise.

#include <algorithm>
#include <cstdint>

#include "common/frame/coded_frame.h"
#include "common/frame/stream_description.h"

namespace copresence::video {

inline std::uint32_t noise(std::uint32_t x) {
  x = (x ^ (x >> 16)) * 0x7feb352du;
  x = (x ^ (x >> 15)) * 0x846ca68bu;
  return x ^ (x >> 16);
}

/// Requires 0 <= index.
inline Picture moving_scene(PixelFormat format, int width, int height, int index) {
  Picture picture(format, width, height);
  const int peak = picture.bytes_per_sample() == 2 ? 1023 : 255;
  for (int plane = 0; plane < picture.planes(); ++plane) {
    const int plane_width = picture.plane_width(plane), plane_height = picture.plane_height(plane);
    for (int y = 0; y < plane_height; ++y) {
      for (int x = 0; x < plane_width; ++x) {
        const int box = (index * 2 + 8) % std::max(plane_width - 16, 1);
        int value = peak / 4 + (x + 2 * y + 40 * plane) * peak / (4 * (plane_width + 2 * plane_height));
        if (x >= box && x < box + 16 && y >= plane_height / 4 && y < plane_height / 2) value = peak * 3 / 4;
        value += static_cast<int>(noise(static_cast<std::uint32_t>((index * 480 + y) * 640 + x)) % 3);
        const std::size_t at = static_cast<std::size_t>(y) * plane_width + x;
        if (picture.bytes_per_sample() == 2) {
          picture.plane10()[at] = static_cast<std::uint16_t>(value);
        } else {
          picture.plane8(plane)[at] = static_cast<std::uint8_t>(value);
        }
      }
    }
  }
  return picture;
}

inline StreamDescription small_stream(PixelFormat format, bool has_color) {
  StreamDescription stream;
  stream.camera = "test";
  stream.model = camera_from_field_of_view(64, 48, 1.0, 0.8);
  stream.has_color = has_color;
  stream.codec = {"test", format, {}};
  return stream;
}

/// Frame `sequence` of a stream, from 1.
inline PlanarFrame moving_frame(const StreamDescription& stream, std::uint64_t sequence, bool keyframe) {
  PlanarFrame frame;
  frame.metadata.sequence = sequence;
  frame.metadata.captured_at = Instant(std::chrono::nanoseconds(1'000'000'007 * sequence));
  const int index = static_cast<int>(sequence);
  frame.depth.keyframe = keyframe;
  frame.depth.picture = moving_scene(stream.codec.format, stream.model.width, stream.model.height, index);
  frame.depth.validity_mask.assign(20 + sequence % 5, static_cast<std::uint8_t>(sequence % 3));
  if (keyframe) frame.depth.table = {0, 0, 1, 0, 0, 3};
  if (stream.has_color) {
    frame.color = moving_scene(PixelFormat::kYuv420, stream.model.width, stream.model.height, index);
  }
  return frame;
}

}  // namespace copresence::video
