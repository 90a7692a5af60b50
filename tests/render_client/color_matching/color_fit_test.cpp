#include "render_client/color_matching/color_fit.h"

#include <gtest/gtest.h>

#include <random>

namespace copresence::color_matching {
namespace {

// Two Kinects differ about this much. The channels are mixed a little.
ColorCorrection kinect_like_map() {
  ColorCorrection map;
  map << 0.88F, 0.04F, 0.02F, 0.03F,  //
      0.03F, 1.08F, -0.02F, -0.02F,   //
      -0.02F, 0.05F, 1.15F, 0.01F;
  return map;
}

// Typical colours of a room, mostly near grey. The fraction `wrong` of the pairs do not match.
std::vector<ColorPair> pairs_of(const ColorCorrection& map, std::size_t count, double wrong, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0, 1);
  std::normal_distribution<float> tint(0, 0.06F), noise(0, 2.0F / 255);
  std::vector<ColorPair> pairs;
  while (pairs.size() < count) {
    const float grey = 0.15F + 0.6F * unit(random);
    Eigen::Vector3f from(grey + tint(random), grey + tint(random), grey + tint(random));
    Eigen::Vector3f to = apply(map, from) + Eigen::Vector3f(noise(random), noise(random), noise(random));
    if (unit(random) < wrong) to = Eigen::Vector3f(unit(random), unit(random), unit(random));
    pairs.push_back({from, to});
  }
  return pairs;
}

// Greatest error of a channel over typical colours of a room, of 255.
float worst_error(const ColorCorrection& found, const ColorCorrection& truth) {
  float worst = 0;
  for (const ColorPair& pair : pairs_of(truth, 500, 0, 99)) {
    worst = std::max(worst, (apply(found, pair.from) - apply(truth, pair.from)).cwiseAbs().maxCoeff());
  }
  return 255 * worst;
}

TEST(ColorFit, RecoversAnAffineChangeFromPairsOfWhichThreeInTenAreWrong) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto fit = fit_color_correction(pairs_of(kinect_like_map(), 2000, 0.3, seed));
    ASSERT_TRUE(fit);
    EXPECT_LT(worst_error(fit->correction, kinect_like_map()), 3.0F) << "seed " << seed;
  }
}

TEST(ColorFit, KeepsTheColoursWhereBothCamerasAgree) {
  const auto fit = fit_color_correction(pairs_of(ColorCorrection::Identity(), 2000, 0.2, 1));
  ASSERT_TRUE(fit);
  EXPECT_LT(worst_error(fit->correction, ColorCorrection::Identity()), 1.5F);
}

TEST(ColorFit, IsNotLedAstrayByAPersonOfOneColour) {
  // A third of the pairs come from a shirt that moved between the two exposures: all equal and all
  // wrong.
  auto pairs = pairs_of(kinect_like_map(), 1400, 0, 3);
  for (int i = 0; i < 600; ++i) pairs.push_back({{0.7F, 0.2F, 0.2F}, {0.3F, 0.35F, 0.5F}});
  const auto fit = fit_color_correction(pairs);
  ASSERT_TRUE(fit);
  EXPECT_LT(worst_error(fit->correction, kinect_like_map()), 3.0F);
}

TEST(ColorFit, LeavesColoursThatARoomDoesNotShowNearGainAndOffset) {
  // A grey room gives no information about red alone. The twelve numbers must stay near the guess.
  std::vector<ColorPair> pairs;
  std::mt19937 random(4);
  std::normal_distribution<float> noise(0, 2.0F / 255);
  for (int i = 0; i < 1000; ++i) {
    const float grey = 0.1F + 0.8F * static_cast<float>(i) / 1000;
    pairs.push_back(
        {Eigen::Vector3f::Constant(grey),
         Eigen::Vector3f(0.9F * grey + noise(random), grey + noise(random), 1.1F * grey + noise(random))});
  }
  const auto fit = fit_color_correction(pairs);
  ASSERT_TRUE(fit);
  const Eigen::Vector3f red = apply(fit->correction, {0.8F, 0.1F, 0.1F});
  EXPECT_NEAR(red.x(), 0.72F, 0.05F);
  EXPECT_NEAR(red.y(), 0.1F, 0.05F);
  EXPECT_NEAR(red.z(), 0.11F, 0.05F);
}

TEST(ColorFit, SaysNothingOfTooFewPairsOrOfChance) {
  EXPECT_FALSE(fit_color_correction(pairs_of(kinect_like_map(), kFewestPairs - 1, 0, 5)));
  EXPECT_FALSE(fit_color_correction(pairs_of(kinect_like_map(), 2000, 0.95, 6)));
}

TEST(ColorFit, GivesTheSameMapForTheSamePairs) {
  const auto pairs = pairs_of(kinect_like_map(), 1500, 0.3, 7);
  EXPECT_EQ(fit_color_correction(pairs)->correction, fit_color_correction(pairs)->correction);
}

}  // namespace
}  // namespace copresence::color_matching
