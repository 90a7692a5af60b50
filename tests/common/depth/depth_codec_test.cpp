#include "common/depth/depth_codec.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "tests/common/depth/scenes.h"
#include "tests/common/depth/stream_without_video.h"

namespace copresence::depth {
namespace {

using testing::flat_scene;
using ::testing::HasSubstr;
using testing::kinect_format;
using testing::kinect_scene;
using testing::Scene;
using testing::StreamWithoutVideo;

// Each codec's largest documented error at depth z without video coding, millimetres.
double bound_mm(std::string_view codec, double z) {
  const double inverse_range = 1 / 400.0 - 1 / 5000.0;
  if (codec == "quantized" || codec == "adaptive") return 0;
  if (codec == "accuracy8") return z * z * inverse_range / 510 * 1.02 + 0.5;
  if (codec == "accuracy10") return z * z * inverse_range / 2046 * 1.02 + 0.5;
  if (codec == "triangle" || codec == "direct") return 600.0 / 1020 + 1;
  return 4600.0 / 8191 / 2 + 0.5;  // spiral, away from edges
}

// The spread of a pixel's neighbours; -1 at an edge. If one chroma sample covers two upper parts,
// spiral in 4:2:0 only guarantees a value within this spread, and nothing at an edge.
int spread_mm(const Scene& scene, int x, int y) {
  int spread = 0;
  for (int ny = std::max(0, y - 3); ny < std::min(scene.depth.height(), y + 4); ++ny) {
    for (int nx = std::max(0, x - 3); nx < std::min(scene.depth.width(), x + 4); ++nx) {
      spread = std::max(spread, std::abs(scene.depth(nx, ny) - scene.depth(x, y)));
    }
  }
  return spread > 70 ? -1 : spread;
}

class EveryCodec : public ::testing::TestWithParam<std::string_view> {};
INSTANTIATE_TEST_SUITE_P(Codecs, EveryCodec, ::testing::ValuesIn(codec_names().begin(), codec_names().end()),
                         [](const auto& param) {
                           std::string name(param.param);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST_P(EveryCodec, BringsDepthBackWithinItsBoundAndStatesExactly) {
  StreamWithoutVideo stream(GetParam());
  for (int time = 0; time < 6; ++time) {
    const Scene scene = kinect_scene(160, 120, time);
    stream.carry(scene, time == 3);
    ASSERT_EQ(stream.state, scene.state);
    for (int y = 0; y < 120; ++y) {
      for (int x = 0; x < 160; ++x) {
        const int z = scene.depth(x, y), back = stream.depth(x, y);
        if (scene.state(x, y) == DepthState::kHole) {
          ASSERT_EQ(back, 0);
        } else if (scene.state(x, y) == DepthState::kMeasured) {
          const bool votes = stream.encoder.description().format == PixelFormat::kYuv420;
          const int spread = votes ? spread_mm(scene, x, y) : 0;
          if (spread < 0) continue;
          ASSERT_LE(std::abs(z - back), std::max<double>(bound_mm(GetParam(), z), spread))
              << z << " mm at " << x << ' ' << y << " frame " << time;
        }
      }
    }
  }
}

TEST_P(EveryCodec, KeepsHolesHolesAndDepthDepthWhateverVideoCodingDoesToThePicture) {
  StreamWithoutVideo stream(GetParam());
  stream.encoder.set_lossless(false);
  std::minstd_rand random(1);
  for (int time = 0; time < 3; ++time) {
    const Scene scene = kinect_scene(160, 120, time);
    PlanarDepth planes = stream.send(scene);
    for (int plane = 0; plane < planes.picture.planes(); ++plane) {
      if (planes.picture.format() == PixelFormat::kGray10) {
        for (auto& sample : planes.picture.plane10()) sample = static_cast<std::uint16_t>(random() % 65536);
      } else {
        for (auto& sample : planes.picture.plane8(plane)) sample = static_cast<std::uint8_t>(random() % 256);
      }
    }
    ASSERT_TRUE(stream.receive(planes));
    EXPECT_EQ(stream.state, scene.state);
    for (std::size_t i = 0; i < scene.depth.pixels().size(); ++i) {
      const int back = stream.depth.data()[i];
      ASSERT_EQ(back == 0, scene.state.data()[i] == DepthState::kHole);
      ASSERT_TRUE(back == 0 || (back >= 400 && back <= 5000)) << back;
    }
  }
}

TEST_P(EveryCodec, CountsDepthOutsideTheRangeAsHoles) {
  Scene scene = flat_scene(160, 120, 1000);
  const std::array<std::uint16_t, 6> values{1, 399, 400, 5000, 5001, 65535};
  for (std::size_t i = 0; i < values.size(); ++i) scene.depth(static_cast<int>(i) * 16, 60) = values[i];
  scene.depth(159, 119) = 0;  // measured, but without depth
  StreamWithoutVideo stream(GetParam());
  for (int time = 0; time < 2; ++time) {
    stream.carry(scene);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const bool inside = values[i] >= 400 && values[i] <= 5000;
      EXPECT_EQ(stream.state(static_cast<int>(i) * 16, 60),
                inside ? DepthState::kMeasured : DepthState::kHole);
      EXPECT_EQ(stream.depth(static_cast<int>(i) * 16, 60) != 0, inside);
    }
    EXPECT_EQ(stream.state(159, 119), DepthState::kHole);
  }
}

TEST_P(EveryCodec, TakesImagesOfNothingAndImagesWithoutHoles) {
  StreamWithoutVideo stream(GetParam());
  for (const int depth : {0, 1000, 0, 0, 5000, 400}) {
    const Scene scene = flat_scene(160, 120, static_cast<std::uint16_t>(depth));
    stream.carry(scene);
    EXPECT_EQ(stream.state, scene.state);
    EXPECT_EQ(stream.depth(80, 60) == 0, depth == 0);
  }
}

TEST_P(EveryCodec, TakesEveryValueThatSixteenBitsHold) {
  DepthFormat format = kinect_format(256, 256);
  format.range = {0.0001, 6.5535};
  format.unit = DepthUnit::k100Micrometres;
  Scene scene = flat_scene(256, 256, 1);
  for (std::size_t i = 0; i < scene.depth.pixels().size(); ++i) {
    scene.depth.data()[i] = static_cast<std::uint16_t>(i);
    if (i == 0) scene.state.data()[i] = DepthState::kHole;
  }
  StreamWithoutVideo stream(GetParam(), format);
  stream.encoder.set_lossless(false);
  stream.carry(scene);
  EXPECT_EQ(stream.state, scene.state);
  for (std::size_t i = 0; i < scene.depth.pixels().size(); ++i)
    ASSERT_EQ(stream.depth.data()[i] == 0, i == 0);
}

TEST_P(EveryCodec, KeepsItsGuaranteesWhenMaskTableAndResidualsAreDamaged) {
  const DepthFormat format = kinect_format(32, 16);
  StreamWithoutVideo stream(GetParam(), format);
  const PlanarDepth first = stream.send(kinect_scene(32, 16, 0));
  const PlanarDepth second = stream.send(kinect_scene(32, 16, 9));
  // Damaged bytes decode to depth within the range, or fail. After a failure every frame fails
  // until a keyframe.
  const auto holds = [&](const PlanarDepth& damaged, bool is_second) {
    if (is_second && !stream.receive(first)) return false;
    const auto received = stream.receive(damaged);
    if (!received) return received.error().code == ErrorCode::kCorrupt && !stream.receive(second);
    for (std::size_t i = 0; i < stream.depth.pixels().size(); ++i) {
      const bool hole = stream.state.data()[i] == DepthState::kHole;
      if (hole != (stream.depth.data()[i] == 0)) return false;
      if (!hole && !format.units().contains(stream.depth.data()[i])) return false;
    }
    return true;
  };
  for (const PlanarDepth* frame : {&first, &second}) {
    for (auto bytes : {&PlanarDepth::validity_mask, &PlanarDepth::table, &PlanarDepth::residuals}) {
      const std::size_t size = (frame->*bytes).size();
      for (std::size_t i = 0; i < size; ++i) {
        for (int bit = 0; bit < 8; ++bit) {
          PlanarDepth damaged = *frame;
          (damaged.*bytes)[i] ^= static_cast<std::uint8_t>(1 << bit);
          ASSERT_TRUE(holds(damaged, frame == &second)) << "byte " << i << " bit " << bit;
        }
        PlanarDepth shortened = *frame;
        (shortened.*bytes).resize(i);
        ASSERT_TRUE(holds(shortened, frame == &second)) << "cut at " << i;
      }
      PlanarDepth lengthened = *frame;
      (lengthened.*bytes).push_back(0);
      ASSERT_TRUE(holds(lengthened, frame == &second));
    }
  }
  EXPECT_TRUE(stream.receive(first));
}

TEST_P(EveryCodec, FailsAfterAFailureUpToTheNextKeyframe) {
  StreamWithoutVideo stream(GetParam());
  std::vector<PlanarDepth> sent;
  for (int time = 0; time < 4; ++time) sent.push_back(stream.send(kinect_scene(160, 120, time), time == 3));
  EXPECT_FALSE(stream.receive(sent[1])) << "begins without a keyframe";
  EXPECT_TRUE(stream.receive(sent[0]));
  PlanarDepth without_mask = sent[1];
  without_mask.validity_mask.clear();
  EXPECT_FALSE(stream.receive(without_mask));
  EXPECT_FALSE(stream.receive(sent[1])) << "only a keyframe helps";
  EXPECT_FALSE(stream.receive(sent[2]));
  EXPECT_TRUE(stream.receive(sent[3]));
}

TEST_P(EveryCodec, FailsOnAPictureOfAnotherShapeOrFormat) {
  StreamWithoutVideo stream(GetParam());
  stream.encoder.set_lossless(false);
  const Scene scene = kinect_scene(160, 120);
  for (const Picture& wrong :
       {Picture(), Picture(stream.encoder.description().format, 160, 118),
        Picture(stream.encoder.description().format == PixelFormat::kGray8 ? PixelFormat::kGray10
                                                                           : PixelFormat::kGray8,
                160, 120)}) {
    PlanarDepth planes = stream.send(scene, true);
    planes.picture = wrong;
    EXPECT_FALSE(stream.receive(planes));
  }
}

TEST_P(EveryCodec, KeyframesNeedNothingOfEarlierFrames) {
  StreamWithoutVideo stream(GetParam());
  for (int time = 0; time < 3; ++time) stream.send(kinect_scene(160, 120, time));
  const Scene scene = kinect_scene(160, 120, 3);
  const PlanarDepth key = stream.send(scene, true);
  EXPECT_TRUE(key.keyframe);
  ASSERT_TRUE(stream.receive(key));
  EXPECT_EQ(stream.state, scene.state);
}

TEST_P(EveryCodec, GoesFromLossToNoneAndBackWithAKeyframe) {
  StreamWithoutVideo stream(GetParam());
  const bool gray = stream.send(kinect_scene(160, 120), true).residuals.size() > 0;
  for (int time = 0; time < 12; ++time) {
    const bool lossless = time / 3 % 2 == 0;
    stream.encoder.set_lossless(lossless);
    const Scene scene = kinect_scene(160, 120, time);
    const PlanarDepth planes = stream.send(scene);
    EXPECT_EQ(planes.keyframe, time > 0 && time % 3 == 0) << time;
    EXPECT_EQ(planes.residuals.empty(), !(lossless && gray)) << time;
    EXPECT_EQ(planes.picture.empty(), !planes.residuals.empty());
    if (time < 3) continue;  // these frames need one that was not sent
    ASSERT_TRUE(stream.receive(planes)) << time;
    EXPECT_EQ(stream.state, scene.state);
  }
}

TEST_P(EveryCodec, RefusesResidualsWithAPictureAndAPictureWithResiduals) {
  StreamWithoutVideo stream(GetParam());
  PlanarDepth planes = stream.send(kinect_scene(160, 120));
  const bool gray = !planes.residuals.empty();
  if (gray) {
    std::swap(planes.residuals, planes.table);
  } else {
    planes.residuals = {1, 2, 3};
  }
  EXPECT_FALSE(stream.receive(planes));
}

TEST(DepthCodec, NamesTheKnownCodecsWhereItDoesNotKnowOne) {
  const auto opened = Encoder::open("h265", kinect_format());
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kInvalid);
  for (const std::string_view name : codec_names())
    EXPECT_THAT(opened.error().what, HasSubstr(std::string(name)));
  EXPECT_FALSE(Decoder::open({"h265", PixelFormat::kGray8, {}}, kinect_format()));
}

TEST(DepthCodec, TakesAPeriodWhereTheCodecHasOne) {
  const auto opened = Encoder::open("triangle:period=0.8", kinect_format());
  ASSERT_TRUE(opened);
  EXPECT_EQ(opened->description().name, "triangle");
  EXPECT_EQ(opened->description().parameters.back(), (std::pair<std::string, double>("period", 800)));
  for (const std::string_view wrong :
       {"triangle:", "triangle:period=", "triangle:period=x", "triangle:period=0.8m", "triangle:period=0.01",
        "triangle:period=9", "triangle:period=nan", "direct:phase=1", "quantized:period=0.8", "quantized:"}) {
    const auto refused = Encoder::open(wrong, kinect_format());
    ASSERT_FALSE(refused) << wrong;
    EXPECT_EQ(refused.error().code, ErrorCode::kInvalid);
  }
}

TEST(DepthCodec, RefusesShapesAndRangesThatCannotBe) {
  for (auto spoil : std::initializer_list<void (*)(DepthFormat&)>{
           [](DepthFormat& f) { f.width = 0; }, [](DepthFormat& f) { f.width = 161; },
           [](DepthFormat& f) { f.height = 8192; }, [](DepthFormat& f) { f.unit = DepthUnit{7}; },
           [](DepthFormat& f) {
             f.range = {5, 0.4};
           },
           [](DepthFormat& f) {
             f.range = {0, 1};
           },
           [](DepthFormat& f) {
             f.range = {std::nan(""), 1};
           },
           [](DepthFormat& f) {
             f.range = {70, 80};
           }}) {
    DepthFormat format = kinect_format();
    spoil(format);
    EXPECT_FALSE(Encoder::open("quantized", format));
    EXPECT_FALSE(Decoder::open({"quantized", PixelFormat::kGray10, {}}, format));
  }
}

TEST(DepthCodec, RefusesDescriptionsThatMakeNoSense) {
  for (const std::string_view name : codec_names()) {
    const DepthCodecDescription good = Encoder::open(name, kinect_format())->description();
    ASSERT_TRUE(Decoder::open(good, kinect_format()));
    DepthCodecDescription bad = good;
    bad.format = good.format == PixelFormat::kGray8 ? PixelFormat::kYuv420 : PixelFormat::kGray8;
    EXPECT_FALSE(Decoder::open(bad, kinect_format())) << name;
    for (std::size_t i = 0; i < good.parameters.size(); ++i) {
      for (const double value : {std::nan(""), -1.0, 1e300, std::numeric_limits<double>::infinity()}) {
        bad = good;
        bad.parameters[i].second = value;
        EXPECT_FALSE(Decoder::open(bad, kinect_format()))
            << name << ' ' << good.parameters[i].first << ' ' << value;
      }
      bad = good;
      bad.parameters.erase(bad.parameters.begin() + static_cast<std::ptrdiff_t>(i));
      EXPECT_FALSE(Decoder::open(bad, kinect_format())) << name << " without " << good.parameters[i].first;
    }
  }
}

}  // namespace
}  // namespace copresence::depth
