#include "render_client/pipeline.h"

#include <fmt/format.h>
#include <pthread.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <thread>
#include <utility>

#include "common/flow/latest_of_each.h"
#include "common/flow/thread_priority.h"
#include "common/flow/worker_pool.h"
#include "common/scene/scene.h"
#include "render_client/camera_receiver.h"
#include "render_client/eye.h"
#include "render_client/frame_sync.h"
#include "render_client/live_color_matching.h"
#include "render_client/pacing/render_pacer.h"
#include "render_client/screenshot.h"
#include "render_client/statistics.h"
#include "render_client/view_output.h"

namespace copresence::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

Result<std::vector<std::string>> addresses(const ClientSettings& settings, const scene::Scene* scene) {
  if (!settings.servers.empty()) return settings.servers;
  std::vector<std::string> out;
  for (const scene::Camera& camera : scene->cameras) {
    if (!camera.address.empty()) out.push_back(camera.address);
  }
  if (out.empty()) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: no camera has an \"address\" to connect to", settings.scene));
  }
  return out;
}

/// Matching colours is in no hurry.
constexpr int kStepsBehindTheView = 10;
/// A camera whose newest frame is so old has stopped: it says nothing about skew.
constexpr milliseconds kStopped{500};
constexpr milliseconds kSaySkewEvery{10'000};

/// The render thread's side of one camera: its newest frame and what is known of it.
struct Shown {
  std::shared_ptr<const Received> newest;
  std::uint64_t version = 0;  ///< of `newest`, which no other camera's has; 0 while there is none
  bool is_fresh = false;      ///< not yet in any view
  bool said_no_pose = false;
};

/// Whether anybody has said where the camera stands: its server or the scene file.
bool has_place(const Shown& shown, const scene::Scene* scene) {
  const StreamDescription& stream = *shown.newest->stream;
  const scene::Camera* known = scene ? scene->find(stream.camera) : nullptr;
  return stream.has_pose || (known && known->world_from_camera);
}

renderer::CameraView camera_view(const Shown& shown, const scene::Scene* scene,
                                 const color_matching::ColorMap& found_matching) {
  const StreamDescription& stream = *shown.newest->stream;
  renderer::CameraView view;
  view.frame = &shown.newest->frame;
  view.version = shown.version;
  view.model = stream.model;
  view.unit = stream.unit;
  view.world_from_camera = shown.newest->frame.stamp.world_from_camera;
  view.color_matching = found_matching;
  if (const scene::Camera* known = scene ? scene->find(stream.camera) : nullptr) {
    if (known->model.width == stream.model.width && known->model.height == stream.model.height) {
      view.model = known->model;
    }
    if (known->world_from_camera) view.world_from_camera = *known->world_from_camera;
    if (known->color_matching) view.color_matching = *known->color_matching;
    if (known->calibration_error_mm) view.calibration_error_m = *known->calibration_error_mm * 1e-3;
  }
  return view;
}

class Pipeline {
 public:
  Pipeline(const ClientSettings& settings, const scene::Scene* scene, std::vector<std::string> servers,
           ViewOutput output, Eye eye, std::stop_source stop)
      : settings_(settings),
        scene_(scene),
        servers_(std::move(servers)),
        output_(std::move(output)),
        eye_(std::move(eye)),
        stop_(std::move(stop)),
        board_(servers_.size()),
        colors_(servers_.size()),
        frames_(servers_.size(), settings_.sync),
        statistics_(servers_.size()),
        shown_(servers_.size()) {}

  Result<void> run() {
    std::vector<std::jthread> receivers;
    for (std::size_t i = 0; i < servers_.size(); ++i) {
      receivers.emplace_back([this, i] { receive(i); });
    }
    std::jthread matcher;
    if (settings_.match_colors && servers_.size() > 1) {
      matcher = std::jthread([this](const std::stop_token& stop) {
        pthread_setname_np(pthread_self(), "colors");
        flow::give_way(kStepsBehindTheView);
        colors_.run(stop);
      });
    }
    Result<void> rendered = output_.window() ? render_in_window() : render_headless();
    Result<void> written = write_results();
    stop_.request_stop();
    receivers.clear();
    if (refusal_) return fail(*refusal_);
    return rendered ? written : rendered;
  }

 private:
  void receive(std::size_t slot) {
    pthread_setname_np(pthread_self(), fmt::format("camera {}", slot).c_str());
    CameraReceiver receiver(servers_[slot], slot, scene_, board_, statistics_[slot]);
    if (auto ended = receiver.run(stop_.get_token()); !ended) {
      std::lock_guard lock(refusal_mutex_);
      refusal_ = ended.error();
      stop_.request_stop();
    }
  }

  /// Views on arrival of frames, at most settings.fps a second.
  Result<void> render_headless() {
    pacing::RenderPacer pacer(static_cast<int>(servers_.size()), settings_.fps);
    while (!finished()) {
      const Instant now = steady_clock::now();
      const std::optional<Instant> due = pacer.next_render_at(now);
      if (!due || *due > now) {
        // What waits for the other cameras' frames is got ready in the meantime.
        if (due && !std::exchange(is_prepared_, true)) {
          output_.prepare(camera_views());
          continue;
        }
        board_.wait(stop_.get_token(), frames_.wake_by(due.value_or(now + milliseconds(100))));
        for (std::size_t i : take_frames())
          pacer.frame_arrived(static_cast<int>(i), shown_[i].newest->arrived_at);
        continue;
      }
      pacer.rendered(now);
      if (auto rendered = render(now, eye_.at(view_index_, now)); !rendered) return rendered;
    }
    return {};
  }

  /// A view at every refresh of the display; rendered anew where a frame arrived or the eye moved.
  Result<void> render_in_window() {
    gl::Window& window = *output_.window();
    const auto refresh =
        std::chrono::duration_cast<Duration>(std::chrono::duration<double>(1 / window.refresh_rate_hz()));
    while (!finished() && !window.should_close()) {
      const auto events = window.poll();
      eye_.handle(events, window.height());
      obey_keys(events);
      const Instant now = steady_clock::now();
      const bool has_fresh = !take_frames().empty();
      const auto eye = eye_.at(view_index_, now);
      if (has_fresh || !last_eye_ || !(eye.world_from_eye == last_eye_->world_from_eye)) {
        if (auto rendered = render(now, eye); !rendered) return rendered;
      } else {
        output_.present_again();
      }
      // Showing a view waits for the display; where there is nothing to wait for (a display without refresh),
      // this does.
      std::this_thread::sleep_until(now + refresh * 9 / 10);
    }
    return {};
  }

  /// Escape ends, F11 fills the screen.
  void obey_keys(const std::vector<gl::Event>& events) {
    gl::Window& window = *output_.window();
    for (const gl::Event& event : events) {
      const auto* key = std::get_if<gl::KeyEvent>(&event);
      if (!key || !key->pressed || key->repeated) continue;
      if (key->key == gl::Key::kEscape) window.request_close();
      if (key->key == gl::Key::kF11) window.set_fullscreen(!window.is_fullscreen());
    }
  }

  bool finished() const {
    return stop_.stop_requested() || (settings_.frames && view_statistics_.frames() >= *settings_.frames);
  }

  /// Takes what has arrived; returns the cameras that have a new frame.
  std::vector<std::size_t> take_frames() {
    frames_.gather(board_, statistics_, steady_clock::now());
    std::vector<std::size_t> arrived;
    for (std::size_t i = 0; i < shown_.size(); ++i) {
      auto received = frames_.take(i);
      if (!received) continue;
      Shown& shown = shown_[i];
      if (shown.is_fresh) statistics_[i].unshown();
      shown.newest = std::make_shared<const Received>(std::move(*received));
      if (!shown.said_no_pose && !has_place(shown, scene_)) {
        spdlog::info("{}: camera \"{}\" has no pose; it stands at the world's origin", servers_[i],
                     shown.newest->stream->camera);
        shown.said_no_pose = true;
      }
      shown.is_fresh = true;
      shown.version = ++frames_taken_;
      const renderer::CameraView view = camera_view(shown, scene_, color_matching::ColorMap::Identity());
      is_prepared_ = false;
      eye_.see_camera(i, view.world_from_camera);
      if (settings_.match_colors && has_place(shown, scene_)) {
        colors_.show(i, shown.newest,
                     {view.frame, view.model, view.unit, view.world_from_camera, view.calibration_error_m});
      }
      arrived.push_back(i);
    }
    return arrived;
  }

  std::vector<renderer::CameraView> camera_views() const {
    std::vector<renderer::CameraView> views;
    for (std::size_t i = 0; i < shown_.size(); ++i) {
      if (shown_[i].newest) views.push_back(camera_view(shown_[i], scene_, colors_.map(i)));
    }
    return views;
  }

  Result<void> render(Instant begin, const renderer::VirtualCamera& eye) {
    const auto views = camera_views();
    if (auto rendered = output_.render(views, eye); !rendered) return rendered;
    last_eye_ = eye;
    const Instant end = steady_clock::now();
    const bool complete = views.size() == shown_.size();
    view_statistics_.rendered(begin, end, complete);
    note_skew(end);
    if (complete) ++view_index_;
    for (std::size_t i = 0; i < shown_.size(); ++i) {
      Shown& shown = shown_[i];
      if (!shown.is_fresh) continue;
      shown.is_fresh = false;
      statistics_[i].shown(shown.newest->frame.stamp.sequence, end - shown.newest->captured_at);
    }
    return {};
  }

  /// How far apart the instants are that the view shows; of cameras that deliver.
  void note_skew(Instant now) {
    std::optional<Instant> earliest, latest;
    int cameras = 0;
    for (const Shown& shown : shown_) {
      if (!shown.newest || now - shown.newest->captured_at > kStopped) continue;
      ++cameras;
      earliest = std::min(earliest.value_or(shown.newest->captured_at), shown.newest->captured_at);
      latest = std::max(latest.value_or(shown.newest->captured_at), shown.newest->captured_at);
    }
    if (cameras < 2) return;
    view_statistics_.skew(*latest - *earliest);
    if (now < say_skew_at_) return;
    if (say_skew_at_ != Instant{}) {
      const auto& skew = view_statistics_.skew();
      spdlog::info("the cameras' pictures in a view are {:.1f} ms apart (p95 {:.1f} ms){}",
                   skew.percentile_ms(50), skew.percentile_ms(95), settings_.sync ? ", synchronised" : "");
    }
    say_skew_at_ = now + kSaySkewEvery;
  }

  Result<void> write_results() {
    if (!settings_.screenshot.empty()) {
      auto picture = output_.picture(camera_views(), last_eye_.value_or(eye_.at(0, steady_clock::now())));
      if (!picture) return fail(picture.error());
      if (auto written = write_png(settings_.screenshot, *picture); !written) return written;
    }
    if (settings_.stats.empty()) return {};
    std::vector<std::string> names;
    std::vector<CameraStatistics::Snapshot> snapshots;
    for (std::size_t i = 0; i < servers_.size(); ++i) {
      names.push_back(shown_[i].newest ? shown_[i].newest->stream->camera : servers_[i]);
      snapshots.push_back(statistics_[i].snapshot());
    }
    return write_statistics(settings_.stats, names, snapshots, view_statistics_,
                            std::string(output_.renderer_name()), settings_.width, settings_.height);
  }

  const ClientSettings& settings_;
  const scene::Scene* scene_;
  std::vector<std::string> servers_;
  ViewOutput output_;
  Eye eye_;
  std::stop_source stop_;
  flow::LatestOfEach<Received> board_;
  LiveColorMatching colors_;
  FrameSync frames_;
  std::deque<CameraStatistics> statistics_;  // a deque, since they cannot move
  std::vector<Shown> shown_;
  std::uint64_t frames_taken_ = 0;
  bool is_prepared_ = false;  ///< the renderer has been given what is in `shown_`
  ViewStatistics view_statistics_;
  std::uint64_t view_index_ = 0;
  std::optional<renderer::VirtualCamera> last_eye_;  ///< of the last view
  Instant say_skew_at_{};
  std::mutex refusal_mutex_;
  std::optional<Error> refusal_;
};

}  // namespace

Result<void> run_pipeline(const ClientSettings& settings, std::stop_source stop) {
  std::optional<scene::Scene> scene;
  if (!settings.scene.empty()) {
    auto loaded = scene::load(settings.scene);
    if (!loaded) return fail(loaded.error());
    scene = std::move(*loaded);
  }
  const scene::Scene* known = scene ? &*scene : nullptr;
  auto servers = addresses(settings, known);
  if (!servers) return fail(servers.error());
  auto eye = Eye::open(settings, known);
  if (!eye) return fail(eye.error());
  flow::WorkerPool workers(static_cast<int>(std::max(1u, std::thread::hardware_concurrency())), "render");
  auto output = ViewOutput::open(settings, workers);
  if (!output) return fail(output.error());
  return Pipeline(settings, known, std::move(*servers), std::move(*output), std::move(*eye), std::move(stop))
      .run();
}

}  // namespace copresence::client
