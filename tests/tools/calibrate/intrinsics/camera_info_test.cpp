#include "tools/calibrate/intrinsics/camera_info.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
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
                        {0.1, -0.25, 1e-4, -2e-5, 0.07, 0.1 / 3, 0, 7e-9}},
                       {}};

TEST(CameraInfo, ReadsBackTheSameToTheLastBit) {
  const auto again = parse_camera_info(to_camera_info(kLeft), "left.yaml");
  ASSERT_TRUE(again) << again.error().what;
  EXPECT_EQ(*again, kLeft);
}

TEST(CameraInfo, IsWrittenAsRosReadsIt) {
  const CameraInfo plain{"kinect", {640, 480, 525, 525.5, 319.5, 239.5, {0.5, 0, 0, 0, 0, 0, 0, 0}}, {}};
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
              HasSubstr("a.yaml:8: \"equidistant\" is a fisheye lens"));
  EXPECT_THAT(error(with("rational_polynomial", "wobbly")),
              HasSubstr("a.yaml:8: the distortion model \"wobbly\" is not known"));
  EXPECT_THAT(error(with("[525.1", "[0, 525.1")), HasSubstr("nine numbers"));
  EXPECT_THAT(error(with("[525.1", "[-525.1")), HasSubstr("positive focal"));
  EXPECT_THAT(error(with("camera_matrix", "matrix")), HasSubstr("\"camera_matrix\" is missing"));
  for (std::size_t length = 0; length < good.size(); length += 7) {
    (void)parse_camera_info(good.substr(0, length), "a.yaml");  // must not crash
  }
}

std::string info_with(const std::string& model, const std::string& coefficients,
                      const std::string& matrix = "525, 0, 320, 0, 525, 240, 0, 0, 1") {
  return "image_width: 640\nimage_height: 480\ncamera_name: cam\ncamera_matrix:\n  rows: 3\n  cols: 3\n  "
         "data: [" +
         matrix + "]\n" + model + "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [" + coefficients +
         "]\n";
}

std::array<double, 8> distortion_of(const std::string& text) {
  const auto read = parse_camera_info(text, "a.yaml");
  EXPECT_TRUE(read) << text << read.error().what;
  return read ? read->model.distortion : std::array<double, 8>{};
}

TEST(CameraInfo, TakesTheNamesAndNumbersThatRosAndItsUsersWrite) {
  const std::array<double, 8> five{0.05, -0.1, 0.001, -0.001, 0.02, 0, 0, 0};
  for (const char* model :
       {"", "distortion_model: plumb_bob\n", "camera_model: plumb_bob\n", "distortion_model: Plumb Bob\n",
        "distortion_model: radtan\n", "camera_model: pinhole\n", "distortion_model: ''\n",
        "distortion_model: rational_polynomial\n"}) {
    EXPECT_EQ(distortion_of(info_with(model, "0.05, -0.1, 0.001, -0.001, 0.02")), five) << model;
  }
  const std::array<double, 8> eight{0.2, -0.1, 0, 0, 0, 0.5, -0.1, 0};
  for (const char* tail : {"", ", 0, 0, 0, 0", ", 0, 0, 0, 0, 0, 0"}) {
    for (const char* model :
         {"distortion_model: plumb_bob\n", "distortion_model: rational_polynomial\n", ""}) {
      EXPECT_EQ(distortion_of(info_with(model, std::string("0.2, -0.1, 0, 0, 0, 0.5, -0.1, 0") + tail)),
                eight)
          << tail;
    }
  }
  EXPECT_EQ(distortion_of(info_with("distortion_model: none\n", "0, 0, 0, 0, 0")), (std::array<double, 8>{}));
  EXPECT_EQ(distortion_of(info_with("distortion_model: plumb_bob\n", "")), (std::array<double, 8>{}));
}

TEST(CameraInfo, TakesAMessageAsRosPrintsIt) {
  for (const char* text :
       {// ros2 topic echo
        "header:\n  stamp:\n    sec: 5\n    nanosec: 7\n  frame_id: cam\nheight: 480\nwidth: 640\n"
        "distortion_model: plumb_bob\nd:\n- 0.05\n- -0.1\n- 0.001\n- -0.001\n- 0.02\n"
        "k:\n- 525.0\n- 0.0\n- 320.0\n- 0.0\n- 525.0\n- 240.0\n- 0.0\n- 0.0\n- 1.0\n"
        "binning_x: 0\nbinning_y: 0\nroi:\n  x_offset: 0\n  y_offset: 0\n  height: 0\n  width: 0\n"
        "  do_rectify: false\n---\nheader:\n  frame_id: cam\n",
        // rostopic echo
        "header: \n  seq: 5\n  frame_id: \"cam\"\nheight: 480\nwidth: 640\ndistortion_model: \"plumb_bob\"\n"
        "D: [0.05, -0.1, 0.001, -0.001, 0.02]\nK: [525.0, 0.0, 320.0, 0.0, 525.0, 240.0, 0.0, 0.0, "
        "1.0]\n---\n",
        // OpenCV's FileStorage
        "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\ncamera_name: cam\n"
        "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
        "   data: [ 525., 0., 320., 0., 5.25e+02, 240., 0., 0., 1. ]\n"
        "distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n"
        "   data: [ 0.05, -1.0e-01, 0.001, -0.001, 0.02 ]\n"}) {
    const auto read = parse_camera_info(text, "a.yaml");
    ASSERT_TRUE(read) << text << read.error().what;
    const CameraModel expected{640, 480, 525, 525, 320, 240, {0.05, -0.1, 0.001, -0.001, 0.02, 0, 0, 0}};
    EXPECT_EQ(read->model, expected);
    EXPECT_EQ(read->name, "cam");
    EXPECT_EQ(read->remark, "");
  }
}

TEST(CameraInfo, SaysWhatItCannotUse) {
  const auto error = [](const std::string& text) {
    const auto read = parse_camera_info(text, "a.yaml");
    return read ? std::string("none") : read.error().what;
  };
  const std::string model = "distortion_model: plumb_bob\n";
  for (const char* fisheye : {"equidistant", "fisheye", "Kannala-Brandt", "omni"}) {
    EXPECT_THAT(
        error(info_with(std::string("distortion_model: ") + fisheye + "\n", "0.01, 0.02, -0.01, 0.003")),
        HasSubstr(std::string("a.yaml:8: \"") + fisheye + "\" is a fisheye lens"));
  }
  EXPECT_THAT(error(info_with(model, "0.1, 0, 0, 0, 0, 0, 0, 0, 0.01, 0, 0, 0")), HasSubstr("thin-prism"));
  EXPECT_THAT(error(info_with(model, "0.1, 0.2")), HasSubstr("there are 2 distortion coefficients"));
  EXPECT_THAT(error(info_with("distortion_model: none\n", "0.1, 0, 0, 0, 0")), HasSubstr("not 0"));
  EXPECT_THAT(error(info_with(model, "0, 0, 0, 0", "525, 0, 320, 0, 525, 240, 0, 0, 2")),
              HasSubstr("must be [fx"));
  EXPECT_THAT(error(info_with(model, "0, 0, 0, 0") + "binning_x: 2\n"), HasSubstr("reduced by binning_x 2"));
  EXPECT_THAT(error(info_with(model, "0, 0, 0, 0") + "roi: {width: 320, height: 240}\n"),
              HasSubstr("whole pictures"));
  EXPECT_THAT(error("<?xml version=\"1.0\"?>\n<opencv_storage>\n"), HasSubstr("is XML"));
}

TEST(CameraInfo, SaysWhatSkewItLeavesOut) {
  const auto read =
      parse_camera_info(info_with("", "0, 0, 0, 0", "525, 4, 320, 0, 525, 240, 0, 0, 1"), "a.yaml");
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_THAT(read->remark, HasSubstr("a skew of 4, which is left out"));
  EXPECT_THAT(read->remark, HasSubstr("up to 1.8 px"));
}

TEST(CameraInfo, RefusesAFileThatIsFarTooLong) {
  const auto file = std::filesystem::temp_directory_path() / ("copresence_long_" + std::to_string(getpid()));
  std::string zeros = "0";
  for (int i = 0; i < 500000; ++i) zeros += ", 0";
  std::ofstream(file) << info_with("", zeros);
  EXPECT_THAT(load_camera_info(file).error().what, HasSubstr("too many for a camera_info"));
  std::filesystem::remove(file);
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
