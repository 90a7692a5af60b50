#pragma once

// What the USB bus knows of cameras, beside what their drivers say. Only for this room's own sources and
// their tests.
//
// Thread: free functions, safe anywhere.

#include <vector>

#include "capture_server/diagnosis/usb_cameras.h"
#include "capture_server/sensor/frame_source.h"

namespace copresence::sensor {

/// Adds to each listed camera what keeps it from working as the bus shows it, and lists cameras with a
/// problem that no driver has found. A camera is the same by its serial number, by its place on the bus, or
/// as the only one of its kind that is left on either side; so a working camera is listed once.
void add_bus_facts(std::vector<DeviceListing>& listing, const std::vector<UsbCamera>& bus);

}  // namespace copresence::sensor
