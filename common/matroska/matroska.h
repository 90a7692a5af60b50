#pragma once

// The contents of a Matroska file (.mkv). A file has tracks and attached files. A track consists of
// blocks. A block has a time and holds one picture.
//
// Source: RFC 9559 (Matroska) and RFC 8794 (EBML, the structure below it). Thread: values.

#include <chrono>
#include <cstdint>
#include <ratio>
#include <string>
#include <vector>

namespace copresence::matroska {

using Bytes = std::vector<std::uint8_t>;

/// The time of a block since the beginning of the file. A tick of 0.1 ms is short against a frame
/// period. Blocks of a cluster are at most 3.2 s from the cluster's time, so that 16 bits suffice.
using Time = std::chrono::duration<std::int64_t, std::ratio<1, 10'000>>;

/// A video track.
struct Track {
  std::string name = {};  ///< Players show it in their lists of tracks.
  std::string codec = "V_MPEG4/ISO/AVC";
  Bytes codec_private = {};  ///< For H.264, the AVC configuration record.
  int width = 0, height = 0;
  std::chrono::nanoseconds frame_period = {};  ///< The nominal period; 0 if unknown.
  bool is_default = true;                      ///< Whether players show this track by default.
};

struct Attachment {
  std::string name = {};  ///< A file name.
  std::string description = {};
  std::string media_type = {};
  Bytes bytes = {};
};

}  // namespace copresence::matroska
