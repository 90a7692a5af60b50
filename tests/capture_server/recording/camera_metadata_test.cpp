#include "capture_server/recording/camera_metadata.h"

#include <gtest/gtest.h>

namespace copresence::recording {
namespace {

CameraMetadata left_camera() {
  CameraMetadata note;
  note.name = "left \"one\"";
  note.model = {640,
                480,
                585.1,
                1.0 / 3.0 + 584,
                320.5,
                239.75,
                {0.2624, -0.9531, -0.0054, 0.0026, 1.1633, 0, 0, 1e-9}};
  note.registered = true;
  note.unit = DepthUnit::k100Micrometres;
  note.world_from_camera =
      Rigid3{Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix(),
             Eigen::Vector3d(0.1, -1.25, 2.0 / 3.0)};
  return note;
}

TEST(CameraMetadata, ComesBackBitForBit) {
  const auto back = parse_camera_metadata(to_json(left_camera()));
  ASSERT_TRUE(back) << back.error().what;
  EXPECT_EQ(*back, left_camera());
}

TEST(CameraMetadata, ComesBackWithoutAPose) {
  CameraMetadata note = left_camera();
  note.world_from_camera.reset();
  const auto back = parse_camera_metadata(to_json(note));
  ASSERT_TRUE(back) << back.error().what;
  EXPECT_EQ(*back, note);
}

TEST(CameraMetadata, ComesBackWithAColorCameraOfItsOwn) {
  CameraMetadata note = left_camera();
  note.registered = false;
  note.color = ColorCameraMetadata{{1280, 960, 1050, 1051, 640, 480, {0.1}},
                                   Rigid3{Eigen::Matrix3d::Identity(), Eigen::Vector3d(0.025, 0, 0)}};
  const auto back = parse_camera_metadata(to_json(note));
  ASSERT_TRUE(back) << back.error().what;
  EXPECT_EQ(*back, note);
}

TEST(CameraMetadata, SkipsKeysOfLaterVersions) {
  std::string json = to_json(left_camera());
  json.insert(1, "\"serial\":\"A00366\",");
  EXPECT_TRUE(parse_camera_metadata(json));
}

TEST(CameraMetadata, RefusesEveryTruncation) {
  const std::string json = to_json(left_camera());
  for (std::size_t size = 0; size < json.size(); ++size) {
    EXPECT_FALSE(parse_camera_metadata(std::string_view(json).substr(0, size))) << size;
  }
}

TEST(CameraMetadata, RefusesWhatCannotBe) {
  for (
      const char* json :
      {"", "[]", "7", "null", "{}",
       R"({"width":641,"height":480,"fx":1,"fy":1,"cx":0,"cy":0,"registered":true,"unit_um":1000})",
       R"({"width":640.5,"height":480,"fx":1,"fy":1,"cx":0,"cy":0,"registered":true,"unit_um":1000})",
       R"({"width":1e99,"height":480,"fx":1,"fy":1,"cx":0,"cy":0,"registered":true,"unit_um":1000})",
       R"({"width":640,"height":480,"fx":-1,"fy":1,"cx":0,"cy":0,"registered":true,"unit_um":1000})",
       R"({"width":640,"height":480,"fx":"1","fy":1,"cx":0,"cy":0,"registered":true,"unit_um":1000})",
       R"({"width":640,"height":480,"fx":1,"fy":1,"cx":0,"cy":0,"registered":1,"unit_um":1000})",
       R"({"width":640,"height":480,"fx":1,"fy":1,"cx":0,"cy":0,"registered":true,"unit_um":500})",
       R"({"width":640,"height":480,"fx":1,"fy":1,"cx":0,"cy":0,"registered":true,"unit_um":1000,"distortion":[1,2,3,4,5,6,7,8,9]})",
       R"({"width":640,"height":480,"fx":1,"fy":1,"cx":0,"cy":0,"registered":true,"unit_um":1000,"world_from_camera":[[1,0,0,0],[0,1,0,0],[0,0,2,0],[0,0,0,1]]})",
       R"({"width":640,"height":480,"fx":1,"fy":1,"cx":0,"cy":0,"registered":true,"unit_um":1000,"name":[]})"}) {
    const auto note = parse_camera_metadata(json);
    ASSERT_FALSE(note) << json;
    EXPECT_EQ(note.error().code, ErrorCode::kCorrupt);
  }
  EXPECT_FALSE(parse_camera_metadata(std::string(70000, ' ')));
}

}  // namespace
}  // namespace copresence::recording
