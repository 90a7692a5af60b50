#pragma once

// Reads Matroska files, also those that end too early because their program was killed.
//
// The file is not trusted: every size and number is checked, and a damaged part ends the file. Files
// of other programs can be read, too, unless they pack several pictures into a block (lacing) or
// compress blocks. Opening a file reads the head of each block, so that its times are known.
//
// Thread: one thread opens a file; concurrent read() calls are safe.

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/file/input_file.h"
#include "common/matroska/matroska.h"
#include "common/result.h"

namespace copresence::matroska {

/// A block that read() can fetch.
struct BlockPlace {
  std::uint64_t offset = 0;  ///< Position of the picture in the file.
  std::uint32_t bytes = 0;
  Time time{};  ///< Never negative.
  bool is_keyframe = false;
};

class Reader {
 public:
  static constexpr std::uint32_t kMostBlockBytes = 16 << 20;
  static constexpr std::size_t kMostBlocks = 20'000'000;  ///< 23 hours of four cameras with colour.
  static constexpr std::uint64_t kMostHeadBytes = 16 << 20;

  /// Fails with kNotFound if there is no such file, and with kCorrupt if it is not a Matroska file
  /// with tracks. Fails with kUnsupported for files of other programs that it cannot read.
  static Result<Reader> open(const std::string& path);

  const std::vector<Track>& tracks() const { return contents_.tracks; }
  const std::vector<Attachment>& attachments() const { return contents_.attachments; }
  /// The blocks of tracks()[track] in the order of the file.
  const std::vector<BlockPlace>& blocks(std::size_t track) const { return contents_.blocks[track]; }
  /// True if the file ends within an element, or if a part of it is damaged.
  bool is_cut() const { return contents_.is_cut; }

  /// Fails with kUnavailable if the disk fails or the file has become shorter.
  Result<Bytes> read(const BlockPlace& block) const;

 private:
  struct Contents {
    std::vector<Track> tracks;
    std::vector<Attachment> attachments;
    std::vector<std::vector<BlockPlace>> blocks;  // By track.
    bool is_cut = false;
  };
  class Scanner;

  Reader(std::string path, file::InputFile file, Contents contents)
      : path_(std::move(path)), file_(std::move(file)), contents_(std::move(contents)) {}

  std::string path_;
  file::InputFile file_;
  Contents contents_;
};

}  // namespace copresence::matroska
