#include "tools/record/image_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <iterator>
#include <optional>
#include <utility>

namespace copresence::record {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
constexpr std::string_view kEndings[] = {".png",  ".jpg", ".jpeg", ".pgm", ".ppm", ".pnm",  ".pfm", ".tif",
                                         ".tiff", ".bmp", ".webp", ".exr", ".npy", ".heic", ".jp2", ".gif"};

// A word of a line, and whether a comma, a semicolon or a tab follows it.
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

// Windows writes folders with backslashes.
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
    // A name goes on over spaces until it ends like an image's, or its field ends.
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

}  // namespace

bool has_image_ending(const fs::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(std::begin(kEndings), std::end(kEndings), ending) != std::end(kEndings);
}

Result<std::vector<ListLine>> parse_list(std::string_view text, const fs::path& folder,
                                         const std::string& name, std::size_t images_per_line) {
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) {
    return fail(ErrorCode::kInvalid, fmt::format("{}: a UTF-16 text; save it as UTF-8", name));
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
                  fmt::format("{}:{}: not {}; give lists as TUM's RGB-D sets have them", name, number,
                              images_per_line == 1 ? "a time and a file's name"
                                                   : "a time, a file's name, a time and a file's name"));
    }
    lines.push_back({number, std::move(*images)});
  }
  return lines;
}

}  // namespace copresence::record
