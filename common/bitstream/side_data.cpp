#include "common/bitstream/side_data.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>

#include "common/frame/bounds.h"

namespace copresence::bitstream {
namespace {

constexpr std::uint8_t kUserDataUnregistered = 5;
constexpr std::uint8_t kStopBit = 0x80;
constexpr std::uint8_t kLayoutVersion = 3;
constexpr std::array<std::uint8_t, 16> kUuid = {0x5c, 0x1e, 0x37, 0xa0, 0x2f, 0x6b, 0x4d, 0x58,
                                                0x9e, 0x43, 0xc0, 0x97, 0xe5, 0x1d, 0x80, 0x6a};
constexpr std::size_t kCrcAt = 16, kCheckedFrom = 20, kFixedBytes = 51, kPoseBytes = 96, kSizeBytes = 4;
// Total size of start code, NAL unit header, payload type, last size byte and stop bit.
constexpr std::size_t kFramingBytes = 8;

enum Flag : std::uint8_t { kHasColor = 1, kHasPose = 2, kHasResiduals = 4 };

class Writer {
 public:
  template <class Unsigned>
  void number(Unsigned value) {
    for (std::size_t i = 0; i < sizeof value; ++i)
      bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  }
  void real(double value) { number(std::bit_cast<std::uint64_t>(value)); }
  void append(std::span<const std::uint8_t> more) { bytes.insert(bytes.end(), more.begin(), more.end()); }

  std::vector<std::uint8_t> bytes;
};

/// Reads little-endian numbers. Reading past the end gives zeros and sets ended_early().
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : rest_(bytes) {}

  std::span<const std::uint8_t> take(std::size_t count) {
    if (count > rest_.size()) {
      ended_early_ = true;
      count = rest_.size();
    }
    const auto taken = rest_.first(count);
    rest_ = rest_.subspan(count);
    return taken;
  }
  template <class Unsigned>
  Unsigned number() {
    Unsigned value = 0;
    int shift = 0;
    for (const std::uint8_t byte : take(sizeof value)) {
      value = static_cast<Unsigned>(value | static_cast<Unsigned>(byte) << shift);
      shift += 8;
    }
    return value;
  }
  double real() { return std::bit_cast<double>(number<std::uint64_t>()); }
  std::size_t left() const { return rest_.size(); }
  bool ended_early() const { return ended_early_; }

 private:
  std::span<const std::uint8_t> rest_;
  bool ended_early_ = false;
};

void write_pose(Writer& writer, const Rigid3& pose) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) writer.real(pose.rotation(row, column));
    writer.real(pose.translation(row));
  }
}

Rigid3 read_pose(Reader& reader) {
  Rigid3 pose;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) pose.rotation(row, column) = reader.real();
    pose.translation(row) = reader.real();
  }
  return pose;
}

/// Extends the CRC-32 `before` by `bytes`. The CRC-32 of no bytes is 0.
std::uint32_t crc(std::span<const std::uint8_t> bytes, std::uint32_t before) {
  return static_cast<std::uint32_t>(crc32_z(before, bytes.data(), bytes.size()));
}

std::uint32_t crc_of_essentials(const std::vector<Nal>& nals, std::uint32_t before) {
  for (const Nal& nal : nals) {
    if (nal.is_essential()) before = crc(nal.bytes, before);
  }
  return before;
}

/// Wraps a payload of type user_data_unregistered into an SEI NAL unit.
std::vector<std::uint8_t> wrap(std::span<const std::uint8_t> payload) {
  std::vector<std::uint8_t> message = {static_cast<std::uint8_t>(NalType::kSei), kUserDataUnregistered};
  std::size_t size = payload.size();
  for (; size >= 255; size -= 255) message.push_back(255);
  message.push_back(static_cast<std::uint8_t>(size));
  message.insert(message.end(), payload.begin(), payload.end());
  message.push_back(kStopBit);
  return to_nal_bytes(message);
}

/// Returns the payload of an SEI NAL unit that holds only our message, otherwise nothing.
std::optional<std::vector<std::uint8_t>> unwrap(const Nal& nal) {
  if (nal.bytes[0] != static_cast<std::uint8_t>(NalType::kSei)) return std::nullopt;
  const std::vector<std::uint8_t> message = from_nal_bytes(nal.bytes);
  if (message.size() < 3 || message[1] != kUserDataUnregistered || message.back() != kStopBit)
    return std::nullopt;
  std::size_t at = 2, size = 0;
  while (at < message.size() && message[at] == 255) size += message[at++];
  if (at == message.size()) return std::nullopt;
  size += message[at++];
  if (at + size + 1 != message.size() || size < kCheckedFrom) return std::nullopt;
  if (!std::equal(kUuid.begin(), kUuid.end(), message.begin() + static_cast<std::ptrdiff_t>(at)))
    return std::nullopt;
  return std::vector<std::uint8_t>(message.begin() + static_cast<std::ptrdiff_t>(at), message.end() - 1);
}

std::uint32_t crc_of_all(std::span<const std::uint8_t> payload, const std::vector<Nal>& depth,
                         const std::vector<Nal>& color) {
  return crc_of_essentials(color, crc_of_essentials(depth, crc(payload.subspan(kCheckedFrom), 0)));
}

}  // namespace

std::size_t side_data_bytes(const SideData& data) {
  const std::size_t payload = kFixedBytes + (data.world_from_camera ? kPoseBytes : 0) + data.table.size() +
                              (data.residuals.empty() ? 0 : kSizeBytes + data.residuals.size()) +
                              data.validity_mask.size();
  return payload + payload / 255 + kFramingBytes;
}

std::vector<std::uint8_t> add_side_data(std::span<const std::uint8_t> depth,
                                        std::span<const std::uint8_t> color, const SideData& data) {
  assert(data.has_color == !color.empty());
  const auto depth_nals = split_access_unit(depth);
  const auto color_nals =
      color.empty() ? Result<std::vector<Nal>>{std::vector<Nal>{}} : split_access_unit(color);
  assert(depth_nals && color_nals);

  Writer writer;
  writer.append(kUuid);
  writer.number<std::uint32_t>(0);  // Placeholder for the CRC.
  writer.number(kLayoutVersion);
  writer.number(static_cast<std::uint8_t>((data.has_color ? kHasColor : 0) |
                                          (data.world_from_camera ? kHasPose : 0) |
                                          (data.residuals.empty() ? 0 : kHasResiduals)));
  writer.number(data.qp);
  writer.number(data.sequence);
  writer.number(data.previous);
  writer.number(static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(data.captured_at.time_since_epoch()).count()));
  if (data.world_from_camera) write_pose(writer, *data.world_from_camera);
  writer.number(static_cast<std::uint32_t>(data.table.size()));
  writer.append(data.table);
  if (!data.residuals.empty()) {
    writer.number(static_cast<std::uint32_t>(data.residuals.size()));
    writer.append(data.residuals);
  }
  writer.append(data.validity_mask);
  const std::uint32_t checksum = crc_of_all(writer.bytes, *depth_nals, *color_nals);
  for (std::size_t i = 0; i < 4; ++i)
    writer.bytes[kCrcAt + i] = static_cast<std::uint8_t>(checksum >> (8 * i));
  const std::vector<std::uint8_t> sei = wrap(writer.bytes);

  std::vector<std::uint8_t> spliced;
  spliced.reserve(depth.size() + sei.size() + 16);
  bool added = false;
  for (const Nal& nal : *depth_nals) {
    if (!nal.is_essential()) continue;
    if (!added && (nal.type() == NalType::kSlice || nal.type() == NalType::kIdrSlice)) {
      append_nal(spliced, sei);
      added = true;
    }
    append_nal(spliced, nal.bytes);
  }
  assert(added);
  return spliced;
}

Result<SideData> extract_side_data(std::span<const std::uint8_t> depth, std::span<const std::uint8_t> color) {
  const auto depth_nals = split_access_unit(depth);
  if (!depth_nals) return fail(depth_nals.error());
  std::vector<Nal> color_nals;
  if (!color.empty()) {
    auto split = split_access_unit(color);
    if (!split) return fail(split.error());
    color_nals = std::move(*split);
  }
  std::optional<std::vector<std::uint8_t>> payload;
  for (const Nal& nal : *depth_nals) {
    if (auto found = unwrap(nal)) {
      if (payload) return fail(ErrorCode::kCorrupt, "a depth access unit carries side data twice");
      payload = std::move(found);
    }
  }
  if (!payload) return fail(ErrorCode::kCorrupt, "a depth access unit carries no side data");

  Reader reader(*payload);
  reader.take(kCrcAt);
  if (reader.number<std::uint32_t>() != crc_of_all(*payload, *depth_nals, color_nals)) {
    return fail(ErrorCode::kCorrupt, "an access unit is damaged: its checksum differs");
  }
  // From here on the bytes are as the server sent them. A malicious server can send any bytes.
  const auto version = reader.number<std::uint8_t>();
  const auto flags = reader.number<std::uint8_t>();
  if (version != kLayoutVersion || (flags & ~(kHasColor | kHasPose | kHasResiduals)) != 0) {
    return fail(ErrorCode::kCorrupt, "the side data of an access unit has a layout of another version");
  }
  SideData data;
  data.has_color = (flags & kHasColor) != 0;
  data.qp = reader.number<std::uint8_t>();
  data.sequence = reader.number<std::uint64_t>();
  data.previous = reader.number<std::uint64_t>();
  const auto captured_at = instant_from_nanoseconds(reader.number<std::uint64_t>());
  if (!captured_at || !is_within_bounds(data.sequence) || !is_within_bounds(data.previous)) {
    return fail(ErrorCode::kCorrupt, "a frame with an impossible capture time or number");
  }
  data.captured_at = *captured_at;
  if (flags & kHasPose) {
    data.world_from_camera = read_pose(reader);
    if (const auto pose = check_pose(*data.world_from_camera); !pose) {
      return fail(ErrorCode::kCorrupt, "a frame's side data: " + pose.error().what);
    }
  }
  const auto table = reader.take(reader.number<std::uint32_t>());
  data.table.assign(table.begin(), table.end());
  if (flags & kHasResiduals) {
    const auto residuals = reader.take(reader.number<std::uint32_t>());
    data.residuals.assign(residuals.begin(), residuals.end());
    if (residuals.empty())
      return fail(ErrorCode::kCorrupt, "the side data of an access unit lacks its residuals");
  }
  const auto mask = reader.take(reader.left());
  data.validity_mask.assign(mask.begin(), mask.end());
  if (reader.ended_early()) return fail(ErrorCode::kCorrupt, "the side data of an access unit ends early");
  if (data.has_color == color.empty()) {
    return fail(ErrorCode::kCorrupt, "a frame's colour picture is missing or belongs to another frame");
  }
  return data;
}

}  // namespace copresence::bitstream
