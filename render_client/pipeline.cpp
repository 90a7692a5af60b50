#include "render_client/pipeline.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <pthread.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <filesystem>
#include <thread>
#include <utility>

#include "common/flow/mailboxes.h"
#include "common/flow/thread_priority.h"
#include "common/flow/worker_pool.h"
#include "common/scene/scene.h"
#include "render_client/camera_receiver.h"
#include "render_client/display/display.h"
#include "render_client/display/screenshot.h"
#include "render_client/display/view_colors.h"
#include "render_client/film/film.h"
#include "render_client/frame_sources.h"
#include "render_client/overlay_report.h"
#include "render_client/pacing/render_pacer.h"
#include "render_client/renderer/cpu/cpu_renderer.h"
#include "render_client/renderer/gl/gl_renderer.h"
#include "render_client/replay.h"
#include "render_client/session_recorder.h"
#include "render_client/shown_cameras.h"
#include "render_client/view_options.h"
#include "render_client/viewpoint/viewer.h"

namespace copresence::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr const char* kTitle = "Copresence";
/// Time between updates of the window's title and overlay.
constexpr milliseconds kReportEvery{250};
constexpr milliseconds kLogSkewEvery{10'000};
/// Nice value of the thread that matches colours. Rendering has a higher priority.
constexpr int kColorsNice = 10;

Result<std::unique_ptr<display::Display>> open_display(const ClientSettings& settings) {
  if (!settings.headless)
    return display::open_window(kTitle, settings.width, settings.height, settings.stereo);
  using display::HeadlessGl;
  return display::open_headless(settings.renderer == "gl"     ? HeadlessGl::kYes
                                : settings.renderer == "auto" ? HeadlessGl::kOnGraphicsCard
                                                              : HeadlessGl::kNo,
                                settings.stereo);
}

/// Makes the renderer that --renderer names. `context` is null if there is no OpenGL.
Result<std::unique_ptr<renderer::Renderer>> make_renderer(const std::string& choice, gl::Context* context,
                                                          Executor& workers) {
  const bool use_gl = context && (choice == "gl" || (choice == "auto" && !context->is_software()));
  if (use_gl) return renderer::make_gl_renderer(*context);
  return renderer::make_cpu_renderer(workers);
}

class Pipeline {
 public:
  Pipeline(const ClientSettings& settings, const scene::Scene* scene, FrameSources sources,
           std::unique_ptr<display::Display> display, std::unique_ptr<renderer::Renderer> renderer,
           viewpoint::Viewer viewer, std::stop_source stop)
      : settings_(settings),
        options_{.unseen = settings.unseen},
        scene_(scene),
        sources_(std::move(sources)),
        display_(std::move(display)),
        renderer_(std::move(renderer)),
        viewer_(std::move(viewer)),
        stop_(std::move(stop)),
        mailboxes_(sources_.names.size()),
        states_(sources_.listed(scene),
                [this] {
                  // A window stays open, since it says why.
                  if (settings_.headless) stop_.request_stop();
                }),
        statistics_(sources_.names.size()),
        colors_(sources_.names.size()),
        cameras_(settings_, sources_.names, states_, statistics_, colors_),
        pacer_(static_cast<int>(sources_.names.size()), settings_.fps),
        report_(states_, statistics_, cameras_, scene) {
    options_.can_draw_wireframe = renderer_->set_wireframe(false);
    if (sources_.playback) replay_.emplace(*sources_.playback, states_);
  }

  Result<void> run() {
    if (auto opened = open_outputs(); !opened) return opened;
    std::vector<std::jthread> receivers;
    for (std::size_t i = 0; i < sources_.names.size(); ++i) {
      receivers.emplace_back([this, i] { receive(i); });
    }
    std::jthread matcher;
    if (settings_.match_colors && sources_.names.size() > 1 && !is_stepped_replay()) {
      matcher = std::jthread([this](const std::stop_token& stop) {
        pthread_setname_np(pthread_self(), "colors");
        flow::lower_priority(kColorsNice);
        colors_.run(stop);
      });
    }
    Result<void> rendered = is_stepped_replay() ? render_replay() : render_views();
    if (film_ && rendered) rendered = film_->finish();
    Result<void> written = write_results();
    if (settings_.headless) log_summary();
    stop_.request_stop();
    receivers.clear();
    if (const auto refused = states_.all_refused()) return fail(*refused);
    return rendered ? written : rendered;
  }

 private:
  Result<void> open_outputs() {
    if (!settings_.record.empty()) {
      auto writer = session::SessionWriter::create(settings_.record, steady_clock::now());
      if (!writer) return fail(writer.error());
      recorder_ = std::make_unique<SessionRecorder>(std::move(*writer), sources_.names.size());
    }
    if (settings_.film.empty()) return {};
    auto film = film::open_film(settings_.film, settings_.width, settings_.height, settings_.fps);
    if (!film) return fail(film.error());
    film_ = std::move(*film);
    return {};
  }

  void receive(std::size_t slot) {
    pthread_setname_np(pthread_self(), fmt::format("camera {}", slot).c_str());
    // In a window, the user may show remembered backgrounds later.
    const bool remembers =
        !settings_.headless || settings_.unseen.show != renderer::UnseenStyle::Show::kBlack;
    CameraReceiver({sources_.names[slot], slot, sources_.connect(slot), [this] { return now(); }}, scene_,
                   remembers, mailboxes_, statistics_[slot], states_, recorder_.get())
        .run(stop_.get_token());
  }

  /// The present on the clock of the frames' times. In a replay, it is the replay's position.
  Instant now() const { return sources_.playback ? sources_.playback->now() : steady_clock::now(); }

  /// Whether views are drawn at fixed times of a recording and not in real time.
  bool is_stepped_replay() const { return settings_.headless && sources_.playback; }

  /// Draws the views of a recording as fast as possible. A view shows all frames up to its time,
  /// and colours are matched between views. So the same recording always gives the same views.
  Result<void> render_replay() {
    while (!finished() && replay_->next_view(settings_.fps, stop_.get_token())) {
      take_frames();
      match_colors();
      const display::NextView view{.display_time = steady_clock::now(),
                                   .eyes = display::eyes_of(settings_.stereo)};
      if (auto rendered = draw(view, WhenUnchanged::kDraw); !rendered) return rendered;
    }
    return {};
  }

  /// Matches the colours on this thread. While no match is known, it tries again with the same
  /// frames until the cameras' overlap proves too small.
  void match_colors() {
    if (!settings_.match_colors || sources_.names.size() < 2) return;
    colors_.compare_if_due(now());
    for (int i = 0; i < color_matching::LiveColorMatching::kRoundsToGiveUp; ++i) {
      if (!cameras_.are_complete() || cameras_.colors_are_settled(now())) return;
      colors_.compare(Duration::zero());
    }
  }

  /// Draws views when they are due. A headless client ends after the last frame of every camera.
  Result<void> render_views() {
    std::optional<Instant> wanted;  // Time of the next view according to the RenderPacer.
    while (!finished() && !display_->is_closed()) {
      const auto next =
          display_->wait_for_next(wanted, [&](Instant until) { prepare_or_wait(wanted.has_value(), until); });
      // This is checked before frames are taken, so that the last frames are still shown.
      const bool have_ended = settings_.headless && states_.all_over();
      if (replay_ && next) replay_->follow(next->commands, steady_clock::now());
      take_frames();
      log_news();
      if (next) {
        if (auto rendered = draw(*next, WhenUnchanged::kShowAgain); !rendered) return rendered;
      }
      if (have_ended && !cameras_.have_waiting()) return {};
      wanted = pacer_.next_render_at(steady_clock::now());
      if (!wanted) wanted = cameras_.next_fading_view();
    }
    return {};
  }

  bool finished() const {
    return stop_.stop_requested() || (settings_.frames && view_statistics_.frames() >= *settings_.frames);
  }

  /// Prepares the new frames for rendering if a view will be due. Otherwise waits for frames.
  void prepare_or_wait(bool is_due, Instant until) {
    if (is_due && !std::exchange(is_prepared_, true)) {
      renderer_->prepare(cameras_.views(now()));
    } else {
      mailboxes_.wait(stop_.get_token(), cameras_.wake_by(until));
    }
  }

  void take_frames() {
    for (const ShownCameras::Arrival& arrival : cameras_.take(mailboxes_, now())) {
      pacer_.frame_arrived(static_cast<int>(arrival.camera), arrival.arrived_at);
      viewer_.on_camera_pose(arrival.camera, arrival.world_from_camera, arrival.model);
      is_prepared_ = false;
    }
  }

  enum class WhenUnchanged { kShowAgain, kDraw };

  /// Draws a view. If nothing has changed, it can show the last view again.
  Result<void> draw(const display::NextView& next, WhenUnchanged when_unchanged) {
    for (const viewpoint::Gesture& gesture : next.gestures) viewer_.apply(gesture);
    const bool has_new_options = obey(next.commands);
    show_report();
    const Instant begin = steady_clock::now();
    pacer_.rendered(begin);
    auto poses = viewer_.at(view_index_, next.display_time, next.eyes);
    const Instant now = this->now();
    const bool fades = cameras_.next_fading_view().value_or(Instant::max()) <= now;
    const bool has_changed = cameras_.have_changed() || fades || has_new_options || poses != poses_;
    if (!has_changed && when_unchanged == WhenUnchanged::kShowAgain) {
      display_->show_again();
      if (std::exchange(saves_screenshot_, false)) save_screenshot();
      return {};
    }
    poses_ = std::move(poses);
    // The pictures of the GL renderer are not copied from the graphics card, if there is one eye and
    // no film.
    const bool needs_host_pixels = renderer_->name() == "cpu" || poses_.size() > 1 || film_;
    if (auto rendered = render(now, needs_host_pixels, pictures_); !rendered) return rendered;
    display_->show(pictures_);
    auto counted = count_view(begin, now);
    if (std::exchange(saves_screenshot_, false)) save_screenshot();
    return counted;
  }

  /// Draws the picture of each eye, with the cameras' opacities at `now`.
  Result<void> render(Instant now, bool needs_host_pixels, std::vector<renderer::MergedView>& pictures) {
    const auto views = cameras_.views(now);
    const bool recolors = options_.colors != display::ViewColors::kCameras;
    const renderer::HostPixels wanted{.color = needs_host_pixels || recolors, .depth = recolors};
    pictures.resize(poses_.size());
    for (std::size_t eye = 0; eye < poses_.size(); ++eye) {
      pictures[eye].target = static_cast<int>(eye);
      if (auto drawn = renderer_->render(views, poses_[eye], wanted, pictures[eye]); !drawn) return drawn;
      display::recolor(options_.colors, cameras_.cameras_of_views(), pictures[eye]);
    }
    return {};
  }

  /// Carries out the user's commands. Returns whether the view must be drawn again.
  bool obey(const std::vector<display::Command>& commands) {
    bool has_new_options = false;
    for (const display::Command command : commands) {
      saves_screenshot_ |= command == display::Command::kSaveScreenshot;
      has_new_options |= options_.apply(command);
    }
    if (has_new_options) {
      renderer_->set_merge(options_.merge);
      renderer_->set_wireframe(options_.wireframe);
      renderer_->set_unseen(options_.shown_unseen());
      cameras_.correct_colors(options_.corrects_colors);
    }
    if (!commands.empty()) report_due_at_ = {};  // The switches change at once.
    return has_new_options;
  }

  /// Counts a view that was begun at `begin`, and adds it to the film. `shown_at` is the same
  /// instant on the clock of the frames' times.
  Result<void> count_view(Instant begin, Instant shown_at) {
    ++views_drawn_;
    const Instant now = this->now(), end = steady_clock::now();
    const bool complete = cameras_.are_complete() && cameras_.colors_are_settled(now);
    view_statistics_.rendered(begin, end, complete);
    report_.view_drawn(begin, end, pictures_.front().shares);
    if (complete && pictures_.front().shares) view_statistics_.origins(*pictures_.front().shares);
    if (const auto skew = cameras_.skew(now)) note_skew(*skew, now);
    if (complete) ++view_index_;
    cameras_.displayed(shown_at, now);
    if (!complete || !film_) return {};
    if (view_index_ == 1) film_began_at_ = shown_at;
    return film_->add(display_->combine(pictures_), shown_at - film_began_at_);
  }

  void note_skew(Duration duration, Instant now) {
    view_statistics_.skew(duration);
    if (now < log_skew_at_) return;
    if (log_skew_at_ != Instant{}) {
      const auto& skew = view_statistics_.skew();
      spdlog::info("the cameras' pictures in a view are {:.1f} ms apart (p95 {:.1f} ms){}",
                   skew.percentile_ms(50), skew.percentile_ms(95), settings_.sync ? ", synchronised" : "");
    }
    log_skew_at_ = now + kLogSkewEvery;
  }

  /// Updates what the window says: its title and its overlay.
  void show_report() {
    const Instant now = steady_clock::now();
    if (settings_.headless || now < report_due_at_) return;
    report_due_at_ = now + kReportEvery;
    const std::string program = replay_ ? fmt::format("{} ({})", kTitle, replay_->text()) : kTitle;
    display_->set_title(states_.title(program));
    overlay::Content content = report_.content(this->now());
    content.switches = options_.switches();
    display_->set_overlay(std::move(content));
  }

  void log_news() {
    while (const auto news = viewer_.news(steady_clock::now())) {
      spdlog::log(news->is_trouble ? spdlog::level::warn : spdlog::level::info, "{}", news->text);
    }
  }

  Result<void> write_results() {
    if (!settings_.screenshot.empty()) {
      if (auto written = write_screenshot(settings_.screenshot); !written) return written;
    }
    if (settings_.stats.empty()) return {};
    if (const auto* tracker = viewer_.head_tracker()) view_statistics_.head_tracker(*tracker);
    std::vector<statistics::CameraReport> reports;
    for (std::size_t i = 0; i < sources_.names.size(); ++i) {
      const std::string name = states_.name(i);
      reports.push_back(
          {name.empty() ? sources_.names[i] : name, states_.left_out(i), statistics_[i].snapshot()});
    }
    if (auto written =
            statistics::write_statistics(settings_.stats, reports, view_statistics_,
                                         std::string(renderer_->name()), settings_.width, settings_.height);
        !written) {
      return written;
    }
    spdlog::info("wrote {}", settings_.stats);
    return {};
  }

  /// Draws the last view again as host pixels, with unchanged opacities, and writes it.
  Result<void> write_screenshot(const std::string& path) {
    const Instant now = this->now();
    if (poses_.empty()) poses_ = viewer_.at(0, now, std::vector<viewpoint::Eye>(1));
    std::vector<renderer::MergedView> pictures;
    if (auto drawn = render(cameras_.last_view_at().value_or(now), true, pictures); !drawn) return drawn;
    if (auto written = display::write_png(path, display_->combine(pictures)); !written) return written;
    if (cameras_.awaits_colors()) {
      spdlog::warn("{}: the cameras' colours are not matched in this picture, since the program ended early",
                   path);
    }
    spdlog::info("wrote {}", path);
    return {};
  }

  /// Writes the last view to a file whose name has the time.
  void save_screenshot() {
    const auto now = std::chrono::system_clock::now();
    const auto ms = std::chrono::duration_cast<milliseconds>(now.time_since_epoch()).count() % 1000;
    const std::string path = fmt::format("copresence-{:%Y%m%d-%H%M%S}-{:03}.png",
                                         fmt::localtime(std::chrono::system_clock::to_time_t(now)), ms);
    const auto written = write_screenshot(path);
    report_.say(written ? "wrote " + std::filesystem::absolute(path).string() : written.error().what,
                this->now());
  }

  void log_summary() const {
    const std::uint64_t views = view_statistics_.frames();
    if (settings_.frames && views < *settings_.frames && states_.all_over())
      spdlog::warn("every camera has ended before {} views were drawn", *settings_.frames);
    spdlog::info("drew {} views of {}x{} by the {} renderer; {} of them showed every camera, {:.1f} a second",
                 views_drawn_, settings_.width, settings_.height, renderer_->name(), views,
                 view_statistics_.fps());
  }

  const ClientSettings& settings_;
  ViewOptions options_;
  const scene::Scene* scene_;
  FrameSources sources_;
  std::unique_ptr<display::Display> display_;
  std::unique_ptr<renderer::Renderer> renderer_;  // It may use the display's context.
  viewpoint::Viewer viewer_;
  std::unique_ptr<SessionRecorder> recorder_;  // Null without --record.
  std::unique_ptr<film::Film> film_;           // Null without --film.
  Instant film_began_at_{};
  std::stop_source stop_;
  flow::Mailboxes<CameraFrame> mailboxes_;
  stream::CameraStates states_;
  std::deque<statistics::CameraStatistics> statistics_;  // A deque, since the elements cannot move.
  color_matching::LiveColorMatching colors_;
  ShownCameras cameras_;
  pacing::RenderPacer pacer_;
  bool saves_screenshot_ = false;               // Whether a screenshot is saved after the next view.
  bool is_prepared_ = false;                    // Whether all taken frames are prepared.
  std::vector<viewpoint::ViewPose> poses_;      // Poses of the last view, by eye.
  std::vector<renderer::MergedView> pictures_;  // Pictures of the last view, by eye.
  statistics::ViewStatistics view_statistics_;
  std::uint64_t views_drawn_ = 0;  // Complete and incomplete views.
  std::uint64_t view_index_ = 0;
  Instant log_skew_at_{};
  OverlayReport report_;
  Instant report_due_at_{};
  std::optional<Replay> replay_;  // Empty unless a recording is replayed.
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
  auto sources = open_sources(settings, known);
  if (!sources) return fail(sources.error());
  auto viewer =
      viewpoint::Viewer::open(settings.view, {settings.width, settings.height, settings.fov_degrees},
                              scene ? scene->up : scene::Scene{}.up);
  if (!viewer) return fail(viewer.error());
  flow::WorkerPool workers(static_cast<int>(std::max(1u, std::thread::hardware_concurrency())), "render");
  auto display = open_display(settings);
  if (!display) return fail(display.error());
  auto renderer = make_renderer(settings.renderer, (*display)->context(), workers);
  if (!renderer) return fail(renderer.error());
  (*renderer)->set_unseen(settings.unseen);
  return Pipeline(settings, known, std::move(*sources), std::move(*display), std::move(*renderer),
                  std::move(*viewer), std::move(stop))
      .run();
}

}  // namespace copresence::client
