#include "tools/record/image_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <string_view>
#include <utility>

#include "tools/record/image_groups.h"

namespace copresence::record {
namespace {

namespace fs = std::filesystem;

constexpr const char* kAssociationNames[] = {"associations.txt", "association.txt", "associated.txt",
                                             "associate.txt", "assoc.txt"};
constexpr const char* kDepthLists[] = {"aligned_depth.txt", "depth.txt"};
constexpr const char* kColorLists[] = {"rgb.txt", "color.txt", "colour.txt"};

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

// A word of a line. `ends_field` is true before a comma, a semicolon, a tab or the end of the line.
struct Word {
  std::string text;
  bool is_quoted = false, ends_field = false;
};

std::vector<Word> words_of(std::string_view line) {
  std::vector<Word> words;
  Word word;
  bool in_quotes = false;
  const auto end_word = [&] {
    if (!word.text.empty() || word.is_quoted) words.push_back(std::move(word));
    word = {};
  };
  for (const char c : line) {
    if (in_quotes || c == '"') {
      if (c == '"') {
        in_quotes = !in_quotes;
        word.is_quoted = true;
      } else {
        word.text += c;
      }
    } else if (c == ',' || c == ';' || c == '\t') {
      end_word();
      if (!words.empty()) words.back().ends_field = true;
    } else if (std::isspace(static_cast<unsigned char>(c))) {
      end_word();
    } else {
      word.text += c;
    }
  }
  end_word();
  if (!words.empty()) words.back().ends_field = true;
  return words;
}

// Lists written on Windows have backslashes in paths.
fs::path path_of(const fs::path& folder, std::string text) {
  std::error_code ignored;
  if (text.find('\\') != std::string::npos && !fs::exists(folder / text, ignored)) {
    std::replace(text.begin(), text.end(), '\\', '/');
  }
  return folder / text;
}

std::optional<std::vector<ListedImage>> images_of(const std::vector<Word>& words, const fs::path& folder,
                                                  std::size_t count) {
  std::vector<ListedImage> images;
  auto word = words.begin();
  while (images.size() < count) {
    if (word == words.end()) return std::nullopt;
    const auto time = parse_number(word->text);
    if (!time || ++word == words.end()) return std::nullopt;
    // A name continues across spaces until it has an image extension or the field ends.
    std::string name = word->text;
    while (!word->is_quoted && !word->ends_field && !has_image_ending(name)) name += ' ' + (++word)->text;
    ++word;
    images.push_back({*time, path_of(folder, name)});
  }
  return images;
}

bool is_header(const std::vector<Word>& words) {
  return std::none_of(words.begin(), words.end(), [](const Word& word) {
    return parse_number(word.text) || has_image_ending(word.text);
  });
}

struct ListLine {
  int number = 0;  // Line number from 1.
  std::vector<ListedImage> images;
};

// Reads lines with `images_per_line` pairs of a time and a file name relative to `folder`. `name`
// is the list's name in messages.
Result<std::vector<ListLine>> parse_list(std::string_view text, const fs::path& folder,
                                         const std::string& name, std::size_t images_per_line) {
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: the list is encoded in UTF-16; save it as UTF-8", name));
  }
  std::vector<ListLine> lines;
  bool may_be_header = true;
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::vector<Word> words = words_of(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (words.empty() || words[0].text.starts_with('#')) continue;
    if (std::exchange(may_be_header, false) && is_header(words)) continue;
    auto images = images_of(words, folder, images_per_line);
    if (!images) {
      return fail(ErrorCode::kInvalid,
                  fmt::format("{}:{}: the line must have {}, as in TUM's RGB-D data sets", name, number,
                              images_per_line == 1 ? "a time and a file name"
                                                   : "a time, a file name, a time and a file name"));
    }
    lines.push_back({number, std::move(*images)});
  }
  return lines;
}

bool is_depth(const fs::path& relative, const fs::path& path) {
  const NamedKind named = kind_by_name(relative);
  return named.known ? named.kind == ImageKind::kDepth : holds_depth(path);
}

std::optional<std::string> read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  return std::string(std::istreambuf_iterator<char>(file), {});
}

Result<ListedStreams> from_associations(const fs::path& list, const std::string& text,
                                        const fs::path& folder) {
  auto lines = parse_list(text, folder, list.string(), 2);
  if (!lines) return fail(lines.error());
  ListedStreams found;
  found.has_tum_depth = true;
  for (ListLine& line : *lines) {
    const auto relative = [&](const ListedImage& image) { return image.path.lexically_relative(folder); };
    const bool depth_first = is_depth(relative(line.images[0]), line.images[0].path);
    if (depth_first == is_depth(relative(line.images[1]), line.images[1].path)) {
      return fail(
          ErrorCode::kInvalid,
          fmt::format(
              "{}:{}: the line must have one depth and one colour image, but neither names nor contents "
              "show which is which",
              list.string(), line.number));
    }
    ListedImage& color = line.images[depth_first ? 1 : 0];
    if (relative(color).string().find("rgb") == std::string::npos &&
        relative(color).string().find("colo") != std::string::npos) {
      // Data sets that write "color" instead of "rgb", such as OpenLORIS, store depth in
      // millimetres.
      found.has_tum_depth = false;
    }
    found.depth.push_back(std::move(line.images[depth_first ? 0 : 1]));
    found.color.push_back(std::move(color));
  }
  return found;
}

Result<std::vector<ListedImage>> from_list(const fs::path& list, const std::string& text,
                                           const fs::path& folder) {
  auto lines = parse_list(text, folder, list.string(), 1);
  if (!lines) return fail(lines.error());
  std::vector<ListedImage> images;
  for (ListLine& line : *lines) images.push_back(std::move(line.images[0]));
  return images;
}

Result<void> check_files(const ListedStreams& streams) {
  for (const auto* images : {&streams.depth, &streams.color}) {
    for (const ListedImage& image : *images) {
      std::error_code ignored;
      if (fs::is_regular_file(image.path, ignored)) continue;
      return fail(
          ErrorCode::kNotFound,
          fmt::format("{}: this image is in a list, but it does not exist; unpack the complete data set",
                      image.path.string()));
    }
  }
  return {};
}

}  // namespace

Result<std::optional<ListedStreams>> read_lists(const fs::path& folder, std::vector<std::string>& remarks) {
  for (const char* name : kAssociationNames) {
    const auto text = read(folder / name);
    if (!text) continue;
    auto found = from_associations(folder / name, *text, folder);
    if (!found) return fail(found.error());
    if (auto there = check_files(*found); !there) return fail(there.error());
    remarks.push_back(fmt::format("times and pairs from {}", name));
    return std::optional(std::move(*found));
  }
  std::optional<ListedStreams> found;
  for (const char* name : kDepthLists) {
    const auto text = read(folder / name);
    if (!text) continue;
    if (found) {
      remarks.push_back(fmt::format("left: {}", name));
      continue;
    }
    auto depth = from_list(folder / name, *text, folder);
    if (!depth) return fail(depth.error());
    found.emplace().depth = std::move(*depth);
    found->has_tum_depth = true;
    remarks.push_back(fmt::format("depth from {}", name));
  }
  for (const char* name : kColorLists) {
    const auto text = read(folder / name);
    if (!text) continue;
    if (!found) {
      return fail(
          ErrorCode::kNotFound,
          fmt::format(
              "{}: it lists colour, but there is no depth.txt next to it; unpack the complete data set",
              (folder / name).string()));
    }
    if (!found->color.empty()) {
      remarks.push_back(fmt::format("left: {}", name));
      continue;
    }
    auto color = from_list(folder / name, *text, folder);
    if (!color) return fail(color.error());
    found->color = std::move(*color);
    found->has_tum_depth = std::string_view(name) == "rgb.txt";
    remarks.push_back(fmt::format("colour from {}", name));
  }
  if (found) {
    if (auto there = check_files(*found); !there) return fail(there.error());
  }
  return found;
}

}  // namespace copresence::record
