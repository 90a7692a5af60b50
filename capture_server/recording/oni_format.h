#pragma once

// The .oni file of OpenNI 2, as far as this project writes and reads it. All numbers are little-endian.
//
//   file      header, then records until kEnd
//   header    "NI10"  u8 major 1  u8 minor 0  u16 maintenance 1  u32 build 0  u64 largest timestamp  u32 largest node
//   record    u32 kRecordMagic  u32 RecordType  u32 node  u32 bytes of these 28 and the fields  u32 bytes of
//   the payload
//             u64 undo position | fields | payload
//
//   kNodeAdded    str name  u32 NodeType  u32 codec  u32 frames  u64 first and u64 last timestamp  u64 seek
//   table's position kIntProperty  str key  u32 8  u64 value          kGeneralProperty  str key  u32 n  n
//   bytes kDataBegin    u32 ~0  u64 ~0                     kNewData  u64 timestamp, microseconds  u32 frame,
//   from 1 | payload kSeekTable    | one entry of zeros, then one per frame: u64 timestamp  u32 0  u64
//   position of its kNewData kStateReady, kNodeRemoved, kEnd have no fields. A str is a u32 length with its
//   NUL, then the bytes with the NUL.
//
// OpenNI 1.0 to 1.3 wrote versions 1.0.0.4 to 1.0.0.6, which are read, too. Their "undo position" and the position of a
// seek table are u32, so a record begins with 24 bytes and an entry of a seek table has 16. The last field
// of kNodeAddedOlder (1.0.0.5) is the last timestamp. The last field of kNodeAddedOld (1.0.0.4) is the codec; there the
// kDataBegin record of the node holds the number of frames and the last timestamp.
//
// "undo position" of a kNewData is that of the node's frame before it (0 for the first), of a kNodeRemoved
// that of its kNodeAdded, elsewhere 0.

#include <cstdint>

namespace copresence::recording {

inline constexpr char kFileMagic[4] = {'N', 'I', '1', '0'};
inline constexpr std::uint32_t kHeaderBytes = 24;
inline constexpr std::uint32_t kHeaderTimestampAt = 12;  ///< u64: largest timestamp
inline constexpr std::uint32_t kHeaderNodeAt = 20;       ///< u32: largest node

inline constexpr std::uint32_t kRecordMagic = 0x0052494E;  // "NIR"
inline constexpr std::uint32_t kRecordBytes = 28;          ///< of a record without fields and payload
inline constexpr std::uint32_t kFrameFieldBytes = 12;      ///< the fields of a kNewData
inline constexpr std::uint32_t kSeekEntryBytes = 20;
inline constexpr std::uint32_t kOldRecordBytes = 24, kOldSeekEntryBytes = 16;  ///< of files before 1.0.1

/// The version of a file: as the u64 behind kFileMagic, and whether records have kOldRecordBytes.
inline constexpr std::uint64_t kFileVersion = 0x10001;
constexpr bool is_old_version(std::uint64_t version) {
  return (version & 0xffffffff) == 1 && version >> 32 >= 4;
}

enum class RecordType : std::uint32_t {
  kNodeAddedOld = 0x02,  ///< of 1.0.0.4
  kIntProperty = 0x03,
  kRealProperty = 0x04,
  kStringProperty = 0x05,
  kGeneralProperty = 0x06,
  kNodeRemoved = 0x07,
  kDataBegin = 0x08,
  kStateReady = 0x09,
  kNewData = 0x0A,
  kEnd = 0x0B,
  kNodeAddedOlder = 0x0C,  ///< of 1.0.0.5
  kNodeAdded = 0x0D,
  kSeekTable = 0x0E,
};

enum class NodeType : std::uint32_t { kDevice = 1, kDepth = 2, kImage = 3, kInfrared = 5 };

constexpr std::uint32_t fourcc(const char (&text)[5]) {
  std::uint32_t code = 0;
  for (int i = 3; i >= 0; --i) code = code << 8 | static_cast<unsigned char>(text[i]);
  return code;
}
inline constexpr std::uint32_t kCodecNone = fourcc("NONE");  ///< pixels as they are in memory
inline constexpr std::uint32_t kCodec16z = fourcc("16zT");   ///< lossless depth: recording/depth_16z.h
inline constexpr std::uint32_t kCodecJpeg = fourcc("JPEG");  ///< colour

/// Values of the property "oniPixelFormat".
enum class OniPixelFormat : std::uint32_t {
  kDepthMillimetre = 100,
  kDepth100Micrometres = 101,
  kRgb888 = 200,
  kGray8 = 202,
};

inline constexpr char kCameraNoteProperty[] =
    "copresence.camera";  ///< general: JSON, recording/camera_note.h

inline constexpr char kUnixZeroProperty[] =
    "copresence.unix_zero";  ///< general: i64, microseconds from 1970 (UTC) to the recording's time zero

inline constexpr char kFormerEndProperty[] =
    "copresence.end";  ///< general, no meaning: where a recording once ended, recording/record_end.h

inline constexpr std::uint32_t kMostFrames = 1 << 22;  ///< of one stream: 38 hours

/// Largest timestamp, microseconds: two thousand years, far from where sums of times overflow.
inline constexpr std::uint64_t kMaxTimestamp = std::uint64_t{1} << 56;

/// A recording is played at these rates, frames a second.
inline constexpr double kSlowestRate = 0.1, kFastestRate = 1000;

/// Largest depth value a recording of this unit may hold: what "xnDeviceMaxDepth" says, and viewers size
/// tables by it.
inline constexpr std::uint16_t kMaxDepthMillimetre = 10000;
inline constexpr std::uint16_t kMaxDepth100Micrometres = 65535;

}  // namespace copresence::recording
