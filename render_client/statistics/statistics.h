#pragma once

// Counts and measures frames and views, and writes the JSON of --stats. For each camera, it counts
// the frames that were received, lost and displayed, and measures their latency. For the views, it
// measures rate and rendering time. Thread: several threads may use a CameraStatistics at the same
// time; only one thread may use a ViewStatistics.

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
#include "render_client/renderer/renderer.h"
#include "render_client/viewpoint/opentrack_view.h"

namespace copresence::statistics {

/// The stages that a frame passes, in order. kStageNames are their names in the JSON.
enum class Stage { kCapture, kFill, kDepthEncode, kVideoEncode, kWire, kVideoDecode, kDepthDecode };
inline constexpr std::array<const char*, 7> kStageNames{
    "capture", "fill", "depth_encode", "video_encode", "wire", "video_decode", "depth_decode"};

class CameraStatistics {
 public:
  /// Call it when a connection begins. The server's totals are compared within one connection only:
  /// frames that were captured before or between connections are not counted.
  void connected();
  /// Call it for every frame received. `totals` are the server's running totals that came with the
  /// frame. Impossible totals, which fall or grow faster than any camera delivers, are not added.
  void received(const wire::FrameCounters& totals, std::size_t bytes, Instant now);
  void decoded();
  void not_decoded();     ///< The frame was damaged, or a frame that it depends on is missing.
  void color_repeated();  ///< The frame had no colour, so an earlier frame's colour is displayed.
  void not_displayed();   ///< A newer frame replaced the frame before any view showed it.
  /// Call it when a view shows the frame, without `latency` if the frame's times are implausible.
  void displayed(std::uint64_t sequence, std::optional<Duration> latency);
  /// Adds the durations of the server's stages and of the transport. Implausible stages are
  /// ignored. Without `wire`, the frame is counted as one with implausible times.
  void timed(std::optional<Duration> wire, const StageDurations& durations);
  void stage(Stage stage, Duration duration);
  void clock(Duration offset, Duration uncertainty);
  void stale();  ///< The camera begins to fade, because it has sent no frame for a while.

  struct Snapshot {
    std::uint64_t connections = 0;
    /// The server's totals since the first frame of each connection, summed over all connections.
    /// `captured` includes that first frame.
    wire::FrameCounters totals;
    std::uint64_t received = 0, decoded = 0, displayed = 0, not_displayed = 0, last_displayed_sequence = 0;
    std::uint64_t color_repeated = 0, times_stale = 0;
    std::uint64_t times_not_believed = 0;  ///< Decoded frames with implausible times.
    /// Numbers by cause, including causes that have not occurred.
    std::map<std::string, std::uint64_t> drops;
    std::uint64_t dropped = 0;
    std::uint64_t bytes = 0;  ///< Of all received frames but the first.
    double mbps = 0;
    flow::LatencyHistogram latency;
    std::array<flow::LatencyHistogram, kStageNames.size()> stages;
    Duration clock_offset{}, clock_uncertainty{};
  };
  Snapshot snapshot() const;

 private:
  mutable std::mutex mutex_;
  std::optional<wire::FrameCounters> last_;  // The last totals of this connection.
  Instant last_at_{};                        // Arrival time of `last_`.
  std::uint64_t not_decoded_ = 0;
  std::optional<Instant> first_, newest_;
  Snapshot sums_;
};

/// What a camera did between two of its snapshots.
struct CameraInterval {
  double frames_per_second = 0;
  double mbps = 0;
  double latency_ms = 0;                               ///< Median; 0 if no view showed a frame.
  std::array<double, kStageNames.size()> stages_ms{};  ///< Medians.
};
/// Requires `elapsed` > 0, the time from `before` to `after`.
CameraInterval interval(const CameraStatistics::Snapshot& before, const CameraStatistics::Snapshot& after,
                        Duration elapsed);

class ViewStatistics {
 public:
  /// Call it when a view was drawn. A `complete` view shows every listed camera. Views are counted
  /// from the first complete view on.
  void rendered(Instant begin, Instant end, bool complete);

  /// Adds the time between the earliest and the latest frame in a view of two cameras or more.
  void skew(Duration skew) { skew_.add(skew); }

  void origins(const renderer::OriginShares& shares);

  /// Sets the datagram counters. Call it only if there is a head tracker.
  void head_tracker(const viewpoint::OpentrackView::Counters& counters) { head_tracker_ = counters; }
  const std::optional<viewpoint::OpentrackView::Counters>& head_tracker() const { return head_tracker_; }

  std::uint64_t frames() const { return frames_; }
  const flow::LatencyHistogram& skew() const { return skew_; }
  double fps() const;                                          ///< Is 0 for fewer than two views.
  std::optional<renderer::OriginShares> mean_origins() const;  ///< Nothing if no view had origins.
  const flow::LatencyHistogram& render_time() const { return render_time_; }

 private:
  std::uint64_t frames_ = 0;
  Instant first_{}, last_{};
  flow::LatencyHistogram render_time_, skew_;
  double seen_ = 0, remembered_ = 0, extended_ = 0, empty_ = 0;
  std::uint64_t views_with_origins_ = 0;
  std::optional<viewpoint::OpentrackView::Counters> head_tracker_;
};

struct CameraReport {
  std::string name;      ///< The camera's name, or its address as long as the name is unknown.
  std::string left_out;  ///< The reason why no view shows the camera, or empty.
  CameraStatistics::Snapshot statistics;
};

/// Writes the JSON of --stats. Fails with a message that names the file.
Result<void> write_statistics(const std::string& path, const std::vector<CameraReport>& cameras,
                              const ViewStatistics& view, const std::string& renderer, int width, int height);

}  // namespace copresence::statistics
