#include "simulation/remembered_views.h"

#include <gtest/gtest.h>

#include "simulation/hash_noise.h"

namespace copresence::simulation {
namespace {

constexpr int kWidth = 61, kHeight = 17;

// The still view with some of its pixels changed, in runs that begin and end anywhere.
SensedView changed(const SensedView& still, std::uint32_t seed) {
  SensedView view = still;
  for (std::uint32_t i = 0; i < kWidth * kHeight; ++i) {
    const float value = unit(hash(seed, i));
    if (hash(seed, i / 13, 1) % 3 == 0) view.dots.data()[i] = {value, 1 - value};
    if (hash(seed, i / 7, 2) % 4 == 0) view.colors.data()[i].g = static_cast<std::int16_t>(1000 * value);
  }
  return view;
}

void expect_same(const SensedView& a, const SensedView& b) {
  EXPECT_EQ(a.dots, b.dots);
  EXPECT_EQ(a.colors, b.colors);
}

TEST(RememberedViews, ShowsEachAsItWasInWhateverOrder) {
  const SensedView still{DotImage(kWidth, kHeight, {300, 0.5f}),
                         SensedColors(kWidth, kHeight, {100, 200, 300})};
  std::vector<SensedView> views{still};
  for (std::uint32_t seed = 1; seed < 6; ++seed) views.push_back(changed(still, seed));
  RememberedViews remembered(views.size(), still);
  for (std::size_t i = 0; i < views.size(); ++i) {
    EXPECT_FALSE(remembered.knows(i));
    remembered.remember(i, views[i]);
    EXPECT_TRUE(remembered.knows(i));
  }
  for (const std::size_t index : {1u, 2u, 2u, 5u, 0u, 3u, 4u, 1u, 5u})
    expect_same(remembered.show(index), views[index]);
}

TEST(RememberedViews, ForgetsWhatItIsToldAnew) {
  const SensedView still{DotImage(kWidth, kHeight), SensedColors(kWidth, kHeight)};
  RememberedViews remembered(2, still);
  remembered.remember(0, changed(still, 1));
  remembered.remember(1, changed(still, 2));
  expect_same(remembered.show(0), changed(still, 1));
  remembered.remember(0, changed(still, 3));
  expect_same(remembered.show(0), changed(still, 3));
  expect_same(remembered.show(1), changed(still, 2));
}

}  // namespace
}  // namespace copresence::simulation
