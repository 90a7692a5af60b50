#include "simulation/scene/noise.h"

#include <gtest/gtest.h>

namespace copresence::simulation {
namespace {

TEST(BlobNoise, HasMeanZeroDeviationOneAndBlobsOfItsCell) {
  for (const int cell : {2, 3, 5, 8, 48}) {
    Image<float> noise(640, 480);
    fill_blob_noise(cell, 17, noise);
    double sum = 0, squares = 0, beside = 0, apart = 0;
    for (int y = 0; y < 480; ++y) {
      for (int x = 0; x < 640 - 2 * cell; ++x) {
        const double value = noise(x, y);
        sum += value;
        squares += value * value;
        beside += value * noise(x + 1, y);
        apart += value * noise(x + 2 * cell, y);
      }
    }
    const double count = 480.0 * (640 - 2 * cell), allowed = cell > 20 ? 0.25 : 0.05;
    EXPECT_NEAR(sum / count, 0, allowed) << cell;
    EXPECT_NEAR(squares / count, 1, allowed) << cell;
    EXPECT_GT(beside / squares, cell > 2 ? 0.6 : 0.3) << cell;
    EXPECT_NEAR(apart / squares, 0, allowed) << cell;
  }
}

}  // namespace
}  // namespace copresence::simulation
