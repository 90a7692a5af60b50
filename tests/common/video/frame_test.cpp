#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "common/bitstream/access_unit.h"
#include "common/video/frame_decoder.h"
#include "common/video/frame_encoder.h"
#include "tests/common/video/moving_scene.h"

namespace copresence::video {
namespace {

/// A stream of frames coded without loss, and a decoder for it.
class Frames : public testing::Test {
 protected:
  EncodedFrame encoded(std::uint64_t sequence, bool keyframe = false) {
    return encoder.encode(moving_frame(stream, sequence, keyframe)).value();
  }

  const StreamDescription stream = small_stream(PixelFormat::kGray10, true);
  FrameEncoder encoder = FrameEncoder::open(stream, {.depth_qp = 0}).value();
  FrameDecoder decoder = FrameDecoder::open(stream).value();
};

TEST_F(Frames, ComeBackOneForOneWithEverythingThatMustBeExact) {
  for (std::uint64_t sequence = 1; sequence <= 60; ++sequence) {
    PlanarFrame frame = moving_frame(stream, sequence, sequence % 25 == 1);
    if (sequence >= 30) frame.metadata.world_from_camera.translation.x() = 0.1 * double(sequence / 10);
    const auto coded = encoder.encode(frame);
    ASSERT_TRUE(coded);
    EXPECT_EQ(coded->keyframe, frame.depth.keyframe);
    EXPECT_EQ(coded->sequence, sequence);
    const auto back = decoder.decode(*coded);
    ASSERT_TRUE(back) << back.error().what;
    EXPECT_EQ(back->metadata, frame.metadata);
    EXPECT_EQ(back->depth.keyframe, frame.depth.keyframe);
    EXPECT_EQ(back->depth.picture, frame.depth.picture);
    EXPECT_EQ(back->depth.validity_mask, frame.depth.validity_mask);
    EXPECT_EQ(back->depth.table, frame.depth.table);
    ASSERT_TRUE(back->color);
    EXPECT_EQ(back->color->format(), PixelFormat::kYuv420);
  }
}

TEST_F(Frames, CarrySamplesInsteadOfThePictureBetweenKeyframes) {
  for (std::uint64_t sequence = 1; sequence <= 40; ++sequence) {
    PlanarFrame frame = moving_frame(stream, sequence, sequence % 10 == 1);
    const bool exact = (sequence - 1) / 10 % 2 == 0;
    if (exact) {
      frame.depth.picture = Picture();
      frame.depth.residuals.assign(100 + sequence, static_cast<std::uint8_t>(sequence));
    }
    const auto back = decoder.decode(encoder.encode(frame).value());
    ASSERT_TRUE(back) << back.error().what;
    EXPECT_EQ(back->depth.residuals, frame.depth.residuals);
    EXPECT_EQ(back->depth.picture, frame.depth.picture);
    EXPECT_TRUE(back->color);
  }
}

TEST_F(Frames, GoOnAtAnotherQpOrARateFromAKeyframeOn) {
  std::uint64_t sequence = 1;
  ASSERT_TRUE(decoder.decode(encoded(sequence, true)));
  for (const VideoSettings& settings :
       {VideoSettings{.depth_qp = 30}, VideoSettings{.depth_kbps = 400}, VideoSettings{.depth_qp = 0}}) {
    EXPECT_TRUE(encoder.change(settings).value());
    for (int i = 0; i < 5; ++i) {
      const PlanarFrame frame = moving_frame(stream, ++sequence, i == 0);
      const auto back = decoder.decode(encoder.encode(frame).value());
      ASSERT_TRUE(back) << back.error().what;
      EXPECT_EQ(back->depth.picture == frame.depth.picture, settings.depth_qp == 0 && !settings.depth_kbps);
    }
  }
  EXPECT_FALSE(
      encoder.change({.depth_qp = 0, .color_kbps = 100}).value());  // a new colour rate needs no keyframe
  EXPECT_TRUE(decoder.decode(encoded(++sequence)));
  EXPECT_FALSE(encoder.change({.depth_qp = 99}));
  EXPECT_TRUE(decoder.decode(encoded(++sequence)));
}

TEST_F(Frames, WithSamplesAreRefusedDamagedOrAfterALoss) {
  std::vector<EncodedFrame> frames;
  for (std::uint64_t sequence = 1; sequence <= 4; ++sequence) {
    PlanarFrame frame = moving_frame(stream, sequence, sequence == 1);
    frame.depth.picture = Picture();
    frame.depth.residuals = {1, 2, 3};
    frames.push_back(encoder.encode(frame).value());
  }
  ASSERT_TRUE(decoder.decode(frames[0]));
  EXPECT_FALSE(decoder.decode(frames[2]));
  EXPECT_FALSE(decoder.decode(frames[3]));
  for (std::size_t byte = 0; byte < frames[1].depth.size(); ++byte) {
    ASSERT_TRUE(decoder.decode(frames[0]));
    EncodedFrame damaged = frames[1];
    damaged.depth[byte] ^= 4;
    EXPECT_FALSE(decoder.decode(damaged)) << byte;
  }
}

TEST_F(Frames, MayLackColorNowAndThenEvenInAKeyframe) {
  for (std::uint64_t sequence = 1; sequence <= 12; ++sequence) {
    PlanarFrame frame = moving_frame(stream, sequence, sequence % 6 == 1);
    const bool has_color = sequence % 3 != 1;
    if (!has_color) frame.color.reset();
    const auto back = decoder.decode(encoder.encode(frame).value());
    ASSERT_TRUE(back) << back.error().what;
    EXPECT_EQ(back->color.has_value(), has_color);
  }
}

TEST_F(Frames, AreTheSameWhenTheirColorWasEncodedAhead) {
  FrameEncoder ahead = FrameEncoder::open(stream, {.depth_qp = 0}).value();
  for (std::uint64_t sequence = 1; sequence <= 12; ++sequence) {
    const PlanarFrame frame = moving_frame(stream, sequence, sequence % 6 == 1);
    ahead.encode_color_ahead(sequence, *frame.color, frame.depth.keyframe);
    const EncodedFrame one = ahead.encode(frame).value(), other = encoder.encode(frame).value();
    EXPECT_EQ(one.depth, other.depth);
    EXPECT_EQ(one.color, other.color);
  }
}

TEST_F(Frames, MayBecomeKeyframesAfterTheirColorWasEncodedAhead) {
  // This happens when a depth codec makes a keyframe with new level spacing.
  for (std::uint64_t sequence = 1; sequence <= 12; ++sequence) {
    const PlanarFrame frame = moving_frame(stream, sequence, sequence % 4 == 1);
    encoder.encode_color_ahead(sequence, *frame.color, false);
    const auto back = decoder.decode(encoder.encode(frame).value());
    ASSERT_TRUE(back) << sequence << ": " << back.error().what;
    EXPECT_TRUE(back->color);
  }
}

TEST_F(Frames, TakeTheirColorWithThemWhenTheyComeToNothing) {
  ASSERT_TRUE(decoder.decode(encoded(1, true)));
  encoder.encode_color_ahead(2, *moving_frame(stream, 2, false).color,
                             false);  // the frame's depth fails to encode
  const auto back = decoder.decode(encoded(3, true));
  ASSERT_TRUE(back) << back.error().what;
  EXPECT_TRUE(back->color);
  EXPECT_TRUE(decoder.decode(encoded(4)));
}

TEST_F(Frames, AreRefusedAfterALossUntilAKeyframe) {
  ASSERT_TRUE(decoder.decode(encoded(1, true)));
  ASSERT_TRUE(decoder.decode(encoded(2)));
  encoded(3);  // lost
  const auto refused = decoder.decode(encoded(4));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kCorrupt);
  EXPECT_THAT(refused.error().what, testing::HasSubstr("frame 4 builds on frame 3"));
  EXPECT_FALSE(decoder.decode(encoded(5)));
  EXPECT_TRUE(decoder.decode(encoded(6, true)));
  EXPECT_TRUE(decoder.decode(encoded(7)));
}

TEST_F(Frames, AreRefusedOutOfOrderOrTwiceUntilAKeyframe) {
  const EncodedFrame first = encoded(1, true), second = encoded(2), third = encoded(3), fourth = encoded(4);
  ASSERT_TRUE(decoder.decode(first));
  EXPECT_FALSE(decoder.decode(third));
  EXPECT_FALSE(decoder.decode(second));
  EXPECT_FALSE(decoder.decode(fourth));
  ASSERT_TRUE(decoder.decode(first));
  ASSERT_TRUE(decoder.decode(second));
  EXPECT_FALSE(decoder.decode(second));
  EXPECT_FALSE(decoder.decode(third));
}

TEST_F(Frames, MayHaveGapsInTheirNumbersWhereTheCameraWasTooFast) {
  ASSERT_TRUE(decoder.decode(encoded(1, true)));
  ASSERT_TRUE(decoder.decode(encoded(7)));
  ASSERT_TRUE(decoder.decode(encoded(9)));
}

TEST_F(Frames, NeverPassDamaged) {
  const EncodedFrame keyframe = encoded(1, true), next = encoded(2);
  std::mt19937 random(7);
  for (int i = 0; i < 300; ++i) {
    ASSERT_TRUE(decoder.decode(keyframe));
    EncodedFrame damaged = next;
    auto& bytes = i % 2 ? damaged.color : damaged.depth;
    if (i % 3 == 0) {
      bytes.resize(random() % bytes.size());
    } else {
      bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1 << random() % 8);
    }
    EXPECT_FALSE(decoder.decode(damaged)) << i;
    EXPECT_FALSE(decoder.decode(next)) << "still unsure, " << i;
  }
}

TEST_F(Frames, NeverPassWithAnotherFramesColor) {
  const EncodedFrame keyframe = encoded(1, true);
  EncodedFrame second = encoded(2), third = encoded(3);
  ASSERT_TRUE(decoder.decode(keyframe));
  std::swap(second.color, third.color);
  EXPECT_FALSE(decoder.decode(second));
}

TEST_F(Frames, KeepEverythingThroughACopyOfTheStreamAsAnnexB) {
  std::vector<std::uint8_t> file;
  std::vector<EncodedFrame> frames;
  for (std::uint64_t sequence = 1; sequence <= 8; ++sequence) {
    frames.push_back(encoded(sequence, sequence == 1 || sequence == 5));
    file.insert(file.end(), frames.back().depth.begin(), frames.back().depth.end());
  }
  // An access unit ends with its slice, since a picture has one slice.
  std::vector<std::vector<std::uint8_t>> copies(1);
  const auto nals = bitstream::split_access_unit(file).value();
  for (const bitstream::Nal& nal : nals) {
    bitstream::append_nal(copies.back(), nal.bytes);
    if (nal.type() == bitstream::NalType::kSlice || nal.type() == bitstream::NalType::kIdrSlice)
      copies.emplace_back();
  }
  ASSERT_EQ(copies.size(), frames.size() + 1);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EncodedFrame copy;
    copy.depth = copies[i];
    copy.color = frames[i].color;
    const auto back = decoder.decode(copy);
    ASSERT_TRUE(back) << back.error().what;
    EXPECT_EQ(back->depth.picture, moving_frame(stream, i + 1, false).depth.picture);
  }
}

TEST_F(Frames, OfAnotherStreamAreRefused) {
  const EncodedFrame frame = encoded(1, true);
  StreamDescription other = stream;
  other.model = camera_from_field_of_view(128, 48, 1, 1);
  EXPECT_FALSE(FrameDecoder::open(other).value().decode(frame));
  other = stream;
  other.codec.format = PixelFormat::kGray8;
  EXPECT_FALSE(FrameDecoder::open(other).value().decode(frame));
  other = stream;
  other.has_color = false;
  EXPECT_FALSE(FrameDecoder::open(other).value().decode(frame));
}

TEST(FrameEncoder, RefusesSettingsOutOfRange) {
  const auto refused = FrameEncoder::open(small_stream(PixelFormat::kGray8, false), {.depth_qp = -3});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalid);
}

TEST(FrameDecoder, StandsGarbage) {
  FrameDecoder decoder = FrameDecoder::open(small_stream(PixelFormat::kGray10, true)).value();
  std::mt19937 random(9);
  for (int i = 0; i < 200; ++i) {
    EncodedFrame garbage;
    garbage.depth.resize(random() % 200);
    for (auto& byte : garbage.depth) byte = static_cast<std::uint8_t>(random() % 4 ? random() : random() % 2);
    garbage.color = garbage.depth;
    EXPECT_FALSE(decoder.decode(garbage));
  }
}

}  // namespace
}  // namespace copresence::video
