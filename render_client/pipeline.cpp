#include "render_client/pipeline.h"

#include <fmt/format.h>
#include <pthread.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <thread>
#include <utility>

#include "common/flow/mailboxes.h"
#include "common/flow/thread_priority.h"
#include "common/flow/worker_pool.h"
#include "common/scene/scene.h"
#include "common/wire/host_port.h"
#include "render_client/camera_setup.h"
#include "render_client/color_matching/live_color_matching.h"
#include "render_client/display/screenshot.h"
#include "render_client/display/view_output.h"
#include "render_client/pacing/frame_sync.h"
#include "render_client/pacing/render_pacer.h"
#include "render_client/pacing/stale_cameras.h"
#include "render_client/statistics/camera_states.h"
#include "render_client/statistics/statistics.h"
#include "render_client/stream/camera_receiver.h"
#include "render_client/viewpoint/viewer.h"

namespace copresence::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

Result<std::vector<std::string>> addresses(const ClientSettings& settings, const scene::Scene* scene) {
  std::vector<std::string> out = settings.servers;
  if (out.empty()) {
    for (const scene::Camera& camera : scene->cameras) {
      if (!camera.address.empty()) out.push_back(camera.address);
    }
  }
  if (out.empty()) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: no camera has an \"address\" to connect to", settings.scene));
  }
  for (const std::string& address : out) {
    if (const auto understood = wire::parse_host_port(address); !understood) return fail(understood.error());
  }
  if (out.size() > renderer::kMostCameras) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format("{}: {} cameras have an \"address\", and one view shows at most {}; name those to "
                    "show with --connect",
                    settings.scene, out.size(), renderer::kMostCameras));
  }
  return out;
}

constexpr const char* kTitle = "Copresence";
constexpr milliseconds kTitleEvery{250};
/// The longest time that views wait for the first match of colours, once every camera is there.
constexpr milliseconds kLongestColorWait{10'000};

/// Matching colours is in no hurry.
constexpr int kStepsBehindTheView = 10;
/// A camera whose newest frame is so old has stopped: it says nothing about skew.
constexpr milliseconds kStopped{500};
constexpr milliseconds kSaySkewEvery{10'000};

Duration seconds(double value) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(value));
}

/// The render thread's side of one camera: its newest frame and what is known of it.
struct Shown {
  std::shared_ptr<const Received> newest;
  std::uint64_t version = 0;  ///< of `newest`, which no other camera's has; 0 while there is none
  bool is_fresh = false;      ///< not yet in any view
  bool said_no_pose = false;
};

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
        states_(servers_.size(), [this] { stop_.request_stop(); }),
        colors_(servers_.size()),
        frames_(servers_.size(), settings_.sync),
        stale_(servers_.size(), seconds(settings_.stale_s)),
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
        flow::lower_priority(kStepsBehindTheView);
        colors_.run(stop);
      });
    }
    Result<void> rendered = output_.window() ? render_in_window() : render_headless();
    Result<void> written = write_results();
    if (!output_.window()) say_what_was_done();
    stop_.request_stop();
    receivers.clear();
    if (const auto refused = states_.all_refused()) return fail(*refused);
    return rendered ? written : rendered;
  }

 private:
  void receive(std::size_t slot) {
    pthread_setname_np(pthread_self(), fmt::format("camera {}", slot).c_str());
    CameraReceiver(servers_[slot], slot, scene_, board_, statistics_[slot], states_).run(stop_.get_token());
  }

  /// Views on arrival of frames, at most settings.fps a second. Ends, too, once every camera has ended for
  /// good and its last frame is shown.
  Result<void> render_headless() {
    pacing::RenderPacer pacer(static_cast<int>(servers_.size()), settings_.fps);
    while (!finished()) {
      const bool all_over = states_.all_over();  // asked first: what came before the end is taken below
      // A slow view may have kept this thread busy for long: the next one shows what has arrived meanwhile.
      for (std::size_t i : take_frames())
        pacer.frame_arrived(static_cast<int>(i), shown_[i].newest->arrived_at);
      const Instant now = steady_clock::now();
      eye_.log_news(now);
      std::optional<Instant> due = pacer.next_render_at(now);
      if (all_over && !due && !frames_.has_waiting()) return {};
      if (!due) due = next_fading_view();
      if (!due || *due > now) {
        // What waits for the other cameras' frames is got ready in the meantime.
        if (due && !std::exchange(is_prepared_, true)) {
          output_.prepare(camera_views(now));
          continue;
        }
        board_.wait(stop_.get_token(), frames_.wake_by(due.value_or(now + milliseconds(100))));
        continue;
      }
      pacer.rendered(now);
      if (auto rendered = render(now, eye_.at(view_index_, now)); !rendered) return rendered;
    }
    return {};
  }

  /// A view at every refresh of the display; rendered anew where a frame arrived or the eye moved.
  Result<void> render_in_window() {
    window::Window& window = *output_.window();
    const auto refresh =
        std::chrono::duration_cast<Duration>(std::chrono::duration<double>(1 / window.refresh_rate_hz()));
    while (!finished() && !window.should_close()) {
      const auto events = window.poll();
      eye_.handle(events, window.height());
      obey_keys(events);
      show_title();
      const Instant now = steady_clock::now();
      eye_.log_news(now);
      const bool has_fresh = !take_frames().empty();
      const auto eye = eye_.at(view_index_, now);
      const bool fades = next_fading_view().value_or(Instant::max()) <= now;
      if (has_fresh || fades || must_draw_ || !last_eye_ ||
          !(eye.world_from_eye == last_eye_->world_from_eye)) {
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

  /// The title says what is awaited.
  void show_title() {
    const Instant now = steady_clock::now();
    if (now < title_due_at_) return;
    title_due_at_ = now + kTitleEvery;
    std::string title = states_.title(kTitle);
    if (title == title_) return;
    title_ = std::move(title);
    output_.window()->set_title(title_);
  }

  /// Escape ends, F11 fills the screen.
  void obey_keys(const std::vector<window::Event>& events) {
    window::Window& window = *output_.window();
    for (const window::Event& event : events) {
      const auto* key = std::get_if<window::KeyEvent>(&event);
      if (!key || !key->pressed || key->repeated) continue;
      if (key->key == window::Key::kEscape) window.request_close();
      if (key->key == window::Key::kF11) window.set_fullscreen(!window.is_fullscreen());
    }
  }

  bool finished() const {
    return stop_.stop_requested() || (settings_.frames && view_statistics_.frames() >= *settings_.frames);
  }

  /// When a view is due although no frame has come, because a camera fades.
  std::optional<Instant> next_fading_view() const {
    return last_view_at_ ? stale_.next_view(*last_view_at_) : std::nullopt;
  }

  /// Takes what has arrived; returns the cameras that have a new frame.
  std::vector<std::size_t> take_frames() {
    const Instant now = steady_clock::now();
    frames_.gather(board_, statistics_, now);
    std::vector<std::size_t> arrived;
    for (std::size_t i = 0; i < shown_.size(); ++i) {
      auto received = frames_.take(i);
      Shown& shown = shown_[i];
      if (!states_.left_out(i).empty()) {
        if (received) statistics_[i].unshown();
        leave_out(i);
        continue;
      }
      if (!received) continue;
      if (shown.is_fresh) statistics_[i].unshown();
      shown.newest = std::make_shared<const Received>(std::move(*received));
      const CameraSetup& setup = *shown.newest->setup;
      if (!shown.said_no_pose && !setup.has_pose) {
        spdlog::info("{}: camera \"{}\" has no pose; it stands at the world's origin", servers_[i],
                     shown.newest->stream->camera);
        shown.said_no_pose = true;
      }
      shown.is_fresh = true;
      shown.version = ++frames_taken_;
      is_prepared_ = false;
      stale_.frame_arrived(i, seconds(1 / shown.newest->stream->frames_per_second), shown.newest->arrived_at);
      eye_.see_camera(i, setup.pose(shown.newest->frame.metadata));
      if (settings_.match_colors && setup.has_pose)
        colors_.show(i, shown.newest, posed_frame(setup, shown.newest->frame));
      arrived.push_back(i);
    }
    note_stale_cameras(now);
    return arrived;
  }

  /// Takes the camera out of the views, in which its last frame would stay.
  void leave_out(std::size_t camera) {
    Shown& shown = shown_[camera];
    if (!shown.newest) return;
    if (std::exchange(shown.is_fresh, false)) statistics_[camera].unshown();
    shown.newest.reset();
    colors_.forget(camera);
    is_prepared_ = false;
    must_draw_ = true;
  }

  /// Whether the view shows every listed camera but those that are left out, and at least one.
  bool is_complete() const {
    std::size_t shown = 0;
    for (std::size_t i = 0; i < shown_.size(); ++i) {
      if (shown_[i].newest) {
        ++shown;
      } else if (states_.left_out(i).empty()) {
        return false;
      }
    }
    return shown > 0;
  }

  void note_stale_cameras(Instant now) {
    for (const auto& [camera, change, worth_saying] : stale_.changes(now)) {
      const bool is_stale = change == pacing::StaleCameras::Change::kStale;
      if (is_stale) {
        statistics_[camera].stale();
        colors_.forget(camera);  // an old frame says nothing about today's light
      }
      if (!worth_saying || !states_.left_out(camera).empty()) continue;
      const std::string name = states_.name(camera);
      if (is_stale) {
        spdlog::warn("{}: camera \"{}\" sends no pictures; its last one fades from the view until some come",
                     servers_[camera], name);
      } else {
        spdlog::info("{}: camera \"{}\" sends pictures again and is back in the view", servers_[camera],
                     name);
      }
    }
  }

  std::vector<renderer::CameraView> camera_views(Instant now) const {
    std::vector<renderer::CameraView> views;
    for (std::size_t i = 0; i < shown_.size(); ++i) {
      if (!shown_[i].newest) continue;
      const Received& newest = *shown_[i].newest;
      views.push_back(camera_view(*newest.setup, newest.frame, shown_[i].version, colors_.map(i)));
      views.back().opacity = stale_.opacity(i, now);
    }
    return views;
  }

  Result<void> render(Instant begin, const renderer::VirtualCamera& eye) {
    const auto views = camera_views(begin);
    if (auto rendered = output_.render(views, eye); !rendered) return rendered;
    last_eye_ = eye;
    last_view_at_ = begin;
    must_draw_ = false;
    ++views_drawn_;
    const Instant end = steady_clock::now();
    const bool complete = is_complete() && colors_are_settled(end);
    view_statistics_.rendered(begin, end, complete);
    note_skew(end);
    if (complete) ++view_index_;
    for (std::size_t i = 0; i < shown_.size(); ++i) {
      Shown& shown = shown_[i];
      if (!shown.is_fresh) continue;
      shown.is_fresh = false;
      const Received& frame = *shown.newest;
      statistics_[i].shown(frame.frame.metadata.sequence,
                           frame.times_believed ? std::optional(end - frame.captured_at) : std::nullopt);
    }
    return {};
  }

  /// The cameras whose colours are matched live. None where there are fewer than two, which need no match.
  std::vector<std::size_t> cameras_to_match() const {
    std::vector<std::size_t> cameras;
    for (std::size_t i = 0; settings_.match_colors && i < shown_.size(); ++i) {
      const Received* const newest = shown_[i].newest.get();
      if (newest && newest->setup->has_pose && newest->stream->has_color && !newest->setup->color_matching)
        cameras.push_back(i);
    }
    return cameras.size() < 2 ? std::vector<std::size_t>{} : cameras;
  }

  /// Whether the cameras' colours are matched, need no match, or will not get one. Before that the views'
  /// colours are about to change, so views are not counted yet. Call once every camera is there.
  bool colors_are_settled(Instant now) {
    if (colors_settled_) return true;
    const std::vector<std::size_t> matched = cameras_to_match();
    if (!complete_since_) complete_since_ = now;
    using FirstMatch = LiveColorMatching::FirstMatch;
    const FirstMatch first = matched.empty() ? FirstMatch::kFound : colors_.first_match(matched);
    if (first == FirstMatch::kAwaited && now < *complete_since_ + kLongestColorWait) return false;
    colors_settled_ = true;
    if (first == FirstMatch::kFound) return true;
    for (std::size_t i : matched) {
      if (colors_.is_matched(i)) continue;
      spdlog::info(
          "{}: the colours of camera \"{}\" are shown as they come: too little of what it sees is also seen "
          "by cameras that are matched to the first one",
          servers_[i], shown_[i].newest->stream->camera);
    }
    return true;
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
      // The last view once more, also where it took a while to get here.
      const Instant now = steady_clock::now();
      auto picture =
          output_.picture(camera_views(last_view_at_.value_or(now)), last_eye_.value_or(eye_.at(0, now)));
      if (!picture) return fail(picture.error());
      if (auto written = write_png(settings_.screenshot, *picture); !written) return written;
      if (!colors_settled_ && !cameras_to_match().empty()) {
        spdlog::warn(
            "{}: the cameras' colours are not matched in this picture: the program ended before that",
            settings_.screenshot);
      }
      spdlog::info("wrote {}", settings_.screenshot);
    }
    if (settings_.stats.empty()) return {};
    if (const auto* tracker = eye_.head_tracker()) view_statistics_.head_tracker(*tracker);
    std::vector<CameraReport> reports;
    for (std::size_t i = 0; i < servers_.size(); ++i) {
      const std::string name = states_.name(i);
      reports.push_back({name.empty() ? servers_[i] : name, states_.left_out(i), statistics_[i].snapshot()});
    }
    if (auto written =
            write_statistics(settings_.stats, reports, view_statistics_, std::string(output_.renderer_name()),
                             settings_.width, settings_.height);
        !written) {
      return written;
    }
    spdlog::info("wrote {}", settings_.stats);
    return {};
  }

  void say_what_was_done() const {
    const std::uint64_t views = view_statistics_.frames();
    if (settings_.frames && views < *settings_.frames && states_.all_over())
      spdlog::warn("every camera has ended before {} views were drawn", *settings_.frames);
    spdlog::info("drew {} views of {}x{} by the {} renderer; {} of them showed every camera, {:.1f} a second",
                 views_drawn_, settings_.width, settings_.height, output_.renderer_name(), views,
                 view_statistics_.fps());
  }

  const ClientSettings& settings_;
  const scene::Scene* scene_;
  std::vector<std::string> servers_;
  ViewOutput output_;
  Eye eye_;
  std::stop_source stop_;
  flow::Mailboxes<Received> board_;
  CameraStates states_;
  LiveColorMatching colors_;
  FrameSync frames_;
  pacing::StaleCameras stale_;
  std::deque<CameraStatistics> statistics_;  // a deque, since they cannot move
  std::vector<Shown> shown_;
  std::uint64_t frames_taken_ = 0;
  bool is_prepared_ = false;  ///< the renderer has been given what is in `shown_`
  bool must_draw_ = false;    ///< the last view shows a camera that has been left out since
  ViewStatistics view_statistics_;
  std::uint64_t views_drawn_ = 0;  ///< also those that do not show every camera
  std::uint64_t view_index_ = 0;
  std::optional<renderer::VirtualCamera> last_eye_;  ///< of the last view
  std::optional<Instant> last_view_at_;              ///< when it was begun
  Instant say_skew_at_{};
  std::optional<Instant> complete_since_;  ///< every camera is in the view
  bool colors_settled_ = false;
  std::string title_;
  Instant title_due_at_{};
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
