#include "web_gateway/page/page_files.h"

#include <algorithm>

#include "web_gateway/page/page_table.h"

namespace copresence::page {

const File* find(std::string_view path) {
  if (path == "/") path = "/index.html";
  const auto files = all_files();
  const auto found =
      std::find_if(files.begin(), files.end(), [path](const File& file) { return file.path == path; });
  return found == files.end() ? nullptr : &*found;
}

bool is_built() {
  return kIsBuilt;
}

}  // namespace copresence::page
