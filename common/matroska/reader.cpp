#include "common/matroska/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <utility>

#include "common/matroska/ebml.h"
#include "common/text/excerpt.h"

namespace copresence::matroska {
namespace {

constexpr std::size_t kMostTracks = 1024, kMostAttachments = 1024;
constexpr std::uint64_t kDefaultScale = 1'000'000;  // Nanoseconds in a unit of a timestamp.
constexpr std::uint64_t kMostScale = 1'000'000'000;
constexpr std::uint64_t kMostNanoseconds = std::uint64_t{1} << 61;
constexpr std::uint8_t kKeyframeFlag = 0x80, kLacingFlags = 0x06;

/// Elements whose contents are scanned in order like those of the level above.
bool is_entered(Id id) {
  return id == Id::kSegment || id == Id::kCluster || id == Id::kBlockGroup;
}

Track read_track(std::span<const std::uint8_t> contents, std::uint64_t& number, bool& is_compressed) {
  Track track;
  track.codec.clear();
  ElementReader elements(contents);
  while (const auto element = elements.next()) {
    if (element->id == Id::kTrackNumber) number = element->number();
    if (element->id == Id::kName) track.name = element->text();
    if (element->id == Id::kCodecId) track.codec = element->text();
    if (element->id == Id::kCodecPrivate)
      track.codec_private.assign(element->contents.begin(), element->contents.end());
    if (element->id == Id::kFlagDefault) track.is_default = element->number() != 0;
    if (element->id == Id::kContentEncodings) is_compressed = true;
    if (element->id != Id::kVideo) continue;
    ElementReader video(element->contents);
    while (const auto part = video.next()) {
      const int pixels = static_cast<int>(std::min<std::uint64_t>(part->number(), 1 << 16));
      if (part->id == Id::kPixelWidth) track.width = pixels;
      if (part->id == Id::kPixelHeight) track.height = pixels;
    }
  }
  return track;
}

}  // namespace

/// Reads the structure of a file: everything but the pictures.
class Reader::Scanner {
 public:
  Scanner(const std::string& path, const file::InputFile& file) : path_(path), file_(file) {}

  Result<Contents> scan();

 private:
  Result<void> read_element(const ElementHead& head, std::uint64_t at);
  Result<void> read_tracks(std::span<const std::uint8_t> contents);
  void read_attachments(std::span<const std::uint8_t> contents);
  Result<void> note_block(std::uint64_t at, std::uint64_t bytes, bool is_simple);

  const std::string& path_;
  const file::InputFile& file_;
  Contents found_;
  std::vector<std::uint64_t> numbers_;  // The tracks' numbers.
  bool has_tracks_ = false;
  std::uint64_t scale_ = kDefaultScale;
  std::uint64_t cluster_time_ = 0;  // In units of scale_.
  std::size_t blocks_ = 0;
  BlockPlace* grouped_ = nullptr;  // The block of the current BlockGroup, if there is one.
};

Result<Reader> Reader::open(const std::string& path) {
  auto file = file::InputFile::open(path, "a Matroska file (.mkv)");
  if (!file) return fail(file.error());
  auto contents = Scanner(path, *file).scan();
  if (!contents) return fail(contents.error());
  return Reader(path, std::move(*file), std::move(*contents));
}

Result<Reader::Contents> Reader::Scanner::scan() {
  std::array<std::uint8_t, ElementHead::kMostBytes> bytes{};
  const std::uint64_t size = file_.size();
  for (std::uint64_t at = 0; at < size;) {
    const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(bytes.size(), size - at));
    const auto window = std::span(bytes).first(wanted);
    const auto head = file_.read(at, window) ? read_element_head(window) : std::nullopt;
    if (at == 0 && (!head || head->id != Id::kEbml))
      return fail(ErrorCode::kCorrupt, fmt::format("{}: is no Matroska file (.mkv)", path_));
    const bool is_known_size = head && head->bytes != kUnknownSize;
    const std::uint64_t contents = head ? at + head->head_bytes : size;
    const bool is_whole = is_known_size && head->bytes <= size - contents;
    if (!head || (!is_whole && !is_entered(head->id))) {
      found_.is_cut = true;
      break;
    }
    if (is_entered(head->id)) {
      found_.is_cut = found_.is_cut || (is_known_size && !is_whole);
      at = contents;
      grouped_ = nullptr;
      continue;
    }
    if (auto read = read_element(*head, contents); !read) return fail(read.error());
    at = contents + head->bytes;
  }
  if (!has_tracks_) return fail(ErrorCode::kCorrupt, fmt::format("{}: has no tracks", path_));
  return std::move(found_);
}

Result<void> Reader::Scanner::read_element(const ElementHead& head, std::uint64_t at) {
  if (head.id == Id::kSimpleBlock || head.id == Id::kBlock)
    return note_block(at, head.bytes, head.id == Id::kSimpleBlock);
  if (head.id == Id::kReferenceBlock && grouped_) grouped_->is_keyframe = false;
  const bool is_wanted = head.id == Id::kEbml || head.id == Id::kInfo || head.id == Id::kTracks ||
                         head.id == Id::kAttachments || head.id == Id::kTimestamp;
  if (!is_wanted) return {};
  if (head.bytes > kMostHeadBytes)
    return fail(ErrorCode::kCorrupt, fmt::format("{}: has an element of {} bytes", path_, head.bytes));
  Bytes contents(head.bytes);
  if (!file_.read(at, contents))
    return fail(ErrorCode::kUnavailable, fmt::format("{}: cannot be read", path_));
  const Element element{head.id, contents};
  if (head.id == Id::kTracks) return read_tracks(contents);
  if (head.id == Id::kAttachments) {
    read_attachments(contents);
    return {};
  }
  if (head.id == Id::kTimestamp) {
    cluster_time_ = element.number();
    return {};
  }
  ElementReader elements(contents);
  while (const auto child = elements.next()) {
    if (head.id == Id::kEbml && child->id == Id::kDocType && child->text() != "matroska" &&
        child->text() != "webm") {
      return fail(ErrorCode::kCorrupt, fmt::format("{}: is no Matroska file (.mkv), but \"{}\"", path_,
                                                   text::excerpt(child->text())));
    }
    if (head.id == Id::kInfo && child->id == Id::kTimestampScale) scale_ = child->number();
  }
  if (scale_ == 0 || scale_ > kMostScale)
    return fail(ErrorCode::kCorrupt, fmt::format("{}: its times have an impossible unit", path_));
  return {};
}

Result<void> Reader::Scanner::read_tracks(std::span<const std::uint8_t> contents) {
  if (std::exchange(has_tracks_, true)) return {};  // Later copies repeat the first list.
  ElementReader elements(contents);
  while (const auto element = elements.next()) {
    if (element->id != Id::kTrackEntry) continue;
    if (found_.tracks.size() == kMostTracks)
      return fail(ErrorCode::kCorrupt, fmt::format("{}: has more than {} tracks", path_, kMostTracks));
    std::uint64_t number = 0;
    bool is_compressed = false;
    found_.tracks.push_back(read_track(element->contents, number, is_compressed));
    numbers_.push_back(number);
    if (is_compressed) {
      return fail(ErrorCode::kUnsupported,
                  fmt::format("{}: the blocks of track \"{}\" are compressed; write the file again without "
                              "compression, for example with ffmpeg -c copy -map 0",
                              path_, text::excerpt(found_.tracks.back().name)));
    }
  }
  found_.blocks.resize(found_.tracks.size());
  return {};
}

void Reader::Scanner::read_attachments(std::span<const std::uint8_t> contents) {
  ElementReader elements(contents);
  while (const auto element = elements.next()) {
    if (element->id != Id::kAttachedFile || found_.attachments.size() == kMostAttachments) continue;
    Attachment attachment;
    ElementReader parts(element->contents);
    while (const auto part = parts.next()) {
      if (part->id == Id::kFileName) attachment.name = part->text();
      if (part->id == Id::kFileDescription) attachment.description = part->text();
      if (part->id == Id::kFileMediaType) attachment.media_type = part->text();
      if (part->id == Id::kFileData) attachment.bytes.assign(part->contents.begin(), part->contents.end());
    }
    found_.attachments.push_back(std::move(attachment));
  }
}

Result<void> Reader::Scanner::note_block(std::uint64_t at, std::uint64_t bytes, bool is_simple) {
  grouped_ = nullptr;
  std::array<std::uint8_t, 12> start{};
  const auto head = std::span(start).first(static_cast<std::size_t>(std::min<std::uint64_t>(bytes, 12)));
  if (head.empty() || !file_.read(at, head) || start[0] == 0) {
    found_.is_cut = true;
    return {};
  }
  // The track's number is coded like a size. Numbers of more than two bytes are not used.
  const std::size_t number_bytes = (start[0] & 0x80) != 0 ? 1 : 2;
  const std::uint64_t number = number_bytes == 1 ? start[0] & 0x7F : (start[0] & 0x3F) << 8 | start[1];
  const std::size_t head_bytes = number_bytes + 3;
  const auto track = std::find(numbers_.begin(), numbers_.end(), number);
  if (track == numbers_.end() || bytes <= head_bytes || bytes - head_bytes > kMostBlockBytes) {
    found_.is_cut = true;
    return {};
  }
  const auto from_cluster = static_cast<std::int16_t>(start[number_bytes] << 8 | start[number_bytes + 1]);
  const std::uint8_t flags = start[number_bytes + 2];
  if ((flags & kLacingFlags) != 0) {
    return fail(ErrorCode::kUnsupported,
                fmt::format("{}: has several pictures in one block (lacing), which is not supported", path_));
  }
  const std::uint64_t most = kMostNanoseconds / scale_;
  if (cluster_time_ > most || ++blocks_ > kMostBlocks) {
    found_.is_cut = true;
    return {};
  }
  const std::int64_t units =
      std::max<std::int64_t>(static_cast<std::int64_t>(cluster_time_) + from_cluster, 0);
  const std::chrono::nanoseconds time(units * static_cast<std::int64_t>(scale_));
  auto& blocks = found_.blocks[static_cast<std::size_t>(track - numbers_.begin())];
  blocks.push_back({at + head_bytes, static_cast<std::uint32_t>(bytes - head_bytes),
                    std::chrono::round<Time>(time), !is_simple || (flags & kKeyframeFlag) != 0});
  if (!is_simple) grouped_ = &blocks.back();
  return {};
}

Result<Bytes> Reader::read(const BlockPlace& block) const {
  Bytes bytes(block.bytes);
  if (!file_.read(block.offset, bytes))
    return fail(ErrorCode::kUnavailable, fmt::format("{}: cannot be read at byte {}", path_, block.offset));
  return bytes;
}

}  // namespace copresence::matroska
