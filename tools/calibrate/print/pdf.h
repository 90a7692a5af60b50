#pragma once

// A sheet as a PDF file: vector rectangles at exact millimetres, text in Helvetica. Thread: pure functions.

#include <string>

#include "tools/calibrate/print/sheet.h"

namespace copresence::calibrate {

/// PDF 1.4, uncompressed. Asks viewers to print without scaling.
std::string to_pdf(const Sheet& sheet);

}  // namespace copresence::calibrate
