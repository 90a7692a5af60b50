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

#include "common/flow/stage_timing.h"
#include "common/frame/rgbd_frame.h"
#include "common/result.h"
#include "render_client/viewpoint/opentrack_view.h"

namespace copresence::client {

/// The stages of one frame in frame order, as they are named in the JSON.
enum class Stage { kCapture, kFill, kDepthEncode, kVideoEncode, kWire, kVideoDecode, kDepthDecode };
inline constexpr std::array<const char*, 7> kStageNames{
    "capture", "fill", "depth_encode", "video_encode", "wire", "video_decode", "depth_decode"};

/// Pictures of a sensor that found no partner of their instant, came damaged, or fell into another
/// projector's turn.
struct Pictures {
  std::uint64_t depth_without_color = 0;  ///< frames whose colour is an older picture, or none
  std::uint64_t color_without_depth = 0;  ///< colour pictures that no frame carried
  std::uint64_t damaged = 0;              ///< pictures that did not decode or went missing
  std::uint64_t dark = 0;                 ///< depth pictures that its projector was not to light, left out
};

class CameraStatistics {
 public:
  /// Everything is counted from the first received() on. `captured`, `encoder_busy`, `window_full`: the
  /// server's running totals as they came with this frame; a total that falls means that the server started
  /// anew.
  void received(std::uint64_t captured, std::uint64_t encoder_busy, std::uint64_t window_full,
                std::size_t bytes, Instant now);
  /// What became of the sensor's pictures, the server's running totals; counted like these.
  void sensor(const Pictures& totals);
  void decoded();
  void stale();           ///< no frame has come for so long that the camera fades from the view
  void color_repeated();  ///< decoded without colour, and shown with an earlier frame's
  void not_decoded();  ///< received, but damaged or dependent on something that is missing
  void unshown();      ///< decoded, but replaced before any view
  void shown(std::uint64_t sequence, Duration latency);
  void stage(Stage stage, Duration duration);
  void clock(Duration offset, Duration uncertainty);

  struct Snapshot {
    Pictures pictures;
    std::uint64_t color_repeated = 0, times_stale = 0;
    std::uint64_t captured = 0, received = 0, decoded = 0, unshown = 0, last_shown_sequence = 0;
    std::map<std::string, std::uint64_t> drops;  ///< by cause; every cause is there, also with 0
    std::uint64_t dropped = 0;
    double mbps = 0;
    flow::StageTiming latency;
    std::array<flow::StageTiming, kStageNames.size()> stages;
    Duration clock_offset{}, clock_uncertainty{};
  };
  Snapshot snapshot() const;

 private:
  struct Totals {
    std::uint64_t captured, encoder_busy, window_full;
  };

  mutable std::mutex mutex_;
  std::optional<Totals> last_;
  std::optional<Pictures> last_pictures_;
  std::uint64_t encoder_busy_ = 0, window_full_ = 0, not_decoded_ = 0, bytes_ = 0;
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
  const flow::StageTiming& skew() const { return skew_; }
  double fps() const;  ///< 0 below two views
  const flow::StageTiming& render_time() const { return render_time_; }

 private:
  std::uint64_t frames_ = 0;
  Instant first_{}, last_{};
  flow::StageTiming render_time_, skew_;
  std::optional<viewpoint::OpentrackView::Counters> head_tracker_;
};

/// Writes design section 7's JSON. Fails with a sentence that names the file.
Result<void> write_statistics(const std::string& path, const std::vector<std::string>& cameras,
                              const std::vector<CameraStatistics::Snapshot>& snapshots,
                              const ViewStatistics& view, const std::string& renderer, int width, int height);

}  // namespace copresence::client
