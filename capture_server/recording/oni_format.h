#pragma once

// The .oni file format of OpenNI 2, as far as this project reads and writes it. Numbers are
// little-endian.
//
//   `file`: header, then records up to kEnd.
//   `header`: char[4] "NI10"; version: u8 1, u8 0, u16 1, u32 0; u64 largest timestamp;
//             u32 largest node.
//   `record`: u32 kRecordMagic; u32 RecordType; u32 node; u32 size of these 28 bytes and the fields;
//             u32 size of the payload; u64 undo position; fields; payload.
//   `str`: u32 length with the final NUL; the bytes with the NUL.
//
//   type               fields                                                    payload
//   kNodeAdded         str name, u32 NodeType, u32 codec, u32 frames,            none
//                      u64 first timestamp, u64 last timestamp,
//                      u64 position of the seek table
//   kIntProperty       str key, u32 8, u64 value                                 none
//   kGeneralProperty   str key, u32 n, n bytes                                   none
//   kDataBegin         u32 ~0, u64 ~0                                            none
//   kNewData           u64 timestamp in microseconds, u32 frame number from 1    coded picture
//   kSeekTable         none                                                      entries
//   kStateReady, kNodeRemoved, kEnd: no fields, no payload
//
//   Entry of a seek table: u64 timestamp, u32 0, u64 position of the kNewData. The first entry is
//   zeros, then there is one per frame.
//
// An undo position depends on the record's type. For a kNewData, the undo position is the position
// of the node's previous frame, or 0 for the first. For a kNodeRemoved, the undo position is the
// position of its kNodeAdded. Other records have 0.
//
// OpenNI 1.0 to 1.3 wrote versions 1.0.0.4 to 1.0.0.6, which this project can also read:
// - Undo positions and positions of seek tables are u32. So a record begins with 24 bytes, and an
//   entry of a seek table has 16.
// - kNodeAddedOlder (1.0.0.5) ends with the last timestamp.
// - kNodeAddedOld (1.0.0.4) ends with the codec. The node's kDataBegin has the number of frames and
//   the last timestamp.

#include <cstdint>

namespace copresence::recording {

inline constexpr char kFileMagic[4] = {'N', 'I', '1', '0'};
inline constexpr std::uint32_t kHeaderBytes = 24;
inline constexpr std::uint32_t kHeaderTimestampAt = 12;  ///< Position of the largest timestamp, a u64.
inline constexpr std::uint32_t kHeaderNodeAt = 20;       ///< Position of the largest node, a u32.

inline constexpr std::uint32_t kRecordMagic = 0x0052494E;  // The characters "NIR".
inline constexpr std::uint32_t kRecordBytes = 28;          ///< Size of a record's head.
/// Limit for one record. The largest real fields are tables of depth levels with 20 kB.
inline constexpr std::uint32_t kMaxFields = 1 << 20;
inline constexpr std::uint32_t kFrameFieldBytes = 12;  ///< Size of a kNewData's fields.
inline constexpr std::uint32_t kSeekEntryBytes = 20;
inline constexpr std::uint32_t kOldRecordBytes = 24, kOldSeekEntryBytes = 16;  ///< In files before 1.0.1.

/// The version of a file, read as a u64 after kFileMagic.
inline constexpr std::uint64_t kFileVersion = 0x10001;
constexpr bool is_old_version(std::uint64_t version) {
  return (version & 0xffffffff) == 1 && version >> 32 >= 4;
}

enum class RecordType : std::uint32_t {
  kNodeAddedOld = 0x02,  ///< Only in version 1.0.0.4.
  kIntProperty = 0x03,
  kRealProperty = 0x04,
  kStringProperty = 0x05,
  kGeneralProperty = 0x06,
  kNodeRemoved = 0x07,
  kDataBegin = 0x08,
  kStateReady = 0x09,
  kNewData = 0x0A,
  kEnd = 0x0B,
  kNodeAddedOlder = 0x0C,  ///< Only in version 1.0.0.5.
  kNodeAdded = 0x0D,
  kSeekTable = 0x0E,
};

enum class NodeType : std::uint32_t { kDevice = 1, kDepth = 2, kImage = 3, kInfrared = 5 };

constexpr std::uint32_t fourcc(const char (&text)[5]) {
  std::uint32_t code = 0;
  for (int i = 3; i >= 0; --i) code = code << 8 | static_cast<unsigned char>(text[i]);
  return code;
}
inline constexpr std::uint32_t kCodecNone = fourcc("NONE");  ///< Uncoded pixels, as in memory.
inline constexpr std::uint32_t kCodec16z = fourcc("16zT");   ///< Lossless depth, see recording/depth_16z.h.
inline constexpr std::uint32_t kCodecJpeg = fourcc("JPEG");  ///< JPEG pictures of colour.

/// Values of the property "oniPixelFormat".
enum class OniPixelFormat : std::uint32_t {
  kDepthMillimetre = 100,
  kDepth100Micrometres = 101,
  kRgb888 = 200,
  kGray8 = 202,
};

/// General property: JSON, see recording/camera_metadata.h.
inline constexpr char kCameraMetadataProperty[] = "copresence.camera";

/// General property, i64: microseconds from 1970 (UTC) to the recording's time zero.
inline constexpr char kUnixZeroProperty[] = "copresence.unix_zero";

/// General property of a depth stream: for each disparity of the sensor, its depth as u16, or 0.
inline constexpr char kDisparityTableProperty[] = "S2D";

/// General property that players ignore. It contains a former footer (recording/oni_footer.h).
inline constexpr char kFormerEndProperty[] = "copresence.end";

inline constexpr std::uint32_t kMostFrames = 1 << 22;  ///< Largest number of frames in one stream: 38 hours.

/// Largest timestamp in microseconds. This limit is 2284 years, so sums of times do not overflow.
inline constexpr std::uint64_t kMaxTimestamp = std::uint64_t{1} << 56;

/// Frame rates at which a recording can be played.
inline constexpr double kSlowestRate = 0.1, kFastestRate = 1000;

/// Largest depth value in a recording of this unit, for the property "xnDeviceMaxDepth". Viewers
/// size their tables by this value.
inline constexpr std::uint16_t kMaxDepthMillimetre = 10000;
inline constexpr std::uint16_t kMaxDepth100Micrometres = 65535;

}  // namespace copresence::recording
