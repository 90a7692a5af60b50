#pragma once

// Writes a Matroska file that is valid at every moment, also if the program is killed.
//
// The file begins with a head of fixed size: information, tracks and attachments, then padding. The
// head can grow into the padding, so that tracks may be added while blocks are written. Each block
// is appended to the file at once. A cluster has an unknown size until the next one begins. finish()
// writes indexes. Without them, a player takes a little longer to find a position.
//
// Thread: one thread at a time.

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/file/output_file.h"
#include "common/matroska/matroska.h"
#include "common/result.h"

namespace copresence::matroska {

class Writer {
 public:
  struct Heading {
    std::string title = {};
    std::string program = {};  ///< Name and version of the program that writes the file.
    std::optional<std::chrono::system_clock::time_point> began_at = {};  ///< The time of tick 0.
    std::size_t head_bytes = 4096;  ///< Space for tracks and attachments, in bytes.
  };
  /// Takes over an empty file. Fails as OutputFile::append() does.
  static Result<Writer> begin(file::OutputFile file, Heading heading);

  /// Returns the number of the new track, from 1. Fails with kUnsupported if the head is full.
  Result<std::uint64_t> add_track(Track track);
  Result<void> add_attachment(Attachment attachment);

  struct Block {
    std::uint64_t track;  ///< A number that add_track() has returned.
    bool is_keyframe;
    std::span<const std::uint8_t> bytes;
  };
  /// Appends the blocks of one instant, all or none. Requires time >= 0. Fails as
  /// OutputFile::append() does. The file then ends with the block before.
  Result<void> write(Time time, std::span<const Block> blocks);
  Result<void> write(Time time, const Block& block) { return write(time, std::span(&block, 1)); }

  /// Writes sizes, duration and index. Call it last, also after a failure. It fails only if the
  /// file cannot be changed; an index that finds no room is left out.
  Result<void> finish();

  const std::string& path() const { return file_.path(); }
  std::uint64_t bytes() const { return file_.size(); }
  Time duration() const { return last_time_; }

 private:
  struct Cue {
    std::uint64_t track;
    Time time;
    std::uint64_t cluster;  // Position of the cluster in the segment.
  };

  Writer(file::OutputFile file, Heading heading) : file_(std::move(file)), heading_(std::move(heading)) {}

  Result<void> write_head();
  Bytes information() const;
  Bytes track_list() const;
  Bytes attachment_list() const;
  Bytes seek_head(std::uint64_t information, std::uint64_t tracks, std::uint64_t attachments) const;
  Result<void> begin_cluster(Time time);
  Result<void> end_cluster();
  Bytes cue_list() const;

  file::OutputFile file_;
  Heading heading_;
  std::uint64_t segment_at_ = 0;  // Position of the segment's contents in the file.
  std::vector<Track> tracks_;
  std::vector<Attachment> attachments_;
  std::optional<std::uint64_t> cluster_at_;  // Position of the open cluster in the file.
  Time cluster_time_{};
  Time last_time_{};
  std::vector<Cue> cues_;
  std::uint64_t cues_at_ = 0;  // Position of the index in the segment; 0 without one.
  bool is_finished_ = false;
};

}  // namespace copresence::matroska
