#include "tools/record/image_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "tests/support/recording_scene.h"

namespace copresence::record {
namespace {

using std::chrono::microseconds;
using testing::Contains;
using testing::HasSubstr;

class ImageFolderTest : public testing::Test {
 protected:
  void put(const std::string& name, const std::string& text = "x") const {
    const std::filesystem::path path = folder_.file(name);
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << text;
  }
  void image(const std::string& name, int type) const {
    const std::filesystem::path path = folder_.file(name);
    std::filesystem::create_directories(path.parent_path());
    cv::imwrite(path.string(), cv::Mat(8, 8, type, cv::Scalar::all(100)));
  }
  void depth(const std::string& name) const { image(name, CV_16UC1); }
  void color(const std::string& name) const { image(name, CV_8UC3); }
  Result<ImageFolder> find(const FolderChoice& choice = {}) const {
    return find_images(folder_.file(""), choice);
  }
  std::string first_depth() const {
    const auto images = find();
    return images ? images->depth.front().path.lexically_relative(folder_.file("")).string()
                  : images.error().what;
  }

  const test::TemporaryFolder folder_;
};

TEST_F(ImageFolderTest, ReadsTumsLists) {
  put("depth.txt",
      "# depth maps\n# timestamp filename\n1305031102.160407 depth/a.png\n1305031102.194330 depth/b.png\n");
  put("rgb.txt", "# color images\n1305031102.175304 rgb/a.png\n");
  for (const char* name : {"depth/a.png", "depth/b.png"}) depth(name);
  color("rgb/a.png");
  const auto images = find();
  ASSERT_TRUE(images) << images.error().what;
  EXPECT_TRUE(images->has_tum_depth);
  EXPECT_TRUE(images->since_1970);
  ASSERT_EQ(images->depth.size(), 2u);
  EXPECT_EQ(images->depth[1].time, microseconds(1305031102194330));
  ASSERT_EQ(images->color.size(), 1u);
  EXPECT_EQ(images->color[0].path.filename(), "a.png");
}

TEST_F(ImageFolderTest, ReadsOpenLorisColorList) {
  put("depth.txt", "1650000000.25 depth/a.png\n1650000000.283 depth/b.png\n");
  put("color.txt", "1650000000.25 color/a.png\n1650000000.283 color/b.png\n");
  for (const char* name : {"a.png", "b.png"}) {
    depth(std::string("depth/") + name);
    color(std::string("color/") + name);
  }
  const auto images = find();
  ASSERT_TRUE(images) << images.error().what;
  EXPECT_EQ(images->color.size(), 2u);
  EXPECT_FALSE(images->has_tum_depth) << "its depth is in millimetres";
}

TEST_F(ImageFolderTest, ReadsAssociationsInEitherOrder) {
  for (const char* name : {"depth/1.png", "depth/2.png"}) depth(name);
  color("rgb/1.png");
  for (const char* text : {"1.0 depth/1.png 1.01 rgb/1.png\n1.03 depth/2.png 1.01 rgb/1.png\n",
                           "1.01 rgb/1.png 1.0 depth/1.png\n1.01 rgb/1.png 1.03 depth/2.png\n"}) {
    put("associations.txt", text);
    const auto images = find();
    ASSERT_TRUE(images) << images.error().what;
    EXPECT_EQ(images->depth.size(), 2u);
    EXPECT_EQ(images->color.size(), 1u) << "one picture of two pairs";
    EXPECT_EQ(images->depth[1].time, microseconds(1'030'000));
  }
}

TEST_F(ImageFolderTest, ReadsListsAsEditorsWriteThem) {
  depth("depth/a b.png");
  color("rgb/a b.png");
  for (const char* text :
       {"\xEF\xBB\xBF"
        "1.5 rgb/a b.png 1.5 depth/a b.png\r\n",
        "1.5;rgb/a b.png;1.5;depth/a b.png\n", "1.5, rgb/a b.png, 1.5, depth/a b.png\n",
        "1.5 \"rgb/a b.png\" 1.5 \"depth/a b.png\"\n", "1.5\trgb\\a b.png\t1.5\tdepth\\a b.png\r\n",
        "time;color;time;depth\n1.5;rgb/a b.png;1.5;depth/a b.png;0.1;0.2\n"}) {
    put("associations.txt", text);
    const auto images = find();
    ASSERT_TRUE(images) << text << images.error().what;
    EXPECT_EQ(images->depth.front().path.filename(), "a b.png") << text;
    EXPECT_EQ(images->depth.front().time, microseconds(1'500'000)) << text;
  }
  put("associations.txt",
      "\xFF\xFE"
      "1");
  EXPECT_THAT(find().error().what, HasSubstr("UTF-8"));
}

TEST_F(ImageFolderTest, TakesWholeNumbersInAListForFramesAndTimesForTimes) {
  for (const char* name : {"1.png", "2.png", "3.png"}) {
    depth(std::string("depth/") + name);
    color(std::string("rgb/") + name);
  }
  const auto time_of_second = [&](const char* a, const char* b, const char* c) {
    put("associations.txt", fmt::format("{0} depth/1.png {0} rgb/1.png\n{1} depth/2.png {1} rgb/2.png\n{2} "
                                        "depth/3.png {2} rgb/3.png\n",
                                        a, b, c));
    const auto images = find();
    EXPECT_TRUE(images) << images.error().what;
    EXPECT_EQ(images->depth.at(1).time, images->color.at(1).time);
    return images->depth.at(1).time.count();
  };
  EXPECT_EQ(time_of_second("1", "2", "3"), 66'667);
  EXPECT_EQ(time_of_second("1650000000000", "1650000000033", "1650000000066"), 1650000000033000);
  EXPECT_EQ(time_of_second("1650000000000000000", "1650000000033333333", "1650000000066666666"),
            1650000000033333);
}

TEST_F(ImageFolderTest, RefusesTimesOfTwoReadingsUntilToldTheUnit) {
  for (const char* name : {"0.png", "40.png", "80.png", "120.png"}) depth(std::string("depth/") + name);
  EXPECT_THAT(find().error().what, testing::AllOf(HasSubstr("as ms: 0.12 s at 25 frames/s"),
                                                  HasSubstr("as frame: 4 s at 0.75 frames/s")));
  EXPECT_EQ(find({.times = TimeUnit::kMilliseconds})->depth.at(1).time, microseconds(40'000));
  EXPECT_EQ(find({.times = TimeUnit::kFrames})->depth.at(1).time, microseconds(1'333'333));
}

TEST_F(ImageFolderTest, NumbersFramesByTheirNames) {
  for (const char* name : {"frame-000002.depth.png", "frame-000010.depth.png"}) depth(name);
  color("frame-000002.color.jpg");
  const auto images = find();
  ASSERT_TRUE(images) << images.error().what;
  EXPECT_FALSE(images->has_tum_depth);
  ASSERT_EQ(images->depth.size(), 2u);
  EXPECT_EQ(images->depth[0].time, microseconds(66'667));
  EXPECT_EQ(images->depth[1].time, microseconds(333'333));
  EXPECT_EQ(images->color.at(0).time, microseconds(66'667));
}

TEST_F(ImageFolderTest, FindsTheTimeInEveryNamingScheme) {
  struct Scheme {
    const char *first, *second, *third;
    long long step_us;
  };
  for (const Scheme& scheme :
       {Scheme{"0000001-000000000000", "0000002-000000033369", "0000003-000000066738", 33'369},  // Redwood
        Scheme{"1650000000000", "1650000000033", "1650000000066", 33'000},
        Scheme{"Depth_1582018310593.05", "Depth_1582018310626.41", "Depth_1582018310659.77",
               33'360},  // RealSense
        Scheme{"1650000000000000", "1650000000033333", "1650000000066666", 33'333},
        Scheme{"1650000000000000000", "1650000000033333333", "1650000000066666666", 33'333},
        Scheme{"1305031102-160407000", "1305031102-194330000", "1305031102-226738000", 33'923},
        Scheme{"1305031102.160407", "1305031102.194330", "1305031102.226738", 33'923},
        Scheme{"2022-04-15_10-20-30.100", "2022-04-15_10-20-30.133", "2022-04-15_10-20-30.166", 33'000},
        Scheme{"cam1_000001", "cam1_000002", "cam1_000003", 33'333},
        Scheme{"2022-04-15_000001", "2022-04-15_000002", "2022-04-15_000003", 33'333},
        Scheme{"one", "three", "two", 33'333}}) {
    std::filesystem::remove_all(folder_.file("depth"));
    for (const char* name : {scheme.first, scheme.second, scheme.third})
      depth(fmt::format("depth/{}.png", name));
    const auto images = find();
    ASSERT_TRUE(images) << images.error().what;
    EXPECT_NEAR(static_cast<double>((images->depth[1].time - images->depth[0].time).count()),
                static_cast<double>(scheme.step_us), 1.0)
        << scheme.first;
  }
}

TEST_F(ImageFolderTest, TakesOneDepthFolderAndSaysWhatIsLeft) {
  for (const char* name : {"1.png", "2.png"}) {
    for (const char* of : {"depth/", "depth_filled/", "masks/"}) depth(std::string(of) + name);
    color(std::string("rgb/") + name);
    image(std::string("label/") + name, CV_8UC1);
  }
  const auto images = find();
  ASSERT_TRUE(images) << images.error().what;
  EXPECT_EQ(images->depth.size(), 2u);
  EXPECT_EQ(images->color.size(), 2u);
  EXPECT_EQ(first_depth(), "depth/1.png");
  EXPECT_THAT(images->remarks,
              Contains(testing::AllOf(HasSubstr("left: "), HasSubstr("depth_filled/ (2 images)"),
                                      HasSubstr("label/"), HasSubstr("masks/"))));
  const auto other = find({.depth = "depth_filled"});
  ASSERT_TRUE(other) << other.error().what;
  EXPECT_EQ(other->depth.front().path.parent_path().filename(), "depth_filled");
  EXPECT_THAT(find({.depth = "nothing"}).error().what, HasSubstr("--depth"));
}

TEST_F(ImageFolderTest, PrefersDepthThatIsAlignedToColour) {
  for (const char* of : {"depth/1.png", "aligned_depth/1.png"}) depth(of);
  EXPECT_EQ(first_depth(), "aligned_depth/1.png");
}

TEST_F(ImageFolderTest, RefusesFoldersThatAreEquallyLikely) {
  for (const char* of : {"depth_left/1.png", "depth_right/1.png"}) depth(of);
  EXPECT_THAT(find().error().what,
              testing::AllOf(HasSubstr("depth_left/"), HasSubstr("depth_right/"), HasSubstr("--depth")));
}

TEST_F(ImageFolderTest, LeavesInfraredMasksAndHiddenFiles) {
  for (const char* number : {"0000", "0001"}) {
    color(fmt::format("color{}.png", number));
    depth(fmt::format("depth{}.png", number));
    depth(fmt::format("ir{}.png", number));
    image(fmt::format("mask{}.png", number), CV_8UC1);
  }
  put("._color0000.png");
  put("__MACOSX/depth0000.png");
  put(".DS_Store");
  const auto images = find();
  ASSERT_TRUE(images) << images.error().what;
  EXPECT_EQ(images->depth.size(), 2u);
  EXPECT_EQ(images->color.size(), 2u);
  EXPECT_THAT(images->remarks, Contains(testing::AllOf(HasSubstr("ir*.png (2 images)"),
                                                       HasSubstr("mask*.png"), HasSubstr("3 hidden files"))));
}

TEST_F(ImageFolderTest, KnowsDepthByItsContentWhereNoNameTells) {
  depth("a/0001.png");
  color("b/0001.png");
  EXPECT_EQ(first_depth(), "a/0001.png");
  EXPECT_EQ(find()->color.size(), 1u);
}

TEST_F(ImageFolderTest, KnowsNyusAndFakenectsLetters) {
  depth("d-1294886362.665769-2.pgm");
  color("r-1294886362.238178-1.ppm");
  const auto images = find();
  ASSERT_TRUE(images) << images.error().what;
  EXPECT_EQ(images->depth.size(), 1u);
  EXPECT_EQ(images->color.size(), 1u);
}

TEST_F(ImageFolderTest, RefusesDepthAndColourOfDifferentTimes) {
  for (const char* name : {"depth/100.000.png", "depth/100.033.png"}) depth(name);
  for (const char* name : {"rgb/900.000.png", "rgb/900.033.png"}) color(name);
  EXPECT_THAT(find().error().what, HasSubstr("not taken together"));
}

TEST_F(ImageFolderTest, NamesTheLineThatIsWrong) {
  put("depth.txt", "# ok\n1 depth/a.png\nyesterday depth/a.png\n");
  EXPECT_THAT(find().error().what, HasSubstr("depth.txt:3"));
  put("associations.txt", "1.0 depth/a.png 1.0\n");
  EXPECT_THAT(find().error().what, HasSubstr("associations.txt:1"));
  put("associations.txt", "1.0 depth/a.png 1.0 depth/b.png\n");
  EXPECT_THAT(find().error().what, HasSubstr("associations.txt:1"));
}

TEST_F(ImageFolderTest, NamesWhatIsMissing) {
  EXPECT_THAT(find().error().what, HasSubstr("no depth image"));
  put("depth.txt", "1 depth/a.png\n");
  EXPECT_THAT(find().error().what, HasSubstr("depth/a.png"));
  std::filesystem::remove(folder_.file("depth.txt"));
  depth("depth/a.png");
  put("rgb.txt", "1 rgb/a.png\n");
  EXPECT_THAT(find().error().what, HasSubstr("no depth.txt"));
  EXPECT_EQ(find_images("/nonexistent", {}).error().code, ErrorCode::kNotFound);
}

TEST_F(ImageFolderTest, NamesTheFormatThatIsNotRead) {
  put("0001.exr", "\x76\x2f\x31\x01");
  EXPECT_THAT(find().error().what,
              testing::AllOf(HasSubstr("0001.exr"), HasSubstr("OpenEXR"), HasSubstr("16-bit PNG")));
}

TEST_F(ImageFolderTest, SaysThatImagesLieDeeper) {
  depth("seq/01/depth/1.png");
  EXPECT_THAT(find().error().what, testing::AllOf(HasSubstr("deeper"), HasSubstr("seq/01")));
}

}  // namespace
}  // namespace copresence::record
