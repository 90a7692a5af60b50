#include "tools/depth_bench/plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace copresence::depth_bench {
namespace {

const cv::Scalar kWhite(255, 255, 255), kBlack(0, 0, 0), kGray(215, 215, 215);

Result<void> write(const cv::Mat& image, const std::string& path) {
  bool written = false;
  try {
    written = cv::imwrite(path, image);
  } catch (const cv::Exception&) {  // Thrown for an unknown extension.
  }
  if (written) return {};
  return fail(ErrorCode::kUnavailable,
              fmt::format("{}: the plot cannot be written; give a name that ends in .png", path));
}

void text(cv::Mat& image, const std::string& words, cv::Point at, const cv::Scalar& color = kBlack,
          double size = 0.45) {
  cv::putText(image, words, at, cv::FONT_HERSHEY_SIMPLEX, size, color, 1, cv::LINE_AA);
}

constexpr std::size_t kColors = 10;

cv::Scalar color_of(std::size_t i) {
  static const std::array<cv::Scalar, kColors> colors{
      cv::Scalar(180, 80, 20),   cv::Scalar(30, 30, 210), cv::Scalar(40, 150, 40), cv::Scalar(170, 40, 150),
      cv::Scalar(0, 140, 240),   cv::Scalar(150, 150, 0), cv::Scalar(90, 90, 90),  cv::Scalar(100, 60, 0),
      cv::Scalar(200, 120, 255), cv::Scalar(0, 200, 200)};
  return colors[i % colors.size()];
}

// Draws a point of a curve. Curves of the same colour have different marks.
void mark(cv::Mat& image, cv::Point at, std::size_t i) {
  if (i < kColors) {
    cv::circle(image, at, 3, color_of(i), cv::FILLED, cv::LINE_AA);
  } else if (i < 2 * kColors) {
    cv::rectangle(image, at - cv::Point(4, 4), at + cv::Point(4, 4), color_of(i), 1, cv::LINE_AA);
  } else {
    cv::drawMarker(image, at, color_of(i), cv::MARKER_CROSS, 9, 1, cv::LINE_AA);
  }
}

// A plot area with two logarithmic axes.
class LogAxes {
 public:
  LogAxes(cv::Mat& image, cv::Rect area, std::pair<double, double> x, std::pair<double, double> y)
      : image_(image), area_(area), x_(x), y_(y) {}

  cv::Point at(double x, double y) const {
    return {area_.x + static_cast<int>(area_.width * along(x_, x)),
            area_.y + area_.height - static_cast<int>(area_.height * along(y_, y))};
  }

  void draw(const std::string& x_name, const std::string& y_name) {
    for (int decade = -4; decade <= 4; ++decade) {
      for (const double step : {1.0, 2.0, 5.0}) {
        const double value = step * std::pow(10.0, decade);
        if (value >= x_.first && value <= x_.second) {
          cv::line(image_, at(value, y_.first), at(value, y_.second), kGray);
          text(image_, fmt::format("{:g}", value), at(value, y_.first) + cv::Point(-8, 16), kBlack, 0.38);
        }
        if (value >= y_.first && value <= y_.second) {
          cv::line(image_, at(x_.first, value), at(x_.second, value), kGray);
          text(image_, fmt::format("{:g}", value), at(x_.first, value) + cv::Point(-42, 4), kBlack, 0.38);
        }
      }
    }
    cv::rectangle(image_, area_, kBlack);
    text(image_, x_name, {area_.x + area_.width / 2 - 30, area_.y + area_.height + 36});
    text(image_, y_name, {area_.x - 40, area_.y - 10});
  }

 private:
  static double along(std::pair<double, double> range, double value) {
    const double clamped = std::clamp(value, range.first, range.second);
    return std::log(clamped / range.first) / std::log(range.second / range.first);
  }

  cv::Mat& image_;
  cv::Rect area_;
  std::pair<double, double> x_, y_;
};

struct Measure {
  std::string name;
  double (*of)(const Row&);
  std::pair<double, double> range;
};

// Extends the usual range so that it contains all rows. The axis is logarithmic, so the value 0 is
// drawn at its end.
std::pair<double, double> with_all(std::pair<double, double> usual, const std::vector<Row>& rows,
                                   double (*of)(const Row&)) {
  for (const Row& row : rows) {
    if (of(row) <= 0) continue;
    usual = {std::min(usual.first, of(row) * 0.9), std::max(usual.second, of(row) * 1.1)};
  }
  return usual;
}

std::vector<std::string> codecs_of(const std::vector<Row>& rows) {
  std::vector<std::string> names;
  for (const Row& row : rows) {
    if (std::find(names.begin(), names.end(), row.codec) == names.end()) names.push_back(row.codec);
  }
  return names;
}

// Draws a 256x256 histogram of the chroma samples. Darker means more samples. Redder means a larger
// distance from `before`.
cv::Mat uv_plane(const Picture& picture, const Picture& before) {
  cv::Mat count = cv::Mat::zeros(256, 256, CV_32F), moved = cv::Mat::zeros(256, 256, CV_32F);
  const auto u = picture.plane8(1), v = picture.plane8(2), u0 = before.plane8(1), v0 = before.plane8(2);
  for (std::size_t i = 0; i < u.size(); ++i) {
    count.at<float>(255 - v[i], u[i]) += 1;
    moved.at<float>(255 - v[i], u[i]) += static_cast<float>(std::hypot(u[i] - u0[i], v[i] - v0[i]));
  }
  cv::Mat shown(256, 256, CV_8UC3, kWhite);
  for (int y = 0; y < 256; ++y) {
    for (int x = 0; x < 256; ++x) {
      const float samples = count.at<float>(y, x);
      if (samples == 0) continue;
      const double weight = std::min(1.0, 0.25 + std::log10(1.0 + samples) / 3);
      const double red = std::min(1.0, moved.at<float>(y, x) / samples / 20.0);
      shown.at<cv::Vec3b>(y, x) = cv::Vec3b(
          static_cast<std::uint8_t>(255 * (1 - weight)), static_cast<std::uint8_t>(255 * (1 - weight)),
          static_cast<std::uint8_t>(255 * (1 - weight) + 255 * weight * red));
    }
  }
  return shown;
}

}  // namespace

Result<void> plot_curves(const std::vector<Row>& rows, const std::string& path) {
  cv::Mat image(560, 1500, CV_8UC3, kWhite);
  const auto names = codecs_of(rows);
  const std::array<Measure, 2> measures{
      Measure{"RMSE, mm", [](const Row& row) { return row.rmse_mm; }, {1, 1000}},
      Measure{"beyond 3 disparity steps, %",
              [](const Row& row) { return row.percent_beyond_3_steps; },
              {0.001, 100}}};
  for (std::size_t panel = 0; panel < measures.size(); ++panel) {
    const Measure& measure = measures[panel];
    const auto rates = with_all({0.3, 60}, rows, [](const Row& row) { return row.mbps; });
    LogAxes axes(image, {60 + static_cast<int>(panel) * 630, 40, 550, 450}, rates,
                 with_all(measure.range, rows, measure.of));
    axes.draw("Mbit/s", measure.name);
    for (std::size_t i = 0; i < names.size(); ++i) {
      std::vector<Row> curve;
      std::copy_if(rows.begin(), rows.end(), std::back_inserter(curve),
                   [&](const Row& row) { return row.codec == names[i]; });
      std::sort(curve.begin(), curve.end(), [](const Row& a, const Row& b) { return a.mbps < b.mbps; });
      for (std::size_t k = 0; k < curve.size(); ++k) {
        const cv::Point here = axes.at(curve[k].mbps, measure.of(curve[k]));
        mark(image, here, i);
        if (k > 0) {
          cv::line(image, axes.at(curve[k - 1].mbps, measure.of(curve[k - 1])), here, color_of(i), 1,
                   cv::LINE_AA);
        }
      }
    }
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    const cv::Point at(1275, 55 + static_cast<int>(i) * 22);
    cv::line(image, at, at + cv::Point(18, 0), color_of(i), 2, cv::LINE_AA);
    mark(image, at + cv::Point(9, 0), i);
    text(image, names[i], at + cv::Point(26, 5));
  }
  return write(image, path);
}

Result<void> plot_uv(const std::vector<Shot>& shots, const std::string& path) {
  std::vector<cv::Mat> lines;
  for (const auto& [title, shot] : shots) {
    if (shot.before.planes() != 3) continue;
    cv::Mat line(290, 580, CV_8UC3, kWhite);
    text(line, title + ", UV before and after H.264", {16, 20});
    uv_plane(shot.before, shot.before).copyTo(line(cv::Rect(16, 30, 256, 256)));
    uv_plane(shot.after, shot.before).copyTo(line(cv::Rect(304, 30, 256, 256)));
    lines.push_back(line);
  }
  if (lines.empty()) return {};
  cv::Mat image;
  cv::vconcat(lines, image);
  return write(image, path);
}

Result<void> plot_errors(const std::vector<Shot>& shots, DepthUnit unit, const std::string& path) {
  std::vector<cv::Mat> pictures;
  for (const auto& [title, shot] : shots) {
    cv::Mat error(shot.depth.height(), shot.depth.width(), CV_8UC1, cv::Scalar(0));
    for (int y = 0; y < shot.depth.height(); ++y) {
      for (int x = 0; x < shot.depth.width(); ++x) {
        const double z = shot.depth(x, y) * metres_per_unit(unit);
        if (z == 0) continue;
        const double steps = std::abs(shot.back(x, y) * metres_per_unit(unit) - z) / kKinectV1Noise.step_m(z);
        error.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(std::min(255.0, steps * 25.5));
      }
    }
    cv::Mat shown;
    cv::applyColorMap(error, shown, cv::COLORMAP_HOT);
    for (int y = 0; y < shot.depth.height(); ++y) {
      for (int x = 0; x < shot.depth.width(); ++x) {
        if (shot.depth(x, y) == 0) shown.at<cv::Vec3b>(y, x) = cv::Vec3b(120, 60, 20);
      }
    }
    text(shown, title, {10, 22}, kWhite, 0.6);
    pictures.push_back(shown);
  }
  if (pictures.empty()) return {};
  cv::Mat image;
  cv::vconcat(pictures, image);
  return write(image, path);
}

}  // namespace copresence::depth_bench
