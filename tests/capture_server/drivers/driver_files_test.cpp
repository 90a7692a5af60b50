#include "capture_server/drivers/installed/driver_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tests/support/process.h"

namespace copresence::drivers {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class DriverFiles : public ::testing::Test {
 protected:
  DriverFiles() {
    ::unsetenv("OPENNI2_DRIVERS_PATH");
    ::unsetenv("OPENNI2_REDIST");
  }
  std::string make(const std::string& name) const {
    const fs::path file = folder_ / name;
    fs::create_directories(file.parent_path());
    std::ofstream(file) << "library";
    return fs::canonical(file);
  }
  std::string folder(const std::string& name) const { return (folder_ / name).string(); }

  testing::TemporaryFolder folder_;
};

TEST_F(DriverFiles, AreLibrariesThatOursDoNotReplace) {
  const std::string orbbec = make("a/liborbbec.so"), link_target = make("a/libPSLink.so.0");
  fs::create_symlink("libPSLink.so.0", folder_ / "a/libPSLink.so");
  for (const char* name : {"a/libPS1080.so", "a/libPS1080.so.0", "a/libOniFile.so.0",
                           "a/libFreenectDriver.so", "a/libDummyDevice.so.0", "a/libCopresenceKinectV1.so.0",
                           "a/orbbec.ini", "a/readme.so", "a/libthing.sofa"})
    make(name);
  EXPECT_THAT(installed_drivers({folder("a")}), ElementsAre(link_target, orbbec));
}

TEST_F(DriverFiles, OfTheFirstFolderComeBeforeOthersOfTheSameName) {
  const std::string first = make("a/liborbbec.so"), other = make("b/libother.so");
  make("b/liborbbec.so");
  EXPECT_THAT(installed_drivers({folder("a"), folder("nowhere"), folder("b")}), ElementsAre(first, other));
}

TEST_F(DriverFiles, AreTakenOnceHoweverTheyAreReached) {
  const std::string driver = make("a/liborbbec.so.0");
  fs::create_directory_symlink(folder("a"), folder_ / "b");
  EXPECT_THAT(installed_drivers({folder("a"), folder("b")}), ElementsAre(driver));
}

TEST_F(DriverFiles, AreNotTakenByAnotherNameWhereOursReplaceThem) {
  make("a/libFreenectDriver.so.0.5.3");
  fs::create_directories(folder_ / "b");
  fs::create_symlink(folder("a/libFreenectDriver.so.0.5.3"), folder_ / "b/libkinect.so");
  fs::create_symlink("nowhere", folder_ / "b/libgone.so");
  EXPECT_THAT(installed_drivers({folder("b")}), IsEmpty());
}

TEST_F(DriverFiles, AreLookedForWhereTheUserSaysFirst) {
  EXPECT_EQ(driver_folders("/sys").front(), "/sys");
  ::setenv("OPENNI2_DRIVERS_PATH", "/mine", 1);
  ::setenv("OPENNI2_REDIST", "/opt/OpenNI2/Redist/", 1);
  const auto folders = driver_folders("/sys");
  ASSERT_GE(folders.size(), 3u);
  EXPECT_EQ(folders[0], "/mine");
  EXPECT_EQ(fs::path(folders[1]), fs::path("/opt/OpenNI2/Redist/OpenNI2/Drivers"));
  EXPECT_EQ(folders[2], "/sys");
}

}  // namespace
}  // namespace copresence::drivers
