#include "simulation/sensor/color_response.h"

#include <gtest/gtest.h>

namespace copresence::simulation {
namespace {

Eigen::Vector3d mean_of(const ColorImage& image) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Rgb8& pixel : image.pixels()) sum += Eigen::Vector3d(pixel.r, pixel.g, pixel.b);
  return sum / static_cast<double>(image.pixels().size());
}

ColorImage exposed(const ColorResponse& response, const ColorImage& truth, std::uint64_t frame) {
  NoiseFreeColors sensed;
  response.apply_response(truth, sensed);
  ColorImage picture(truth.width(), truth.height());
  response.add_noise(sensed, frame, picture.pixels());
  return picture;
}

TEST(ColorResponse, ExposesAsItRespondsInTheMiddleOfThePicture) {
  for (const std::uint32_t camera : {0u, 1u, 2u}) {
    const ColorResponse response(320, 240, 1, camera);
    const ColorImage picture = exposed(response, ColorImage(320, 240, {200, 120, 60}), 0);
    ColorImage middle(20, 20);
    for (int y = 0; y < 20; ++y) {
      for (int x = 0; x < 20; ++x) middle(x, y) = picture(150 + x, 110 + y);
    }
    const Eigen::Vector3f expected = 255 * response.respond_to({200 / 255.0f, 120 / 255.0f, 60 / 255.0f});
    EXPECT_LT((mean_of(middle) - expected.cast<double>()).cwiseAbs().maxCoeff(), 1.5) << camera;
    EXPECT_LT(picture(0, 0).r, middle(0, 0).r);  // vignetting
  }
}

TEST(ColorResponse, DiffersFromCameraToCamera) {
  ColorResponse first(64, 48, 1, 0), second(64, 48, 1, 1);
  const Eigen::Vector3f gray(0.5f, 0.5f, 0.5f);
  EXPECT_LT((first.respond_to(gray) - gray).cwiseAbs().maxCoeff(), 0.03f);
  EXPECT_GT((second.respond_to(gray) - first.respond_to(gray)).cwiseAbs().maxCoeff(), 0.02f);
}

TEST(ColorResponse, IsDecidedByItsSeedAndFrame) {
  ColorImage truth(64, 48);
  for (int i = 0; i < 64 * 48; ++i)
    truth.data()[i] = {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i / 7), 90};
  const ColorResponse response(64, 48, 1, 1), same(64, 48, 1, 1), other(64, 48, 2, 1);
  EXPECT_EQ(exposed(response, truth, 5), exposed(same, truth, 5));
  EXPECT_NE(exposed(response, truth, 5), exposed(response, truth, 6));
  EXPECT_NE(exposed(response, truth, 5), exposed(other, truth, 5));
}

}  // namespace
}  // namespace copresence::simulation
