#include "web_gateway/forwarding/frame_group.h"

#include <gtest/gtest.h>

#include "tests/web_gateway/forwarding/made_frames.h"

namespace copresence::forwarding {
namespace {

TEST(ForwardedFrame, BeginsWithTheCameraAndTheWiresHead) {
  const SharedFrame frame = made_frame(9, true, 20);
  EXPECT_EQ(frame->prefix[0], 7);
  const std::span<const std::uint8_t> message(frame->prefix);
  const auto header = wire::decode_header(message.subspan<1, wire::kHeaderBytes>());
  ASSERT_TRUE(header);
  EXPECT_EQ(header->body_bytes, wire::kFrameHeadBytes + 20 + 3);
  const auto head = wire::decode_frame_head(message.subspan<1 + wire::kHeaderBytes, wire::kFrameHeadBytes>(),
                                            header->body_bytes);
  ASSERT_TRUE(head);
  EXPECT_EQ(head->sequence, 9u);
  EXPECT_TRUE(head->keyframe);
  EXPECT_EQ(head->sent_at, Instant{} + 50s);
  EXPECT_EQ(frame->bytes(), frame->prefix.size() + 20 + 3);
}

TEST(FrameGroup, BeginsWithTheNewestKeyframe) {
  FrameGroup group;
  group.add(made_frame(1, false));
  EXPECT_TRUE(group.frames().empty()) << "a frame that cannot be decoded alone";
  group.add(made_frame(2, true));
  group.add(made_frame(3, false));
  EXPECT_EQ(group.frames().size(), 2u);
  group.add(made_frame(4, true));
  ASSERT_EQ(group.frames().size(), 1u);
  EXPECT_EQ(group.frames().front()->frame.sequence, 4u);
}

TEST(FrameGroup, IsDroppedRatherThanLargerThanItsLimit) {
  FrameGroup group;
  group.add(made_frame(1, true, FrameGroup::kMostBytes / 2));
  group.add(made_frame(2, false, FrameGroup::kMostBytes / 2 - 1000));
  EXPECT_EQ(group.frames().size(), 2u);
  group.add(made_frame(3, false));
  EXPECT_TRUE(group.frames().empty());
  group.add(made_frame(4, false));
  EXPECT_TRUE(group.frames().empty()) << "the frames since the keyframe are not complete any more";
  group.add(made_frame(5, true));
  EXPECT_EQ(group.frames().size(), 1u);
}

}  // namespace
}  // namespace copresence::forwarding
