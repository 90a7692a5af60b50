// Arbitrary codebook changes, residuals and validity masks, as a malicious server may send them.
// The decoder must not crash, and decoded depth must satisfy the guarantees of depth_codec.h.
//
// An input is a stream of frames: u8 keyframe (lowest bit) and residuals (next bit), u8 bytes of
// the codebook change, u8 bytes of the mask, u8 bytes of the residuals if there are any, codebook
// change, mask, residuals.

#include <cstdlib>
#include <span>

#include "common/depth/depth_codec.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace copresence;
  using namespace copresence::depth;
  static const DepthFormat kFormat{64, 48, DepthUnit::kMillimetre, {}};
  static const DepthRangeUnits kRange = kFormat.units();
  static const DepthCodecDescription kDescription = Encoder::open("quantized", kFormat)->description();
  Decoder decoder = *Decoder::open(kDescription, kFormat);
  DepthImage depth;
  StateImage states;
  std::span<const std::uint8_t> rest(data, size);
  for (bool first = true; rest.size() >= 3; first = false) {
    PlanarDepth planes;
    planes.keyframe = first || (rest[0] & 1);
    planes.picture = Picture(PixelFormat::kGray10, kFormat.width, kFormat.height);
    std::uint16_t sample = rest[0];
    for (std::uint16_t& each : planes.picture.plane10())
      each = sample = static_cast<std::uint16_t>(sample * 5 + 3);
    const std::size_t table = rest[1], mask = rest[2];
    const bool exact = (rest[0] & 2) != 0;
    rest = rest.subspan(3);
    if (exact && rest.empty()) break;
    const std::size_t samples = exact ? rest[0] : 0;
    if (exact) rest = rest.subspan(1);
    if (rest.size() < table + mask + samples) break;
    planes.table.assign(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(table));
    rest = rest.subspan(table);
    planes.validity_mask.assign(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(mask));
    rest = rest.subspan(mask);
    planes.residuals.assign(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(samples));
    rest = rest.subspan(samples);
    if (!decoder.decode(planes, depth, states)) break;
    for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
      const bool hole = states.data()[i] == DepthState::kHole;
      if (static_cast<int>(states.data()[i]) > 2 || hole != (depth.data()[i] == 0)) std::abort();
      if (!hole && !kRange.contains(depth.data()[i])) std::abort();
    }
  }
  return 0;
}
