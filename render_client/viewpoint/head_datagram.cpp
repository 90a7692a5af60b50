#include "render_client/viewpoint/head_datagram.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>

#include "common/text/excerpt.h"

namespace copresence::viewpoint {
namespace {

struct Axis {
  const char* name;
  const char* unit;
  double most;
};
constexpr std::array<Axis, 6> kAxes{{{"x", "cm", 500},
                                     {"y", "cm", 500},
                                     {"z", "cm", 500},
                                     {"yaw", "degrees", 180},
                                     {"pitch", "degrees", 180},
                                     {"roll", "degrees", 180}}};

using Values = std::array<double, kAxes.size()>;

/// Requires kDatagramBytes bytes.
Values read_values(std::span<const std::uint8_t> bytes, bool big_endian) {
  Values values;
  for (std::size_t axis = 0; axis < values.size(); ++axis) {
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < 8; ++i) {
      bits = bits << 8 | bytes[8 * axis + (big_endian ? i : 7 - i)];
    }
    values[axis] = std::bit_cast<double>(bits);
  }
  return values;
}

/// Returns the index of the first value that is not finite. If all are finite, returns the index of
/// the first value out of range.
std::optional<std::size_t> first_wrong(const Values& values) {
  const auto first = [&](auto is_wrong) {
    for (std::size_t axis = 0; axis < values.size(); ++axis) {
      if (is_wrong(axis)) return std::optional(axis);
    }
    return std::optional<std::size_t>();
  };
  const auto not_finite = first([&](std::size_t axis) { return !std::isfinite(values[axis]); });
  return not_finite ? not_finite
                    : first([&](std::size_t axis) { return std::abs(values[axis]) > kAxes[axis].most; });
}

/// In the wrong byte order, common numbers become denormal: 128 becomes 1.2e-319. A tracker may
/// also send tiny numbers, but these are not plausible in the other byte order.
bool is_swapped(const Values& values, const Values& swapped) {
  constexpr double kTooSmall = 1e-100, kLeast = 1e-6;
  const bool is_odd = first_wrong(values) || std::any_of(values.begin(), values.end(), [](double value) {
                        return value != 0 && std::abs(value) < kTooSmall;
                      });
  return is_odd && !first_wrong(swapped) && std::all_of(swapped.begin(), swapped.end(), [](double value) {
           return value == 0 || std::abs(value) >= kLeast;
         });
}

}  // namespace

tl::expected<HeadPose, DatagramFault> read_head_pose(std::span<const std::uint8_t> received,
                                                     std::size_t size) {
  if (size != kDatagramBytes) return tl::unexpected(DatagramFault::kSize);
  const Values v = read_values(received, false);
  if (is_swapped(v, read_values(received, true))) return tl::unexpected(DatagramFault::kByteOrder);
  if (const auto wrong = first_wrong(v)) {
    return tl::unexpected(std::isfinite(v[*wrong]) ? DatagramFault::kOutOfRange : DatagramFault::kNotFinite);
  }
  return HeadPose{v[0], v[1], v[2], v[3], v[4], v[5]};
}

std::string describe(DatagramFault fault, std::span<const std::uint8_t> received, std::size_t size) {
  if (fault == DatagramFault::kSize) {
    const std::string_view text(reinterpret_cast<const char*>(received.data()), received.size());
    const bool is_text = !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
      return (c >= 0x20 && c < 0x7F) || c == '\n' || c == '\r' || c == '\t';
    });
    if (is_text) return fmt::format("a text of {} bytes, \"{}\"", size, text::excerpt(text, 40));
    return fmt::format("{} bytes", size);
  }
  if (fault == DatagramFault::kByteOrder) return "48 bytes that make sense in big-endian order only";
  const Values values = read_values(received, false);
  const std::size_t wrong = first_wrong(values).value_or(0);
  return fmt::format("a {} of {:.6g} {}", kAxes[wrong].name, values[wrong], kAxes[wrong].unit);
}

std::string expected_datagram() {
  return "48 bytes: six little-endian doubles, x y z in cm within 500, yaw pitch roll in degrees within 180";
}

}  // namespace copresence::viewpoint
