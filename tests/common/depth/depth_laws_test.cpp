// Properties of depth coding for random images (RapidCheck). States and lossless samples are
// decoded exactly, a codebook change turns one codebook into the other, and every codec satisfies
// the guarantees of depth_codec.h.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <set>

#include "common/depth/depth_codec.h"
#include "common/depth/entropy/residual_coder.h"
#include "common/depth/levels/codebook.h"
#include "common/depth/mask/validity_mask.h"

namespace copresence::depth {
namespace {

struct Shape {
  int width, height;
};

Shape any_shape() {
  return {2 * *rc::gen::inRange(1, 50), 2 * *rc::gen::inRange(1, 12)};
}

// Paints overlapping rectangles of one value each. They give surfaces, holes, edges and single
// pixels.
template <class Pixel>
void paint(Image<Pixel>& image, const rc::Gen<Pixel>& any_value) {
  const int rectangles = *rc::gen::inRange(0, 8);
  for (int i = 0; i < rectangles; ++i) {
    const int left = *rc::gen::inRange(0, image.width()), top = *rc::gen::inRange(0, image.height());
    const int right = *rc::gen::inRange(left, image.width()) + 1,
              bottom = *rc::gen::inRange(top, image.height()) + 1;
    const Pixel value = *any_value;
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x) image(x, y) = value;
    }
  }
}

StateImage any_states(Shape shape) {
  StateImage states(shape.width, shape.height, DepthState::kMeasured);
  paint(states, rc::gen::element(DepthState::kHole, DepthState::kMeasured, DepthState::kFilled));
  return states;
}

DepthImage any_depth(Shape shape) {
  DepthImage depth(shape.width, shape.height, 1000);
  paint(depth, rc::gen::oneOf(rc::gen::inRange<std::uint16_t>(0, 6000), rc::gen::arbitrary<std::uint16_t>()));
  return depth;
}

RC_GTEST_PROP(DepthLaws, StatesComeBackAsTheyWere, ()) {
  const Shape shape = any_shape();
  ValidityMaskEncoder encoder(shape.width, shape.height);
  ValidityMaskDecoder decoder(shape.width, shape.height);
  for (int frame = 0; frame < 4; ++frame) {
    const bool complete = frame == 0 || *rc::gen::arbitrary<bool>();
    const StateImage states = any_states(shape);
    std::vector<std::uint8_t> bytes;
    encoder.encode(states, complete, bytes);
    StateImage back;
    decoder.decode(bytes, complete, back);
    RC_ASSERT(back == states);
  }
}

RC_GTEST_PROP(DepthLaws, SamplesComeBackAsTheyWere, ()) {
  const Shape shape = any_shape();
  ResidualEncoder encoder(PixelFormat::kGray10, shape.width, shape.height);
  ResidualDecoder decoder(PixelFormat::kGray10, shape.width, shape.height);
  Picture back;
  for (int frame = 0; frame < 4; ++frame) {
    const bool complete = frame == 0 || *rc::gen::arbitrary<bool>();
    const StateImage states = any_states(shape);
    DepthImage samples(shape.width, shape.height, 0);
    paint(samples, rc::gen::inRange<std::uint16_t>(0, 1024));
    Picture picture(PixelFormat::kGray10, shape.width, shape.height);
    std::copy(samples.pixels().begin(), samples.pixels().end(), picture.plane10().begin());
    std::vector<std::uint8_t> bytes;
    encoder.encode(picture, states, complete, bytes);
    decoder.decode(bytes, states, complete, back);
    for (std::size_t i = 0; i < samples.pixels().size(); ++i) {
      if (states.data()[i] != DepthState::kHole) RC_ASSERT(back.plane10()[i] == picture.plane10()[i]);
    }
  }
}

RC_GTEST_PROP(DepthLaws, ATableChangeTurnsOneTableIntoTheOther, ()) {
  const DepthRangeUnits range{400, 5000};
  Codebook here(range, DepthUnit::kMillimetre, kKinectV1Noise), there = here;
  std::set<std::uint16_t> known;
  for (int change = 0; change < 6; ++change) {
    const Codebook earlier = here;
    const int levels = *rc::gen::inRange(0, 30);
    for (int i = 0; i < levels; ++i) {
      const auto level = *rc::gen::inRange<std::uint16_t>(400, 5001);
      if (known.insert(level).second) RC_ASSERT(here.insert(level));
    }
    std::vector<std::uint8_t> bytes;
    here.write_change(earlier, bytes);
    RC_ASSERT(there.read_change(bytes).has_value());
    RC_ASSERT(std::equal(here.levels().begin(), here.levels().end(), there.levels().begin()));
    RC_ASSERT(here.count() == static_cast<int>(known.size()));
  }
}

RC_GTEST_PROP(DepthLaws, EveryCodecKeepsItsPromisesFromFrameToFrame, ()) {
  const Shape shape = any_shape();
  const DepthFormat format{shape.width, shape.height, DepthUnit::kMillimetre, {}};
  const DepthRangeUnits range = format.units();
  const auto names = codec_names();
  const std::string_view name = names[*rc::gen::inRange<std::size_t>(0, names.size())];
  Encoder encoder = *Encoder::open(name, format);
  Decoder decoder = *Decoder::open(encoder.description(), format);
  const bool lossless = *rc::gen::arbitrary<bool>();
  encoder.set_lossless(lossless);
  for (int frame = 0; frame < 3; ++frame) {
    const DepthImage depth = any_depth(shape);
    const StateImage states = any_states(shape);
    const auto planes = encoder.encode(depth, states, *rc::gen::arbitrary<bool>());
    RC_ASSERT(planes.has_value());
    DepthImage back;
    StateImage states_back;
    RC_ASSERT(decoder.decode(*planes, back, states_back).has_value());
    const bool exact = name == "quantized" || name == "adaptive";
    for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
      const bool seen = states.data()[i] != DepthState::kHole && range.contains(depth.data()[i]);
      RC_ASSERT(states_back.data()[i] == (seen ? states.data()[i] : DepthState::kHole));
      RC_ASSERT((back.data()[i] != 0) == seen);
      RC_ASSERT(!seen || range.contains(back.data()[i]));
      if (exact && seen && states.data()[i] == DepthState::kMeasured)
        RC_ASSERT(back.data()[i] == depth.data()[i]);
    }
  }
}

}  // namespace
}  // namespace copresence::depth
