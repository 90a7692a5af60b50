#pragma once

// Counts and measures frames and views, and writes them as the JSON of --stats: for each camera the
// frames that came, were lost, and were displayed, and their latency; for the views their rate and
// rendering time.
//
// Thread: CameraStatistics may be used by several threads at once, ViewStatistics by one.

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

/// The stages that a frame passes, in order; kStageNames are their names in the JSON.
enum class Stage { kCapture, kFill, kDepthEncode, kVideoEncode, kWire, kVideoDecode, kDepthDecode };
inline constexpr std::array<const char*, 7> kStageNames{
    "capture", "fill", "depth_encode", "video_encode", "wire", "video_decode", "depth_decode"};

class CameraStatistics {
 public:
  /// A connection to the camera's server begins. The server's totals are compared within one
  /// connection only: frames that it captured before or between connections are not counted.
  void connected();
  /// A frame came. `totals` are the server's running totals that came with it. Impossible totals
  /// (they fall, or grow faster than any camera delivers) are not added; counting goes on from
  /// them.
  void received(const wire::FrameCounters& totals, std::size_t bytes, Instant now);
  void decoded();
  void not_decoded();     ///< received, but damaged, or a frame that it depends on is missing
  void color_repeated();  ///< decoded without colour; an earlier frame's colour is displayed
  void not_displayed();   ///< decoded, but replaced by a newer frame before any view
  /// A view shows the frame. No `latency` if the frame's times are implausible.
  void displayed(std::uint64_t sequence, std::optional<Duration> latency);
  /// Durations of the server's stages and of the transport. Implausible stages are left out. No
  /// `wire` means that the frame's times are implausible; such frames are counted.
  void timed(std::optional<Duration> wire, const StageDurations& durations);
  void stage(Stage stage, Duration duration);
  void clock(Duration offset, Duration uncertainty);
  void stale();  ///< the camera begins to fade, because no frame has come for a while

  struct Snapshot {
    std::uint64_t connections = 0;
    /// Growth since the first frame of each connection, summed. `captured` includes that first
    /// frame.
    wire::FrameCounters totals;
    std::uint64_t received = 0, decoded = 0, displayed = 0, not_displayed = 0, last_displayed_sequence = 0;
    std::uint64_t color_repeated = 0, times_stale = 0;
    std::uint64_t times_not_believed = 0;        ///< number of decoded frames
    std::map<std::string, std::uint64_t> drops;  ///< by cause; contains every cause, also with 0
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
  Instant last_at_{};                        // when `last_` came
  std::uint64_t not_decoded_ = 0, bytes_ = 0;
  std::optional<Instant> first_, newest_;
  Snapshot sums_;
};

class ViewStatistics {
 public:
  /// A view was drawn. `complete` if it shows every listed camera. Views are counted from the first
  /// complete one.
  void rendered(Instant begin, Instant end, bool complete);

  /// Time between the earliest and the latest frame in a view of two cameras or more.
  void skew(Duration skew) { skew_.add(skew); }

  /// Where the pixels of a view come from.
  void origins(const renderer::OriginShares& shares);

  /// Datagrams of the head tracker; call it only if there is one.
  void head_tracker(const viewpoint::OpentrackView::Counters& counters) { head_tracker_ = counters; }
  const std::optional<viewpoint::OpentrackView::Counters>& head_tracker() const { return head_tracker_; }

  std::uint64_t frames() const { return frames_; }
  const flow::LatencyHistogram& skew() const { return skew_; }
  double fps() const;                                          ///< 0 for fewer than two views
  std::optional<renderer::OriginShares> mean_origins() const;  ///< nothing if no view had any
  const flow::LatencyHistogram& render_time() const { return render_time_; }

 private:
  std::uint64_t frames_ = 0;
  Instant first_{}, last_{};
  flow::LatencyHistogram render_time_, skew_;
  double seen_ = 0, extended_ = 0, empty_ = 0;  // sums of shares
  std::uint64_t views_with_origins_ = 0;
  std::optional<viewpoint::OpentrackView::Counters> head_tracker_;
};

/// One camera in the JSON.
struct CameraReport {
  std::string name;      ///< its address if no server has sent a name
  std::string left_out;  ///< why no view shows it; empty if views do
  CameraStatistics::Snapshot statistics;
};

/// Writes the JSON of --stats. Fails with a message that names the file.
Result<void> write_statistics(const std::string& path, const std::vector<CameraReport>& cameras,
                              const ViewStatistics& view, const std::string& renderer, int width, int height);

}  // namespace copresence::statistics
