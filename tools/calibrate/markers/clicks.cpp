#include "tools/calibrate/markers/clicks.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <opencv2/highgui.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/text/excerpt.h"
#include "common/text/text_file.h"

namespace copresence::calibrate {

Result<Clicks> load_clicks(const std::filesystem::path& file) {
  const auto text = text::read_text_file(file, "a file of points");
  if (!text) return fail(text.error());
  std::istringstream in(*text);
  Clicks clicks;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::string camera, rest;
    if (!(words >> camera)) continue;
    FoundMarker marker;
    marker.sigma_px = kClickSigma;
    if (!(words >> marker.name >> marker.middle.x() >> marker.middle.y()) || !marker.middle.allFinite() ||
        words >> rest) {
      return fail(ErrorCode::kInvalid,
                  fmt::format("{}:{}: a line must be \"camera marker x y\", pixels", file.string(), number));
    }
    for (const FoundMarker& other : clicks[camera]) {
      if (other.name == marker.name) {
        return fail(ErrorCode::kInvalid,
                    fmt::format("{}:{}: marker {} of camera {} is there twice", file.string(), number,
                                text::excerpt(marker.name), text::excerpt(camera)));
      }
    }
    clicks[camera].push_back(std::move(marker));
  }
  return clicks;
}

Result<void> save_clicks(const Clicks& clicks, const std::filesystem::path& file) {
  std::ofstream out(file);
  out << "# camera marker x y: pixels, clicked in calibrate markers --click\n";
  for (const auto& [camera, markers] : clicks) {
    for (const FoundMarker& marker : markers) {
      out << fmt::format("{} {} {:.2f} {:.2f}\n", camera, marker.name, marker.middle.x(), marker.middle.y());
    }
  }
  if (!out.flush()) return fail(ErrorCode::kUnavailable, fmt::format("{}: cannot be written", file.string()));
  return {};
}

void ClickList::click(double x, double y) {
  places_.emplace_back(Eigen::Vector2d(x, y));
}

std::vector<FoundMarker> ClickList::markers() const {
  std::vector<FoundMarker> out;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (places_[i]) out.push_back({fmt::format("click{}", i + 1), *places_[i], {}, kClickSigma});
  }
  return out;
}

namespace {

// OpenCV's window library, Qt, exits the program if there is no display. So a child process first
// tries to open a window. The child must run before the first window opens: a child cannot share a
// display that Qt already uses.
bool try_a_window() {
  const pid_t child = fork();
  if (child < 0) return false;
  if (child == 0) {
    const int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    try {
      cv::namedWindow("calibrate", cv::WINDOW_AUTOSIZE);
      _exit(0);
    } catch (const cv::Exception&) {
      _exit(1);
    }
  }
  int status = 0;
  return waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

bool can_open_windows() {
  static const bool can = try_a_window();
  return can;
}

Error no_window() {
  return {ErrorCode::kUnavailable,
          "no window can be opened to click in (is there a display?); use printed markers, or --points FILE"};
}

}  // namespace

Result<std::vector<FoundMarker>> ask_for_clicks(const std::string& camera, const ColorImage& picture) {
  if (!can_open_windows()) return fail(no_window());
  const std::string title = "calibrate markers: " + camera;
  constexpr int kZoom = 2;
  const cv::Mat rgb(picture.height(), picture.width(), CV_8UC3, const_cast<Rgb8*>(picture.data()));
  cv::Mat large;
  cv::resize(rgb, large, {}, kZoom, kZoom, cv::INTER_CUBIC);
  cv::cvtColor(large, large, cv::COLOR_RGB2BGR);
  ClickList list;
  try {
    cv::namedWindow(title, cv::WINDOW_AUTOSIZE | cv::WINDOW_GUI_NORMAL);
    cv::setMouseCallback(
        title,
        [](int event, int x, int y, int, void* to) {
          // Pixel centres are at whole coordinates, in both the picture and its enlarged copy.
          if (event == cv::EVENT_LBUTTONDOWN) {
            static_cast<ClickList*>(to)->click((x + 0.5) / kZoom - 0.5, (y + 0.5) / kZoom - 0.5);
          }
        },
        &list);
    // If the user still holds down the return key of the previous window, the key repeats here.
    constexpr auto kReleased = std::chrono::milliseconds(300);
    auto last_key = std::chrono::steady_clock::now();
    bool released = false;
    constexpr int kReturn = 13, kLineFeed = 10, kBackspace = 8, kSpace = 32, kEscape = 27, kNoKey = 255;
    for (;;) {
      cv::Mat shown = large.clone();
      for (const FoundMarker& marker : list.markers()) {
        const cv::Point at(static_cast<int>(std::lround((marker.middle.x() + 0.5) * kZoom - 0.5)),
                           static_cast<int>(std::lround((marker.middle.y() + 0.5) * kZoom - 0.5)));
        cv::drawMarker(shown, at, {0, 0, 255}, cv::MARKER_CROSS, 16, 1);
        cv::putText(shown, marker.name, at + cv::Point(8, -8), cv::FONT_HERSHEY_SIMPLEX, 0.8, {0, 0, 255}, 2);
      }
      cv::putText(
          shown,
          fmt::format("click marker {}   space: not seen   backspace: undo   return: done", list.next()),
          {12, 28}, cv::FONT_HERSHEY_SIMPLEX, 0.7, {0, 255, 255}, 2);
      cv::imshow(title, shown);
      const int key = cv::waitKey(30) & 0xFF;
      if (!released) {
        const auto now = std::chrono::steady_clock::now();
        if (key != kNoKey) last_key = now;
        released = now - last_key > kReleased;
        continue;
      }
      if (key == kReturn || key == kLineFeed) break;
      if (key == kBackspace) list.undo();
      if (key == kSpace) list.skip();
      if (key == kEscape || cv::getWindowProperty(title, cv::WND_PROP_VISIBLE) < 1) {
        return fail(ErrorCode::kRefused,
                    "the window of camera " + camera + " was closed before return was pressed");
      }
    }
    cv::destroyWindow(title);
  } catch (const cv::Exception&) {
    return fail(no_window());
  }
  return list.markers();
}

}  // namespace copresence::calibrate
