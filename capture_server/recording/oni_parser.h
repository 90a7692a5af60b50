#pragma once

// The strict parser of a recording. The parser reads the record chain once, by the rules of
// OpenNI2's player (oni_check.h). The tolerant parser is in oni_recovery.h.

#include <cstdint>
#include <map>
#include <string>

#include "capture_server/recording/oni_check.h"
#include "capture_server/recording/record_bytes.h"
#include "capture_server/recording/stream_format.h"

namespace copresence::recording {

class OniParser {
 public:
  /// `name` is the recording's name in messages. Both arguments must outlive this object.
  OniParser(RecordBytes& bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  /// Parses the recording. Call run() only once per object.
  Result<RecordingSummary> run();

 private:
  struct Record : RecordHead {
    std::uint64_t at = 0;  ///< Position of the record in the file.
  };

  struct Node {
    enum class Life { kConfiguring, kReady, kRemoved };
    Life life = Life::kConfiguring;
    bool is_stream = false;
    std::uint32_t frames_claimed = 0;
    bool is_counted_at_data = false;  ///< True if its kDataBegin has the number of frames.
    std::uint64_t seek_table_at = 0;  ///< Position of the seek table that the definition states, or 0.
    bool has_seek_table = false;      ///< True if a table of the right size was found.
    std::uint64_t max_payload = 0;
    StreamFormat format;  ///< The format must not change once the node is ready.
    RecordedStream stream;
  };

  Result<void> header();
  Result<Record> next_record();
  Result<void> read(const Record& record);
  Result<void> node_added(const Record& record, FieldReader fields);
  Result<void> property(const Record& record, FieldReader fields);
  Result<void> state_ready(const Record& record);
  Result<void> node_removed(const Record& record);
  Result<void> data_begin(const Record& record, FieldReader fields);
  Result<void> new_data(const Record& record, FieldReader fields);
  Result<void> seek_table(const Record& record);
  Result<RecordingSummary> summary();

  std::uint32_t record_bytes() const { return is_old_ ? kOldRecordBytes : kRecordBytes; }
  Node* find(std::uint32_t id);
  tl::unexpected<Error> damaged(std::uint64_t at, const std::string& what) const;
  tl::unexpected<Error> cut_off(std::uint64_t at) const;
  tl::unexpected<Error> unusable(const std::string& what) const;
  tl::unexpected<Error> placed(std::uint64_t at, const Error& error) const;

  RecordBytes& bytes_;
  const std::string& name_;
  std::uint64_t position_ = 0;
  std::uint64_t max_timestamp_ = 0;
  std::uint32_t max_node_ = 0;
  bool data_begun_ = false;
  /// Number of nodes between kNodeAdded and kStateReady. Definitions may nest.
  std::uint32_t configuring_ = 0;
  std::map<std::uint32_t, Node> nodes_;
  std::optional<CameraMetadata> camera_metadata_;
  std::optional<std::int64_t> unix_zero_us_;
  bool is_old_ = false;  ///< True for files of OpenNI 1.0 to 1.3, with shorter records.
};

}  // namespace copresence::recording
