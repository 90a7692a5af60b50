#pragma once

// What --stats writes: per camera what arrived, what was lost and why, how old it was when shown; per view
// how often and how fast.
//
// Thread: CameraStatistics may be used by its receiver and the renderer at once; ViewStatistics by the
// renderer only.

#include <array>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "common/flow/latency_histogram.h"
#include "common/frame/rgbd_frame.h"
#include "common/result.h"
#include "common/wire/message.h"
#include "render_client/viewpoint/opentrack_view.h"

namespace copresence::client {

/// The stages of one frame in frame order, as they are named in the JSON.
enum class Stage { kCapture, kFill, kDepthEncode, kVideoEncode, kWire, kVideoDecode, kDepthDecode };
inline constexpr std::array<const char*, 7> kStageNames{
    "capture", "fill", "depth_encode", "video_encode", "wire", "video_decode", "depth_decode"};

class CameraStatistics {
 public:
  /// A connection to the camera's server begins. What the server captured before its first frame here, or
  /// between two connections, is not ours to count: its totals are compared within one connection only.
  void connected();
  /// `totals`: the server's running totals as they came with this frame. A server that makes totals up (they
  /// fall, or grow faster than any camera delivers) begins anew with each of them.
  void received(const wire::FrameCounters& totals, std::size_t bytes, Instant now);
  void decoded();
  void not_decoded();     ///< received, but damaged or dependent on something that is missing
  void color_repeated();  ///< decoded without colour, and shown with an earlier frame's
  void unshown();         ///< decoded, but replaced before any view
  /// In a view. `latency`: nothing where the frame's times are not believed.
  void shown(std::uint64_t sequence, std::optional<Duration> latency);
  /// How long the server's stages and the wire took. Stages beyond any belief are left out; no `wire` means
  /// that the frame's times are not believed, which is counted.
  void timed(std::optional<Duration> wire, const StageDurations& durations);
  void stage(Stage stage, Duration duration);
  void clock(Duration offset, Duration uncertainty);
  void stale();  ///< no frame has come for so long that the camera fades from the view

  struct Snapshot {
    std::uint64_t connections = 0;
    wire::FrameCounters
        totals;  ///< growth since the first frame of each connection; `captured` counts that one, too
    std::uint64_t received = 0, decoded = 0, shown = 0, unshown = 0, last_shown_sequence = 0;
    std::uint64_t color_repeated = 0, times_stale = 0;
    std::uint64_t times_not_believed = 0;        ///< decoded frames
    std::map<std::string, std::uint64_t> drops;  ///< by cause; every cause is there, also with 0
    std::uint64_t dropped = 0;
    double mbps = 0;
    flow::LatencyHistogram latency;
    std::array<flow::LatencyHistogram, kStageNames.size()> stages;
    Duration clock_offset{}, clock_uncertainty{};
  };
  Snapshot snapshot() const;

 private:
  mutable std::mutex mutex_;
  std::optional<wire::FrameCounters> last_;  // of this connection
  Instant last_at_{};                        // when they came
  std::uint64_t not_decoded_ = 0, bytes_ = 0;
  std::optional<Instant> first_, newest_;
  Snapshot sums_;
};

class ViewStatistics {
 public:
  /// `complete`: the view shows every listed camera. Views are counted from the first complete one.
  void rendered(Instant begin, Instant end, bool complete);

  /// Between the earliest and the latest instant that a view shows; of two cameras or more.
  void skew(Duration skew) { skew_.add(skew); }

  /// What came from the head tracker; not called where there is none.
  void head_tracker(const viewpoint::OpentrackView::Counters& counters) { head_tracker_ = counters; }
  const std::optional<viewpoint::OpentrackView::Counters>& head_tracker() const { return head_tracker_; }

  std::uint64_t frames() const { return frames_; }
  const flow::LatencyHistogram& skew() const { return skew_; }
  double fps() const;  ///< 0 below two views
  const flow::LatencyHistogram& render_time() const { return render_time_; }

 private:
  std::uint64_t frames_ = 0;
  Instant first_{}, last_{};
  flow::LatencyHistogram render_time_, skew_;
  std::optional<viewpoint::OpentrackView::Counters> head_tracker_;
};

/// One camera as the JSON tells of it.
struct CameraReport {
  std::string name;      ///< or its address where no server has told a name
  std::string left_out;  ///< why no view shows it; empty where views do
  CameraStatistics::Snapshot statistics;
};

/// Writes the JSON of --stats. Fails with a sentence that names the file.
Result<void> write_statistics(const std::string& path, const std::vector<CameraReport>& cameras,
                              const ViewStatistics& view, const std::string& renderer, int width, int height);

}  // namespace copresence::client
