#pragma once

// Writes and reads EBML elements, of which a Matroska file consists. An element is an identifier, a
// size and then that many bytes: a number, a text, bytes or further elements. Private to this
// module.
//
// Source: RFC 8794. Thread: pure functions; distinct objects are independent.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "common/matroska/matroska.h"

namespace copresence::matroska {

/// The identifiers with their length markers, as they are in the file.
enum class Id : std::uint32_t {
  kEbml = 0x1A45DFA3,
  kEbmlVersion = 0x4286,
  kEbmlReadVersion = 0x42F7,
  kEbmlMaxIdLength = 0x42F2,
  kEbmlMaxSizeLength = 0x42F3,
  kDocType = 0x4282,
  kDocTypeVersion = 0x4287,
  kDocTypeReadVersion = 0x4285,
  kVoid = 0xEC,
  kSegment = 0x18538067,
  kSeekHead = 0x114D9B74,
  kSeek = 0x4DBB,
  kSeekId = 0x53AB,
  kSeekPosition = 0x53AC,
  kInfo = 0x1549A966,
  kTimestampScale = 0x2AD7B1,
  kDuration = 0x4489,
  kDateUtc = 0x4461,
  kTitle = 0x7BA9,
  kMuxingApp = 0x4D80,
  kWritingApp = 0x5741,
  kTracks = 0x1654AE6B,
  kTrackEntry = 0xAE,
  kTrackNumber = 0xD7,
  kTrackUid = 0x73C5,
  kTrackType = 0x83,
  kFlagDefault = 0x88,
  kFlagLacing = 0x9C,
  kDefaultDuration = 0x23E383,
  kName = 0x536E,
  kLanguage = 0x22B59C,
  kCodecId = 0x86,
  kCodecPrivate = 0x63A2,
  kContentEncodings = 0x6D80,
  kVideo = 0xE0,
  kPixelWidth = 0xB0,
  kPixelHeight = 0xBA,
  kAttachments = 0x1941A469,
  kAttachedFile = 0x61A7,
  kFileDescription = 0x467E,
  kFileName = 0x466E,
  kFileMediaType = 0x4660,
  kFileData = 0x465C,
  kFileUid = 0x46AE,
  kCluster = 0x1F43B675,
  kTimestamp = 0xE7,
  kSimpleBlock = 0xA3,
  kBlockGroup = 0xA0,
  kBlock = 0xA1,
  kReferenceBlock = 0xFB,
  kCues = 0x1C53BB6B,
  kCuePoint = 0xBB,
  kCueTime = 0xB3,
  kCueTrackPositions = 0xB7,
  kCueTrack = 0xF7,
  kCueClusterPosition = 0xF1,
};

/// The size field of an element that lasts until the next element of its level or above.
inline constexpr std::uint64_t kUnknownSize = (std::uint64_t{1} << 56) - 1;
inline constexpr std::size_t kLongSizeBytes = 8;  ///< Bytes that append_long_size() appends.

/// Appends an element to `out`. Numbers and sizes take as few bytes as possible.
void append_number(Bytes& out, Id id, std::uint64_t value);
void append_real(Bytes& out, Id id, double value);
void append_text(Bytes& out, Id id, std::string_view value);
void append_bytes(Bytes& out, Id id, std::span<const std::uint8_t> value);

void append_id(Bytes& out, Id id);
void append_size(Bytes& out, std::uint64_t size);
/// Appends a size in eight bytes, so that another size can replace it. Requires size <=
/// kUnknownSize.
void append_long_size(Bytes& out, std::uint64_t size);
/// Appends a number as an element of eight bytes, so that another number can replace it.
void append_long_number(Bytes& out, Id id, std::uint64_t value);

/// The beginning of an element.
struct ElementHead {
  Id id{};
  std::uint64_t bytes = 0;     ///< Size of the contents; kUnknownSize if it is unknown.
  std::size_t head_bytes = 0;  ///< Size of identifier and size field.
  static constexpr std::size_t kMostBytes = 12;
};

/// Reads the head of the element at the beginning of `bytes`. Returns nothing if the bytes are no
/// element, or end within the head.
std::optional<ElementHead> read_element_head(std::span<const std::uint8_t> bytes);

struct Element {
  Id id{};
  std::span<const std::uint8_t> contents;

  std::uint64_t number() const;  ///< The contents as an unsigned number; 0 if longer than 8 bytes.
  std::string text() const;      ///< The contents up to the first zero byte.
};

/// Reads elements that follow each other.
class ElementReader {
 public:
  explicit ElementReader(std::span<const std::uint8_t> bytes) : left_(bytes) {}

  /// Returns the next element. Returns nothing at the end, and for bytes that are no element.
  std::optional<Element> next();

 private:
  std::span<const std::uint8_t> left_;
};

}  // namespace copresence::matroska
