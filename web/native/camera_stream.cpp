#include "web/native/camera_stream.h"

#include <chrono>
#include <utility>

#include "common/color/yuv420.h"

namespace copresence::web {
namespace {

constexpr int kLargestBlock = 16;  // Pixels a side, as in CpuRendererSettings.

// A frame without colour shows the last colours for this long, as in decoding::FrameDecoding.
constexpr std::chrono::milliseconds kLongestRepeat{1000};

// Returns every `step`-th pixel of every `step`-th row.
template <class Pixel>
Image<Pixel> thinned(const Image<Pixel>& image, int step) {
  Image<Pixel> result;
  result.resize(image.width() / step, image.height() / step);
  for (int y = 0; y < result.height(); ++y) {
    for (int x = 0; x < result.width(); ++x) result(x, y) = image(step * x, step * y);
  }
  return result;
}

RgbdFrame thinned(const RgbdFrame& frame, int step) {
  RgbdFrame result;
  result.metadata = frame.metadata;
  result.depth = thinned(frame.depth, step);
  result.state = thinned(frame.state, step);
  if (frame.color) result.color = thinned(*frame.color, step);
  return result;
}

CameraModel thinned(CameraModel model, int step) {
  model.width /= step;
  model.height /= step;
  for (double* const value : {&model.fx, &model.fy, &model.cx, &model.cy}) *value /= step;
  return model;
}

}  // namespace

Result<std::unique_ptr<CameraStream>> CameraStream::open(const StreamDescription& description) {
  auto decoder =
      depth::Decoder::open(description.codec, {description.model.width, description.model.height,
                                               description.unit, description.range, description.noise});
  if (!decoder) return fail(decoder.error());
  return std::unique_ptr<CameraStream>(new CameraStream(description, std::move(*decoder)));
}

CameraStream::CameraStream(const StreamDescription& description, depth::Decoder decoder)
    : description_(description),
      setup_{.model = description.model,
             .unit = description.unit,
             .noise = description.noise,
             .has_pose = description.has_pose},
      chain_(description),
      decoder_(std::move(decoder)),
      depth_picture_(description.codec.format, description.model.width, description.model.height),
      color_picture_(PixelFormat::kYuv420, description.model.width, description.model.height),
      surface_(kLargestBlock),
      remembered_surface_(kLargestBlock) {
  conditioner_.begin(setup_, std::nullopt);
  background_.begin(setup_.unit, setup_.noise);
}

Result<void> CameraStream::begin(EncodedFrame encoded) {
  encoded_ = std::move(encoded);
  auto planar = chain_.next(encoded_);
  if (!planar) return fail(planar.error());
  planar_ = std::move(*planar);
  return {};
}

std::span<const std::uint8_t> CameraStream::depth_access_unit() const {
  if (!planar_.depth.residuals.empty()) return {};
  return encoded_.depth;
}

std::span<std::uint8_t> CameraStream::color_pixels() {
  color_pixels_.resize(std::size_t{4} * description_.model.width * description_.model.height);
  return color_pixels_;
}

Result<void> CameraStream::finish(Color color) {
  const bool has_picture = !depth_access_unit().empty();
  if (has_picture) std::swap(planar_.depth.picture, depth_picture_);
  auto decoded = decoder_.decode(planar_.depth, frame_.depth, frame_.state);
  if (has_picture) std::swap(planar_.depth.picture, depth_picture_);
  if (!decoded) {
    chain_.await_keyframe();
    return decoded;
  }
  frame_.metadata = planar_.metadata;
  // A server without a pose sends the identity. The gateway's scene file may have the pose.
  if (description_.has_pose && frame_.metadata.world_from_camera == Rigid3{})
    frame_.metadata.world_from_camera = description_.world_from_camera;
  frame_.durations = planar_.durations;
  take_color(color);
  return {};
}

void CameraStream::take_color(Color color) {
  const Instant at = planar_.metadata.captured_at;
  if (color == Color::kNone) {
    frame_.color.reset();
    if (newest_color_ && at >= newest_color_at_ && at - newest_color_at_ <= kLongestRepeat)
      frame_.color = newest_color_;
    return;
  }
  ColorImage& image = newest_color_ ? *newest_color_ : newest_color_.emplace();
  if (color == Color::kPlanes) {
    color::yuv420_to_rgb(color_picture_, image);
  } else {
    image.resize(description_.model.width, description_.model.height);
    const std::uint8_t* from = color_pixels_.data();
    for (Rgb8& pixel : image.pixels()) {
      pixel = {from[0], from[1], from[2]};
      from += 4;
    }
  }
  newest_color_at_ = at;
  frame_.color = image;
}

renderer::CameraView CameraStream::view(const RgbdFrame& frame, std::uint64_t version) const {
  renderer::CameraView view;
  view.frame = &frame;
  view.version = version;
  view.model = thinned(setup_.model, step_);
  view.unit = setup_.unit;
  view.noise = setup_.noise;
  view.color_correction = color_correction_;
  return view;
}

void CameraStream::make_surface() {
  conditioner_.apply(frame_);
  background_.learn(frame_);
  if (step_ != 1) thinned_ = thinned(frame_, step_);
  surface_.update(view(surface_frame(), ++version_));
  auto covered = background_.covered();
  if (covered == remembered_ && color_correction_ == remembered_correction_ && step_ == remembered_step_)
    return;
  remembered_ = std::move(covered);
  remembered_correction_ = color_correction_;
  remembered_step_ = step_;
  ++remembered_version_;
  if (!remembered_) return;
  if (step_ == 1) {
    remembered_surface_.update(view(*remembered_, remembered_version_));
  } else {
    const RgbdFrame some = thinned(*remembered_, step_);
    remembered_surface_.update(view(some, remembered_version_));
  }
}

}  // namespace copresence::web
