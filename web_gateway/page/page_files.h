#pragma once

// The files of the page that viewers load, embedded into the program. embed_page.py makes the table
// from the folder that ./run web builds. Without that folder, the page says that it is missing.
// Thread: pure functions.

#include <cstdint>
#include <span>
#include <string_view>

namespace copresence::page {

struct File {
  std::string_view path;  ///< For example /index.html.
  std::string_view content_type;
  std::string_view etag;  ///< Changes with the content; with its quotation marks.
  std::span<const std::uint8_t> bytes;
  std::span<const std::uint8_t> gzip;  ///< The same compressed. Empty if that is no smaller.
};

/// Returns the file that a browser gets for this path, or nullptr. The path / means /index.html.
const File* find(std::string_view path);

/// False if the program was built without the page, so that it has only an explanation.
bool is_built();

}  // namespace copresence::page
