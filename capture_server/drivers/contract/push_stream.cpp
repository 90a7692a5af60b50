#include "capture_server/drivers/contract/push_stream.h"

#include <algorithm>
#include <cassert>
#include <cstring>

namespace copresence::drivers {
namespace {

int bytes_per_pixel(OniPixelFormat format) {
  switch (format) {
    case ONI_PIXEL_FORMAT_RGB888:
      return 3;
    case ONI_PIXEL_FORMAT_GRAY8:
      return 1;
    default:
      return 2;
  }
}

int row_bytes_of(const OniVideoMode& mode) {
  return mode.resolutionX * bytes_per_pixel(mode.pixelFormat);
}

bool same(const OniVideoMode& a, const OniVideoMode& b) {
  return a.pixelFormat == b.pixelFormat && a.resolutionX == b.resolutionX && a.resolutionY == b.resolutionY &&
         a.fps == b.fps;
}

}  // namespace

OniStatus answer(const void* value, int size, void* data, int* data_size) {
  if (!data || !data_size || *data_size < size) return ONI_STATUS_BAD_PARAMETER;
  std::memcpy(data, value, static_cast<std::size_t>(size));
  *data_size = size;
  return ONI_STATUS_OK;
}

PushStream::PushStream(StreamOwner& owner, OniSensorType type, std::vector<OniVideoMode> modes, int max_value)
    : owner_(owner), type_(type), modes_(std::move(modes)), max_value_(max_value), mode_(modes_.front()) {}

PushStream::~PushStream() {
  PushStream::stop();
}

OniVideoMode PushStream::mode() const {
  const std::lock_guard lock(mutex_);
  return mode_;
}

void PushStream::set_lens(const Lens& lens) {
  const std::lock_guard lock(mutex_);
  lens_ = lens;
}

int PushStream::row_bytes() const {
  return row_bytes_of(mode());
}

int PushStream::getRequiredFrameSize() {
  const OniVideoMode now = mode();
  return row_bytes_of(now) * now.resolutionY;
}

std::optional<PushStream::Picture> PushStream::next_picture() {
  OniVideoMode now;
  {
    const std::lock_guard lock(mutex_);
    if (!running_) return std::nullopt;
    assert(!on_its_way_);
    on_its_way_ = true;
    now = mode_;
  }
  Picture picture(*this, getServices().acquireFrame());
  OniFrame* frame = picture.frame_.get();
  if (!frame) {
    no_picture();
    return std::nullopt;
  }
  frame->sensorType = type_;
  frame->videoMode = now;
  frame->width = now.resolutionX;
  frame->height = now.resolutionY;
  frame->stride = row_bytes_of(now);
  frame->dataSize = frame->stride * now.resolutionY;
  frame->croppingEnabled = FALSE;
  frame->cropOriginX = frame->cropOriginY = 0;
  return picture;
}

void PushStream::no_picture() {
  const std::lock_guard lock(mutex_);
  on_its_way_ = false;
  // Notified with the lock held, because the waiting thread may destroy the stream.
  given_back_.notify_all();
}

void PushStream::Picture::GiveBack::operator()(OniFrame* frame) const {
  stream->getServices().releaseFrame(frame);
  stream->no_picture();
}

void PushStream::Picture::send(std::uint64_t timestamp_us, int index) {
  frame_->timestamp = timestamp_us;
  frame_->frameIndex = index;
  frame_.get_deleter().stream->raiseNewFrame(frame_.get());
  frame_.reset();
}

OniStatus PushStream::start() {
  {
    const std::lock_guard lock(mutex_);
    if (running_) return ONI_STATUS_OK;
    running_ = true;
  }
  const OniStatus begun = owner_.begin(*this);
  if (begun != ONI_STATUS_OK) end_pictures();
  return begun;
}

void PushStream::stop() {
  if (end_pictures()) owner_.end(*this);
}

bool PushStream::end_pictures() {
  std::unique_lock lock(mutex_);
  if (!running_) return false;
  running_ = false;
  given_back_.wait(lock, [this] { return !on_its_way_; });
  return true;
}

OniBool PushStream::isPropertySupported(int property) {
  alignas(double) char room[64];
  int size = sizeof(room);
  return getProperty(property, room, &size) == ONI_STATUS_OK;
}

OniStatus PushStream::getProperty(int property, void* data, int* size) {
  const OniStatus special = owner_.get_of(*this, property, data, size);
  if (special != ONI_STATUS_NOT_SUPPORTED) return special;
  const auto give = [&](const auto& value) { return answer(&value, sizeof(value), data, size); };
  const OniVideoMode now = mode();
  Lens lens;
  {
    const std::lock_guard lock(mutex_);
    lens = lens_;
  }
  switch (property) {
    case ONI_STREAM_PROPERTY_VIDEO_MODE:
      return give(now);
    case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
      return give(lens.horizontal_fov);
    case ONI_STREAM_PROPERTY_VERTICAL_FOV:
      return give(lens.vertical_fov);
    case ONI_STREAM_PROPERTY_STRIDE:
      return give(row_bytes());
    case ONI_STREAM_PROPERTY_MIRRORING:
      return give(OniBool{FALSE});
    // OpenNI2's player drops every frame of a recording that lacks this property.
    case ONI_STREAM_PROPERTY_CROPPING:
      return give(OniCropping{});
    case ONI_STREAM_PROPERTY_MAX_VALUE:
      return max_value_ > 0 ? give(max_value_) : ONI_STATUS_NOT_SUPPORTED;
    case ONI_STREAM_PROPERTY_MIN_VALUE:
      return max_value_ > 0 ? give(int{0}) : ONI_STATUS_NOT_SUPPORTED;
    case kIntrinsics:
      return lens.intrinsics ? give(*lens.intrinsics) : ONI_STATUS_NOT_SUPPORTED;
    default:
      return ONI_STATUS_NOT_SUPPORTED;
  }
}

OniStatus PushStream::setProperty(int property, const void* data, int size) {
  const OniStatus special = owner_.set_of(*this, property, data, size);
  if (special != ONI_STATUS_NOT_SUPPORTED) return special;
  if (property == ONI_STREAM_PROPERTY_MIRRORING) {
    const auto wanted = read_as<OniBool>(data, size);
    if (!wanted) return ONI_STATUS_BAD_PARAMETER;
    return *wanted ? ONI_STATUS_NOT_SUPPORTED : ONI_STATUS_OK;
  }
  if (property != ONI_STREAM_PROPERTY_VIDEO_MODE) return ONI_STATUS_NOT_SUPPORTED;
  const auto wanted = read_as<OniVideoMode>(data, size);
  if (!wanted) return ONI_STATUS_BAD_PARAMETER;
  const bool offered = std::any_of(modes_.begin(), modes_.end(),
                                   [&](const OniVideoMode& mode) { return same(mode, *wanted); });
  if (!offered) return ONI_STATUS_NOT_SUPPORTED;
  {
    const std::lock_guard lock(mutex_);
    if (running_) return ONI_STATUS_OUT_OF_FLOW;
    mode_ = *wanted;
  }
  return ONI_STATUS_OK;
}

}  // namespace copresence::drivers
