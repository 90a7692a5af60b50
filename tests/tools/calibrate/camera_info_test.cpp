#include "tools/calibrate/lens/camera_info.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

namespace copresence::calibrate {
namespace {

using testing::HasSubstr;

const CameraInfo kLeft{"left \"A\"",
                       {640,
                        480,
                        525.123456789012345,
                        524.9,
                        319.7,
                        241.0 / 3,
                        {0.1, -0.25, 1e-4, -2e-5, 0.07, 0.1 / 3, 0, 7e-9}}};

TEST(CameraInfo, ReadsBackTheSameToTheLastBit) {
  const auto again = parse_camera_info(to_camera_info(kLeft), "left.yaml");
  ASSERT_TRUE(again) << again.error().what;
  EXPECT_EQ(*again, kLeft);
}

TEST(CameraInfo, IsWrittenAsRosReadsIt) {
  const CameraInfo plain{"kinect", {640, 480, 525, 525.5, 319.5, 239.5, {0.5, 0, 0, 0, 0, 0, 0, 0}}};
  EXPECT_EQ(to_camera_info(plain), R"(image_width: 640
image_height: 480
camera_name: "kinect"
camera_matrix:
  rows: 3
  cols: 3
  data: [525, 0, 319.5, 0, 525.5, 239.5, 0, 0, 1]
distortion_model: rational_polynomial
distortion_coefficients:
  rows: 1
  cols: 8
  data: [0.5, 0, 0, 0, 0, 0, 0, 0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [525, 0, 319.5, 0, 0, 525.5, 239.5, 0, 0, 0, 1, 0]
)");
}

TEST(CameraInfo, TakesAPlumbBobFromRos) {
  std::string text = to_camera_info(kLeft);
  const auto model = text.find("rational_polynomial");
  text.replace(model, 19, "plumb_bob");
  const auto cols = text.find("cols: 8"), end = text.find("rectification");
  text.replace(cols, end - cols, "cols: 5\n  data: [0.1, -0.2, 0.001, 0.002, 0.05]\n");
  const auto read = parse_camera_info(text, "left.yaml");
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_EQ(read->model.distortion, (std::array<double, 8>{0.1, -0.2, 0.001, 0.002, 0.05, 0, 0, 0}));
}

TEST(CameraInfo, NamesFileAndLineOfWhatIsWrong) {
  const auto error = [](const std::string& text) {
    const auto read = parse_camera_info(text, "a.yaml");
    return read ? std::string("none") : read.error().what;
  };
  const std::string good = to_camera_info(kLeft);
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    return text.replace(text.find(from), from.size(), to);
  };
  EXPECT_THAT(error(""), HasSubstr("a.yaml:1: \"image_width\" is missing"));
  EXPECT_THAT(error("- 1\n- 2"), HasSubstr("is missing"));
  EXPECT_THAT(error("a: [1, 2"), HasSubstr("a.yaml:"));
  EXPECT_THAT(error(with("image_width: 640", "image_width: wide")), HasSubstr("a.yaml:1: \"image_width\""));
  EXPECT_THAT(error(with("image_width: 640", "image_width: 641")), HasSubstr("must be even"));
  EXPECT_THAT(error(with("rational_polynomial", "equidistant")),
              HasSubstr("a.yaml:8: the distortion must be"));
  EXPECT_THAT(error(with("[525.1", "[0, 525.1")), HasSubstr("nine numbers"));
  EXPECT_THAT(error(with("[525.1", "[-525.1")), HasSubstr("positive focal"));
  EXPECT_THAT(error(with("camera_matrix", "matrix")), HasSubstr("\"camera_matrix\" is missing"));
  for (std::size_t length = 0; length < good.size(); length += 7) {
    (void)parse_camera_info(good.substr(0, length), "a.yaml");  // an error or a camera, never a crash
  }
}

TEST(CameraInfo, IsSavedAndLoaded) {
  const auto file = std::filesystem::temp_directory_path() / ("copresence_info_" + std::to_string(getpid()));
  ASSERT_TRUE(save_camera_info(kLeft, file));
  EXPECT_EQ(*load_camera_info(file), kLeft);
  std::filesystem::remove(file);
  EXPECT_EQ(load_camera_info(file).error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(save_camera_info(kLeft, "/nowhere/left.yaml"));
}

}  // namespace
}  // namespace copresence::calibrate
