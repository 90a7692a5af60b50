#pragma once

// The table that embed_page.py makes. Private to this module.

#include <span>

#include "web_gateway/page/page_files.h"

namespace copresence::page {

extern const bool kIsBuilt;
std::span<const File> all_files();

}  // namespace copresence::page
