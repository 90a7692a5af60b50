#pragma once

// A stream of small coded frames for tests of recordings.

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "common/video/frame_encoder.h"
#include "tests/common/video/moving_scene.h"

namespace copresence::session {

class CodedStream {
 public:
  explicit CodedStream(const std::string& camera, bool has_color = true)
      : CodedStream(describe(camera, has_color)) {}

  const std::shared_ptr<const StreamDescription>& description() const { return description_; }

  /// Returns the next frame.
  EncodedFrame next(bool keyframe) {
    ++sequence_;
    auto frame = encoder_.encode(video::moving_frame(*description_, sequence_, keyframe || sequence_ == 1));
    EXPECT_TRUE(frame);
    return std::move(*frame);
  }

 private:
  explicit CodedStream(const StreamDescription& description)
      : description_(std::make_shared<const StreamDescription>(description)),
        encoder_(std::move(*video::FrameEncoder::open(description, {}))) {}

  static StreamDescription describe(const std::string& camera, bool has_color) {
    StreamDescription stream = video::small_stream(PixelFormat::kGray10, has_color);
    stream.camera = camera;
    return stream;
  }

  std::shared_ptr<const StreamDescription> description_;
  video::FrameEncoder encoder_;
  std::uint64_t sequence_ = 0;
};

}  // namespace copresence::session
