#include "capture_server/diagnosis/usb_cameras.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "capture_server/diagnosis/device_listing.h"
#include "tests/support/process.h"

namespace copresence::diagnosis {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// A machine's USB bus as files.
class UsbCameras : public ::testing::Test {
 protected:
  void plug_in(const std::string& name, const std::string& vendor, const std::string& product, int bus,
               int address, const std::string& serial = "", const std::string& speed = "480") {
    const fs::path device = folder_ / "sys" / name;
    fs::create_directories(device);
    std::ofstream(device / "idVendor") << vendor << "\n";
    std::ofstream(device / "idProduct") << product << "\n";
    std::ofstream(device / "busnum") << bus << "\n";
    std::ofstream(device / "devnum") << address << "\n";
    std::ofstream(device / "speed") << speed << "\n";
    if (!serial.empty()) std::ofstream(device / "serial") << serial << "\n";
    std::ofstream(make_node(bus, address));
  }
  fs::path make_node(int bus, int address) {
    char name[16];
    std::snprintf(name, sizeof(name), "%03d", bus);
    const fs::path folder = folder_ / "dev" / name;
    fs::create_directories(folder);
    std::snprintf(name, sizeof(name), "%03d", address);
    return folder / name;
  }
  std::vector<UsbCamera> find() const {
    return find_usb_cameras({folder_ / "sys", folder_ / "dev", folder_ / "proc"});
  }

  testing::TemporaryFolder folder_;
};

TEST_F(UsbCameras, AreFoundAmongOtherDevices) {
  plug_in("usb1", "1d6b", "0002", 1, 1);
  plug_in("1-1", "046d", "c31c", 1, 5);
  plug_in("1-4.1", "045e", "02ae", 1, 12, "A00366802032047A");
  plug_in("2-1", "1d27", "0601", 2, 3);
  const auto cameras = find();
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_EQ(cameras[0].model, "Kinect");
  EXPECT_EQ(cameras[0].serial, "A00366802032047A");
  EXPECT_THAT(cameras[0].node, ::testing::EndsWith("/001/012"));
  EXPECT_THAT(cameras[0].problems, IsEmpty());
  EXPECT_EQ(cameras[1].kind, "primesense");
}

TEST_F(UsbCameras, ThatMayNotBeOpenedNeedTheRule) {
  plug_in("1-4.1", "045e", "02ae", 1, 12);
  fs::remove(make_node(1, 12));  // root may open anything that is there
  const auto cameras = find();
  ASSERT_EQ(cameras.size(), 1u);
  EXPECT_TRUE(cameras[0].blocked);
  EXPECT_THAT(cameras[0].problems, ElementsAre(HasSubstr("70-copresence-cameras.rules")));
}

TEST_F(UsbCameras, ThatAnotherProcessHoldsNameIt) {
  plug_in("1-4.1", "045e", "02ae", 1, 12);
  const fs::path process = folder_ / "proc" / "4711";
  fs::create_directories(process / "fd");
  std::ofstream(process / "comm") << "glview\n";
  fs::create_symlink("/dev/null", process / "fd" / "0");
  fs::create_symlink(make_node(1, 12), process / "fd" / "7");
  const auto cameras = find();
  ASSERT_EQ(cameras.size(), 1u);
  EXPECT_TRUE(cameras[0].blocked);
  EXPECT_THAT(cameras[0].problems, ElementsAre(HasSubstr("glview (process 4711)")));
}

TEST_F(UsbCameras, ThatShareABusHaveTooLittleRoom) {
  plug_in("1-1.1", "045e", "02ae", 1, 12, "A1");
  plug_in("1-2.1", "045e", "02ae", 1, 15, "B2");
  plug_in("2-1.1", "045e", "02ae", 2, 4, "C3");
  const auto cameras = find();
  ASSERT_EQ(cameras.size(), 3u);
  EXPECT_THAT(cameras[0].problems, ElementsAre(HasSubstr("2 depth cameras share USB bus 1")));
  EXPECT_FALSE(cameras[0].blocked);
  EXPECT_THAT(cameras[2].problems, IsEmpty());
}

TEST_F(UsbCameras, ThatRunTooSlowlySaySo) {
  plug_in("1-1.1", "045e", "02ae", 1, 12, "A1", "12");
  EXPECT_THAT(find().at(0).problems, ElementsAre(HasSubstr("12 Mbit/s")));
}

TEST_F(UsbCameras, WithoutPowerShowOnlyTheirMotor) {
  plug_in("1-4.2", "045e", "02b0", 1, 11);
  plug_in("1-5.1", "045e", "02ae", 1, 12);
  plug_in("1-5.2", "045e", "02b0", 1, 13);
  const auto cameras = find();
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_THAT(cameras[1].problems, ElementsAre(HasSubstr("power supply")));
}

TEST_F(UsbCameras, OfTheModels1473AndForWindowsHaveTheirAudioDevicesSerialNumber) {
  const std::string zeros(16, '0');
  plug_in("1-4.1", "045e", "02ad", 1, 10, "A44887B00366047A");
  plug_in("1-4.2", "045e", "02ae", 1, 11, zeros);
  plug_in("2-3.1", "045e", "02be", 2, 20, "B00366047A44887B");
  plug_in("2-3.3", "045e", "02bf", 2, 21, zeros);
  plug_in("3-1.1", "045e", "02ae", 3, 30, "A00366802032047A");  // a 1414 beside its audio device
  plug_in("3-1.2", "045e", "02ad", 3, 31, "A00366802032047A");
  plug_in("4-1.1", "045e", "02ae", 4, 40, zeros);  // its audio device does not show
  const auto cameras = find();
  ASSERT_EQ(cameras.size(), 4u);
  EXPECT_EQ(cameras[0].serial, "A44887B00366047A");
  EXPECT_EQ(cameras[1].serial, "B00366047A44887B");
  EXPECT_EQ(cameras[2].serial, "A00366802032047A");
  EXPECT_EQ(cameras[3].serial, zeros);
}

DeviceListing listed(const std::string& source, const std::string& driver) {
  return {source, "a camera", "", driver, {}, {}, true};
}
UsbCamera on_bus(const std::string& serial, const std::string& kind, const std::string& place,
                 const std::string& problem = "") {
  UsbCamera camera{"model", serial, "", kind, place, {}, false};
  if (!problem.empty()) camera.problems.push_back(problem);
  return camera;
}

TEST(BusFacts, BelongToTheCameraWithTheSameSerialNumber) {
  std::vector<DeviceListing> listing{listed("openni:freenect://A1", "kinect_v1"),
                                     listed("openni:freenect://B2", "kinect_v1")};
  add_bus_facts(listing, {on_bus("B2", "kinect_v1", "@1/5", "too slow"), on_bus("A1", "kinect_v1", "@1/6")});
  ASSERT_EQ(listing.size(), 2u);
  EXPECT_THAT(listing[0].problems, IsEmpty());
  EXPECT_THAT(listing[1].problems, ElementsAre("too slow"));
}

TEST(BusFacts, BelongToTheCameraAtTheSamePlace) {
  std::vector<DeviceListing> listing{listed("openni:1d27/0601@1/5", "primesense"),
                                     listed("openni:1d27/0601@1/6", "primesense")};
  add_bus_facts(listing,
                {on_bus("", "primesense", "@1/6", "too slow"), on_bus("", "primesense", "@1/5", "shared")});
  ASSERT_EQ(listing.size(), 2u);
  EXPECT_THAT(listing[0].problems, ElementsAre("shared"));
  EXPECT_THAT(listing[1].problems, ElementsAre("too slow"));
}

TEST(BusFacts, BelongToTheOnlyCameraThatIsLeftOfItsKind) {
  // A driver that may not open the audio device reports zeros or something else: still one camera, listed once.
  std::vector<DeviceListing> listing{listed("openni:freenect://A1", "kinect_v1"),
                                     listed("openni:freenect://0000000000000000", "kinect_v1")};
  add_bus_facts(listing, {on_bus("A1", "kinect_v1", "@1/5"), on_bus("C3", "kinect_v1", "@1/6", "too slow")});
  ASSERT_EQ(listing.size(), 2u);
  EXPECT_THAT(listing[1].problems, ElementsAre("too slow"));
}

TEST(BusFacts, ListACameraThatNoDriverFoundAndNeverTwoAsOne) {
  std::vector<DeviceListing> listing{listed("openni:freenect://A1", "kinect_v1")};
  add_bus_facts(
      listing, {on_bus("C3", "kinect_v1", "@1/5", "no power"), on_bus("D4", "kinect_v1", "@1/6", "no rule")});
  ASSERT_EQ(listing.size(), 3u);
  EXPECT_EQ(listing[1].source, "");
  EXPECT_THAT(listing[1].problems, ElementsAre("no power"));
  EXPECT_THAT(listing[2].problems, ElementsAre("no rule"));
}

TEST_F(UsbCameras, AreNoneOnAMachineWithoutUsb) {
  EXPECT_THAT(find(), IsEmpty());
}

}  // namespace
}  // namespace copresence::diagnosis
