#include "capture_server/recording/oni_repair.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <vector>

#include "capture_server/recording/oni_check.h"
#include "capture_server/recording/oni_footer.h"
#include "capture_server/recording/oni_format.h"
#include "capture_server/recording/oni_recovery.h"
#include "capture_server/recording/record_bytes.h"
#include "common/file/input_file.h"
#include "common/file/output_file.h"

namespace copresence::recording {
namespace {

using Bytes = RecordBytesOut;

constexpr std::uint64_t kCopyStep = 1 << 20;
// Largest size of one property, since players read it into a buffer.
constexpr std::uint64_t kLargestSkip = 16 << 10;

Result<void> copy_bytes(const file::InputFile& from, std::uint64_t begin, std::uint64_t end,
                        file::OutputFile& to, const std::string& name, const ProgressReport& progress) {
  Bytes chunk;
  for (std::uint64_t at = begin; at < end; at += chunk.size()) {
    chunk.resize(std::min(kCopyStep, end - at));
    if (!from.read(at, chunk)) {
      return fail(ErrorCode::kUnavailable,
                  fmt::format("{}: cannot be read at byte {}; check the disk", name, at));
    }
    if (auto written = to.append(chunk); !written) return written;
    progress(static_cast<double>(at + chunk.size()) / static_cast<double>(end));
  }
  return {};
}

bool is_same_file(const std::string& a, const std::string& b) {
  std::error_code ignored;
  return std::filesystem::equivalent(a, b, ignored);
}

Result<void> refuse_same(const std::string& path, const std::string& out) {
  if (!is_same_file(path, out)) return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("{}: --out names the recording itself; give another name", out));
}

std::uint64_t skip_overhead(std::uint32_t node) {
  Bytes bytes;
  append_general(bytes, node, kFormerEndProperty, {});
  return bytes.size();
}

Result<void> pass_over(file::OutputFile& file, const Gap& gap, std::uint32_t node, const std::string& name) {
  const std::uint64_t overhead = skip_overhead(node);
  for (std::uint64_t at = gap.from; at < gap.to;) {
    const std::uint64_t left = gap.to - at;
    if (left < overhead) {
      return fail(ErrorCode::kCorrupt,
                  fmt::format("{}: the damage at byte {} is too small to be skipped", name, gap.from));
    }
    const std::uint64_t size = left <= kLargestSkip ? left : std::min(kLargestSkip, left - overhead);
    Bytes bytes;
    append_general(bytes, node, kFormerEndProperty, Bytes(size - overhead, 0));
    if (auto written = file.write_at(at, bytes); !written) return written;
    at += size;
  }
  return {};
}

// The check and the player require frame numbers without gaps.
Result<void> renumber(file::OutputFile& file, const RecoveredStream& stream) {
  for (std::size_t i = 0; i < stream.frames.size(); ++i) {
    if (stream.frames[i].number == i + 1) continue;
    Bytes number;
    append_number(number, i + 1, 4);
    if (auto written = file.write_at(stream.frames[i].position + kRecordBytes + 8, number); !written) {
      return written;
    }
  }
  return {};
}

Result<void> finish(file::OutputFile& file, const RecoveredRecording& found, const std::string& name) {
  // True if the former footer stays in the file as a property.
  const bool end_stays = !found.has_end || !found.has_seek_tables;
  const std::uint64_t keep = end_stays ? found.whole_until : found.end_position;
  if (file.size() > keep) {
    if (auto cut = file.truncate(keep); !cut) return cut;
  }
  for (const Gap& gap : found.gaps) {
    if (auto passed = pass_over(file, gap, found.streams.front().node, name); !passed) return passed;
  }
  std::vector<FooterStream> ended;
  std::vector<std::vector<FramePlace>> places;
  for (const RecoveredStream& stream : found.streams) {
    if (auto numbered = renumber(file, stream); !numbered) return numbered;
    places.push_back(stream.places());
  }
  for (std::size_t i = 0; i < found.streams.size(); ++i) {
    const RecoveredStream& stream = found.streams[i];
    ended.push_back({stream.node, stream.added_position, stream.counts_position, places[i]});
  }
  Bytes largest_node;
  append_number(largest_node, found.largest_node, 4);
  if (auto written = file.write_at(kHeaderNodeAt, largest_node); !written) return written;
  if (auto done = write_footer(file, ended, SeekTables::kYes, found.footers); !done)
    return fail(done.error());
  return file.close();
}

// A frame to write, and the index of its stream.
struct Wanted {
  const RecoveredFrame* frame;
  std::size_t stream;
};

// Position of a stream's definition in the new file.
struct DefinitionPlace {
  std::uint64_t added_position = 0, counts_position = 0;
};

// Converts the records before the first frame of an old file to the current format. Returns the
// position of each stream's definition.
Result<std::vector<DefinitionPlace>> modernise_definitions(const file::InputFile& input,
                                                           const RecoveredRecording& found,
                                                           file::OutputFile& file, const std::string& name) {
  const auto unreadable = [&] {
    return fail(ErrorCode::kCorrupt, fmt::format("{}: its streams' definitions cannot be read", name));
  };
  std::vector<DefinitionPlace> places(found.streams.size());
  Bytes out = file_header(0, found.largest_node);
  Bytes record;
  for (std::uint64_t at = kHeaderBytes; at < found.first_frame_position; at += record.size()) {
    record.resize(kOldRecordBytes);
    if (!input.read(at, record)) return unreadable();
    FieldReader head(std::span<const std::uint8_t>(record).subspan(4));
    const auto type = static_cast<RecordType>(head.u32());
    const std::uint32_t node = head.u32(), size = head.u32();
    if (size < kOldRecordBytes || size > found.first_frame_position - at) return unreadable();
    record.resize(size);
    if (!input.read(at, record)) return unreadable();
    const auto fields = std::span<const std::uint8_t>(record).subspan(kOldRecordBytes);
    const auto stream = std::find_if(found.streams.begin(), found.streams.end(),
                                     [&](const RecoveredStream& s) { return s.added_position == at; });
    if (stream != found.streams.end()) {
      FieldReader words(fields);
      const std::string_view stream_name = words.text();
      const auto node_type = static_cast<NodeType>(words.u32());
      DefinitionPlace& place = places[static_cast<std::size_t>(stream - found.streams.begin())];
      place.added_position = out.size();
      append_node_added(out, node, stream_name, node_type, words.u32());
      place.counts_position = out.size() - kNodeCountsBytes;
    } else if (type == RecordType::kDataBegin) {
      append_record(out, type, node, Bytes(kFrameFieldBytes, 0xFF));
    } else {
      append_record(out, type, node, fields);
    }
  }
  if (auto written = file.append(out); !written) return fail(written.error());
  return places;
}

// Writes the records that come before the first frame.
Result<std::vector<DefinitionPlace>> write_definitions(const file::InputFile& input,
                                                       const RecoveredRecording& found,
                                                       file::OutputFile& file, const std::string& name) {
  if (found.is_old) return modernise_definitions(input, found, file, name);
  if (auto copied = copy_bytes(input, 0, found.first_frame_position, file, name, [](double) {}); !copied) {
    return fail(copied.error());
  }
  std::vector<DefinitionPlace> places;
  for (const RecoveredStream& stream : found.streams)
    places.push_back({stream.added_position, stream.counts_position});
  return places;
}

Result<void> write_part(const file::InputFile& input, const RecoveredRecording& found,
                        const std::vector<Wanted>& wanted, file::OutputFile& file, const std::string& name,
                        const ProgressReport& progress) {
  const auto definitions = write_definitions(input, found, file, name);
  if (!definitions) return fail(definitions.error());
  std::vector<std::vector<FramePlace>> places(found.streams.size());
  Bytes record;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const RecoveredFrame& frame = *wanted[i].frame;
    auto& before = places[wanted[i].stream];
    record.clear();
    append_frame_head(record, found.streams[wanted[i].stream].node, frame.timestamp_us,
                      static_cast<std::uint32_t>(before.size() + 1), frame.payload_bytes,
                      before.empty() ? 0 : before.back().position);
    const std::size_t head = record.size();
    record.resize(head + frame.payload_bytes);
    if (!input.read(frame.position + frame.fields_bytes, std::span(record).subspan(head))) {
      return fail(ErrorCode::kUnavailable, fmt::format("{}: cannot be read; check the disk", name));
    }
    before.push_back({frame.timestamp_us, file.size()});
    if (auto written = file.append(record); !written) return written;
    progress(static_cast<double>(i + 1) / static_cast<double>(wanted.size()));
  }
  std::vector<FooterStream> ended;
  for (std::size_t i = 0; i < found.streams.size(); ++i) {
    const DefinitionPlace& place = (*definitions)[i];
    ended.push_back({found.streams[i].node, place.added_position, place.counts_position, places[i]});
  }
  if (auto done = write_footer(file, ended, SeekTables::kYes, {}); !done) return fail(done.error());
  return file.close();
}

// Writes every frame of a recording of OpenNI 1.0 to 1.3 in the current format.
Result<void> rewrite(const file::InputFile& input, const RecoveredRecording& found, file::OutputFile& file,
                     const std::string& name, const ProgressReport& progress) {
  std::vector<Wanted> all;
  for (std::size_t i = 0; i < found.streams.size(); ++i) {
    for (const RecoveredFrame& frame : found.streams[i].frames) all.push_back({&frame, i});
  }
  std::sort(all.begin(), all.end(),
            [](const Wanted& a, const Wanted& b) { return a.frame->position < b.frame->position; });
  return write_part(input, found, all, file, name, progress);
}

}  // namespace

Result<RepairReport> repair(const std::string& path, const std::string& out, file::Existing existing,
                            const ProgressReport& progress) {
  const auto input = file::InputFile::open(path, "an .oni recording");
  if (!input) return fail(input.error());
  RecordBytes bytes(*input);
  const auto found = recover(bytes, path);
  if (!found) return fail(found.error());
  RepairReport report;
  report.depth_frames = found->frames(NodeType::kDepth);
  report.color_frames = found->frames(NodeType::kImage);
  report.infrared_frames = found->frames(NodeType::kInfrared);
  report.gaps = found->gaps.size();
  report.dropped_bytes = found->has_end ? 0 : input->size() - found->whole_until;
  // Players do not need the seek tables, which a full disk may have prevented.
  report.was_whole = found->has_end && (found->has_seek_tables || found->is_old) && found->gaps.empty() &&
                     check(path).has_value();
  if (report.was_whole && out.empty()) return report;
  if (out.empty() && !found->gaps.empty()) {
    return fail(
        ErrorCode::kCorrupt,
        fmt::format("{}: damaged at byte {}, not only cut off; give --out FILE to write what is whole "
                    "into another file",
                    path, found->gaps.front().from));
  }
  if (out.empty() && found->is_old) {
    return fail(
        ErrorCode::kCorrupt,
        fmt::format(
            "{}: written by OpenNI 1.0 to 1.3, whose files are not finished in place; give --out FILE to "
            "write what is whole into another file",
            path));
  }
  if (out.empty()) {
    auto file = file::OutputFile::open(path);
    if (!file) return fail(file.error());
    if (auto finished = finish(*file, *found, path); !finished) return fail(finished.error());
    if (const auto plays = check_written(path); !plays) return fail(plays.error());
  } else {
    if (auto differ = refuse_same(path, out); !differ) return fail(differ.error());
    auto copy = file::OutputFile::create(out, existing);
    if (!copy) return fail(copy.error());
    Result<void> done;
    if (found->is_old && !report.was_whole) {
      done = rewrite(*input, *found, *copy, path, progress);
    } else {
      const std::uint64_t end = report.was_whole ? input->size() : found->whole_until;
      done = copy_bytes(*input, 0, end, *copy, path, progress);
      if (done) done = report.was_whole ? copy->close() : finish(*copy, *found, path);
    }
    if (done) done = check_written(out);
    if (!done) {
      copy->discard();
      return fail(done.error());
    }
  }
  return report;
}

Result<CutReport> cut(const std::string& path, double from_s, double to_s, const std::string& out,
                      file::Existing existing, const ProgressReport& progress) {
  const auto whole = check(path);
  if (!whole) return fail(whole.error());
  if (auto differ = refuse_same(path, out); !differ) return fail(differ.error());
  const auto input = file::InputFile::open(path, "an .oni recording");
  if (!input) return fail(input.error());
  RecordBytes bytes(*input);
  const auto found = recover(bytes, path);
  if (!found) return fail(found.error());

  std::vector<Wanted> wanted;
  std::uint64_t first_us = ~std::uint64_t{0};
  for (const RecoveredStream& stream : found->streams) {
    for (const RecoveredFrame& frame : stream.frames) first_us = std::min(first_us, frame.timestamp_us);
  }
  for (std::size_t i = 0; i < found->streams.size(); ++i) {
    for (const RecoveredFrame& frame : found->streams[i].frames) {
      const double at_s = static_cast<double>(frame.timestamp_us - first_us) * 1e-6;
      if (at_s >= from_s && at_s < to_s) wanted.push_back({&frame, i});
    }
  }
  std::sort(wanted.begin(), wanted.end(),
            [](const Wanted& a, const Wanted& b) { return a.frame->position < b.frame->position; });

  const auto& times = whole->find(RecordedStream::Kind::kDepth)->timestamps_us;
  const bool has_depth = std::any_of(times.begin(), times.end(), [&](std::uint64_t time) {
    const double at_s = static_cast<double>(time - first_us) * 1e-6;
    return at_s >= from_s && at_s < to_s;
  });
  if (!has_depth) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: no depth frame lies from {} to {} s; the recording is {:.1f} s long", path,
                            from_s, to_s, static_cast<double>(whole->duration.count()) * 1e-6));
  }

  auto file = file::OutputFile::create(out, existing);
  if (!file) return fail(file.error());
  auto done = write_part(*input, *found, wanted, *file, path, progress);
  if (done) done = check_written(out);
  if (!done) {
    file->discard();
    return fail(done.error());
  }
  CutReport report;
  for (const Wanted& frame : wanted) {
    const NodeType type = found->streams[frame.stream].type;
    report.depth_frames += type == NodeType::kDepth;
    report.color_frames += type == NodeType::kImage;
  }
  report.whole_s = static_cast<double>(whole->duration.count()) * 1e-6;
  return report;
}

}  // namespace copresence::recording
