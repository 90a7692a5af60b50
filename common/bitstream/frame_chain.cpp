#include "common/bitstream/frame_chain.h"

#include <string>
#include <utility>

#include "common/bitstream/side_data.h"

namespace copresence::bitstream {

FrameChain::FrameChain(const StreamDescription& stream)
    : has_color_(stream.has_color), world_from_camera_(stream.world_from_camera) {}

Result<PlanarFrame> FrameChain::next(const EncodedFrame& encoded) {
  auto frame = next_checked(encoded);
  if (frame) {
    previous_ = frame->metadata.sequence;
  } else {
    previous_.reset();
  }
  return frame;
}

Result<PlanarFrame> FrameChain::next_checked(const EncodedFrame& encoded) {
  auto data = extract_side_data(encoded.depth, encoded.color);
  if (!data) return fail(data.error());
  const bool keyframe = data->previous == 0;
  if (!keyframe && previous_ != data->previous) {
    const std::string frame = "frame " + std::to_string(data->sequence);
    return fail(ErrorCode::kCorrupt, previous_
                                         ? frame + " builds on frame " + std::to_string(data->previous) +
                                               ", but the last one here is " + std::to_string(*previous_) +
                                               ": a keyframe is needed"
                                         : frame + " builds on frames that were lost: a keyframe is needed");
  }
  if (data->has_color && !has_color_)
    return fail(ErrorCode::kCorrupt, "a frame brings colour that its stream did not announce");
  if (data->world_from_camera) world_from_camera_ = *data->world_from_camera;
  PlanarFrame frame;
  frame.metadata.sequence = data->sequence;
  frame.metadata.captured_at = data->captured_at;
  frame.metadata.world_from_camera = world_from_camera_;
  frame.depth.keyframe = keyframe;
  frame.depth.qp = data->qp;
  frame.depth.residuals = std::move(data->residuals);
  frame.depth.validity_mask = std::move(data->validity_mask);
  frame.depth.table = std::move(data->table);
  frame.durations = encoded.durations;
  return frame;
}

}  // namespace copresence::bitstream
