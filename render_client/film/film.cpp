#include "render_client/film/film.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <optional>
#include <utility>

#include "common/bitstream/length_prefixed.h"
#include "common/color/yuv420.h"
#include "common/file/output_file.h"
#include "common/matroska/writer.h"
#include "common/version.h"
#include "common/video/picture_encoder.h"
#include "render_client/display/screenshot.h"

namespace copresence::film {
namespace {

constexpr int kQp = 20;  // Hardly any visible loss.
constexpr std::chrono::seconds kKeyframeEvery{2};

class MatroskaFilm final : public Film {
 public:
  MatroskaFilm(matroska::Writer file, video::PictureEncoder encoder)
      : file_(std::move(file)), encoder_(std::move(encoder)) {}

  Result<void> add(const Image<Rgba8>& view, Duration time) override {
    rgb_.resize(view.width(), view.height());
    std::transform(view.pixels().begin(), view.pixels().end(), rgb_.pixels().begin(), [](const Rgba8& pixel) {
      return Rgb8{pixel.r, pixel.g, pixel.b};
    });
    color::rgb_to_yuv420(rgb_, picture_);
    const bool is_keyframe = !track_ || time >= next_keyframe_;
    auto encoded = encoder_.encode(picture_, is_keyframe);
    if (!encoded) return fail(encoded.error());
    const auto nals = bitstream::split_access_unit(*encoded);
    if (!nals) return fail(nals.error());
    if (!track_) {
      auto added = add_track(*nals);
      if (!added) return fail(added.error());
      track_ = *added;
    }
    if (is_keyframe) next_keyframe_ = time + kKeyframeEvery;
    const auto bytes = bitstream::to_length_prefixed(*nals);
    return file_.write(std::chrono::round<matroska::Time>(time), {*track_, is_keyframe, bytes});
  }

  Result<void> finish() override { return file_.finish(); }

 private:
  Result<std::uint64_t> add_track(std::span<const bitstream::Nal> first) {
    auto configuration = bitstream::avc_configuration(first, PixelFormat::kYuv420);
    if (!configuration) return fail(ErrorCode::kUnsupported, "libx264 begins without parameter sets");
    const video::PictureSettings& settings = encoder_.settings();
    return file_.add_track({.name = "view",
                            .codec_private = std::move(*configuration),
                            .width = settings.width,
                            .height = settings.height,
                            .frame_period = std::chrono::nanoseconds(
                                static_cast<std::int64_t>(1e9 / settings.frames_per_second))});
  }

  matroska::Writer file_;
  video::PictureEncoder encoder_;
  std::optional<std::uint64_t> track_;
  Duration next_keyframe_{};
  ColorImage rgb_;
  Picture picture_;
};

class PictureFolder final : public Film {
 public:
  explicit PictureFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  Result<void> add(const Image<Rgba8>& view, Duration) override {
    return display::write_png((folder_ / fmt::format("{:06}.png", pictures_++)).string(), view);
  }
  Result<void> finish() override { return {}; }

 private:
  std::filesystem::path folder_;
  std::uint64_t pictures_ = 0;
};

Result<std::unique_ptr<Film>> open_file(const std::string& path, const video::PictureSettings& settings) {
  auto encoder = video::PictureEncoder::open(settings);
  if (!encoder) return fail(encoder.error());
  auto output = file::OutputFile::create(path, file::Existing::kReplace);
  if (!output) return fail(output.error());
  auto file = matroska::Writer::begin(
      std::move(*output), {.title = "Copresence view", .program = fmt::format("render_client {}", kVersion)});
  if (!file) return fail(file.error());
  return std::make_unique<MatroskaFilm>(std::move(*file), std::move(*encoder));
}

}  // namespace

bool is_film_file(const std::string& path) {
  return std::filesystem::path(path).extension() == ".mkv";
}

Result<std::unique_ptr<Film>> open_film(const std::string& path, int width, int height,
                                        double views_per_second) {
  if (is_film_file(path)) {
    return open_file(path, {.kind = video::PictureKind::kColor,
                            .format = PixelFormat::kYuv420,
                            .width = width,
                            .height = height,
                            .frames_per_second = views_per_second,
                            .qp = kQp});
  }
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (!std::filesystem::is_directory(path))
    return fail(ErrorCode::kUnavailable,
                fmt::format("{}: the folder cannot be made: {}", path, error.message()));
  return std::make_unique<PictureFolder>(path);
}

}  // namespace copresence::film
