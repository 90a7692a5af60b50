#include "tools/record/image_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/recording_scene.h"

namespace copresence::record {
namespace {

using testing::HasSubstr;

class ImageFolderTest : public testing::Test {
 protected:
  void put(const std::string& name, const std::string& text = "x") const {
    const std::filesystem::path path = folder_.file(name);
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }
  Result<ImageFolder> find() const { return find_images(folder_.file(""), 30); }

  const test::TemporaryFolder folder_;
};

TEST_F(ImageFolderTest, ReadsTumsLists) {
  put("depth.txt",
      "# depth maps\n# timestamp filename\n1305031102.160407 depth/a.png\n1305031102.194330 depth/b.png\n");
  put("rgb.txt", "# color images\n1305031102.175304 rgb/a.png\n");
  for (const char* name : {"depth/a.png", "depth/b.png", "rgb/a.png"}) put(name);
  const auto images = find();
  ASSERT_TRUE(images) << images.error().what;
  EXPECT_TRUE(images->has_lists);
  ASSERT_EQ(images->depth.size(), 2u);
  EXPECT_DOUBLE_EQ(images->depth[1].time_s, 1305031102.194330);
  ASSERT_EQ(images->color.size(), 1u);
  EXPECT_EQ(images->color[0].path.filename(), "a.png");
}

TEST_F(ImageFolderTest, ReadsAssociationsInEitherOrder) {
  for (const char* name : {"depth/1.png", "depth/2.png", "rgb/1.png"}) put(name);
  for (const char* text : {"1.0 depth/1.png 1.01 rgb/1.png\n1.03 depth/2.png 1.01 rgb/1.png\n",
                           "1.01 rgb/1.png 1.0 depth/1.png\n1.01 rgb/1.png 1.03 depth/2.png\n"}) {
    put("associations.txt", text);
    const auto images = find();
    ASSERT_TRUE(images) << images.error().what;
    EXPECT_EQ(images->depth.size(), 2u);
    EXPECT_EQ(images->color.size(), 1u) << "one picture of two pairs";
    EXPECT_DOUBLE_EQ(images->depth[1].time_s, 1.03);
  }
}

TEST_F(ImageFolderTest, TakesWholeNumbersInAListForFrames) {
  for (const char* name : {"depth/1.png", "depth/2.png", "rgb/1.png", "rgb/2.png"}) put(name);
  put("associations.txt", "1 depth/1.png 1 rgb/1.png\n2 depth/2.png 2 rgb/2.png\n");
  const auto images = find();
  ASSERT_TRUE(images) << images.error().what;
  EXPECT_DOUBLE_EQ(images->depth.at(1).time_s, 2 / 30.0);
  EXPECT_DOUBLE_EQ(images->color.at(1).time_s, 2 / 30.0);
}

TEST_F(ImageFolderTest, NumbersFramesByTheirNames) {
  for (const char* name : {"frame-000002.depth.png", "frame-000010.depth.png", "frame-000002.color.jpg"})
    put(name);
  const auto images = find();
  ASSERT_TRUE(images) << images.error().what;
  EXPECT_FALSE(images->has_lists);
  ASSERT_EQ(images->depth.size(), 2u);
  EXPECT_DOUBLE_EQ(images->depth[0].time_s, 2 / 30.0);
  EXPECT_DOUBLE_EQ(images->depth[1].time_s, 10 / 30.0);
  EXPECT_DOUBLE_EQ(images->color.at(0).time_s, 2 / 30.0);
}

TEST_F(ImageFolderTest, TakesANameThatIsATimeForOne) {
  for (const char* name : {"depth/1305031102.160407.png", "rgb/1305031102.175304.png"}) put(name);
  const auto images = find();
  ASSERT_TRUE(images) << images.error().what;
  EXPECT_DOUBLE_EQ(images->depth.at(0).time_s, 1305031102.160407);
  EXPECT_DOUBLE_EQ(images->color.at(0).time_s, 1305031102.175304);
}

TEST_F(ImageFolderTest, NamesTheLineThatIsWrong) {
  put("depth.txt", "# ok\nyesterday depth/a.png\n");
  EXPECT_THAT(find().error().what, HasSubstr("depth.txt:2"));
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
  put("depth/a.png");
  put("rgb.txt", "1 rgb/a.png\n");
  EXPECT_THAT(find().error().what, HasSubstr("no depth.txt"));
  EXPECT_EQ(find_images("/nonexistent", 30).error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace copresence::record
