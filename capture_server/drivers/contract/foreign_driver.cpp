#include "capture_server/drivers/contract/foreign_driver.h"

#include <dlfcn.h>

namespace copresence::drivers {

std::optional<ForeignDriver> ForeignDriver::load(const std::string& path) {
  void* const library = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (!library) return std::nullopt;
  ForeignDriver driver;
  const auto find = [library](auto& function, const char* name) {
    function = reinterpret_cast<std::decay_t<decltype(function)>>(::dlsym(library, name));
    return function != nullptr;
  };
  const bool complete =
      find(driver.create_, "oniDriverCreate") && find(driver.initialize_, "oniDriverInitialize") &&
      find(driver.try_device_, "oniDriverTryDevice") && find(driver.open_, "oniDriverDeviceOpen") &&
      find(driver.close_, "oniDriverDeviceClose") && find(driver.enable_sync_, "oniDriverEnableFrameSync") &&
      find(driver.disable_sync_, "oniDriverDisableFrameSync") && find(driver.destroy_, "oniDriverDestroy");
  return complete ? std::optional(driver) : std::nullopt;
}

}  // namespace copresence::drivers
