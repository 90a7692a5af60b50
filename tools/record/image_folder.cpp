#include "tools/record/image_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>

namespace copresence::record {
namespace {

namespace fs = std::filesystem;

constexpr const char* kAssociationNames[] = {"associations.txt", "association.txt", "associated.txt",
                                             "associate.txt", "assoc.txt"};

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool is_image(const fs::path& path) {
  const std::string ending = lower(path.extension().string());
  return ending == ".png" || ending == ".jpg" || ending == ".jpeg";
}

bool is_depth(const fs::path& relative) {
  return lower(relative.string()).find("depth") != std::string::npos;
}

std::optional<double> number(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != 0 || !std::isfinite(value)) return std::nullopt;
  return value;
}

// Words of each line that is no comment, with the line's number.
struct Line {
  int number = 0;
  std::vector<std::string> words;
};

std::vector<Line> lines_of(std::string_view text) {
  std::vector<Line> lines;
  std::istringstream in{std::string(text)};
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream words(line);
    Line parsed{number, {std::istream_iterator<std::string>(words), {}}};
    if (!parsed.words.empty() && parsed.words[0][0] != '#') lines.push_back(std::move(parsed));
  }
  return lines;
}

tl::unexpected<Error> bad_line(const std::string& name, int line, const char* expected) {
  return fail(ErrorCode::kInvalid,
              fmt::format("{}:{}: not {}; give lists as TUM's RGB-D sets have them", name, line, expected));
}

void sort(std::vector<TimedImage>& images) {
  std::stable_sort(images.begin(), images.end(),
                   [](const TimedImage& a, const TimedImage& b) { return a.time_s < b.time_s; });
}

std::optional<std::string> read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  return std::string(std::istreambuf_iterator<char>(file), {});
}

// A name that is a time, else its last group of digits as a frame's number, else its place among the others.
double time_of(const fs::path& path, std::size_t place, double frames_per_second) {
  const std::string stem = path.stem().string();
  const auto point = stem.find('.');
  if (point != std::string::npos && point >= 6) {
    if (const auto seconds = number(stem); seconds && std::isdigit(static_cast<unsigned char>(stem[0]))) {
      return *seconds;
    }
  }
  const auto last = stem.find_last_of("0123456789");
  if (last == std::string::npos) return static_cast<double>(place) / frames_per_second;
  const auto before = stem.find_last_not_of("0123456789", last);
  const auto first = before == std::string::npos ? 0 : before + 1;
  return number(stem.substr(first, last - first + 1)).value_or(0) / frames_per_second;
}

ImageFolder by_names(const fs::path& folder, double frames_per_second) {
  std::vector<fs::path> paths;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    if (entry.is_regular_file(ignored) && is_image(entry.path())) paths.push_back(entry.path());
    if (!entry.is_directory(ignored)) continue;
    for (const auto& inner : fs::directory_iterator(entry.path(), ignored)) {
      if (inner.is_regular_file(ignored) && is_image(inner.path())) paths.push_back(inner.path());
    }
  }
  std::sort(paths.begin(), paths.end());
  ImageFolder images;
  for (const fs::path& path : paths) {
    auto& list = is_depth(path.lexically_relative(folder)) ? images.depth : images.color;
    list.push_back({path, time_of(path, list.size(), frames_per_second)});
  }
  sort(images.depth);
  sort(images.color);
  return images;
}

// ICL-NUIM's lists say a frame's number where TUM's say its time.
void time_numbered_frames(ImageFolder& images, double frames_per_second) {
  constexpr double kLargestNumber = 1e6;  // times are seconds since 1970
  for (const auto* list : {&images.depth, &images.color}) {
    for (const TimedImage& image : *list) {
      if (image.time_s != std::floor(image.time_s) || image.time_s > kLargestNumber) return;
    }
  }
  for (auto* list : {&images.depth, &images.color}) {
    for (TimedImage& image : *list) image.time_s /= frames_per_second;
  }
}

Result<void> check_there(const std::vector<TimedImage>& images) {
  for (const TimedImage& image : images) {
    std::error_code ignored;
    if (!fs::is_regular_file(image.path, ignored)) {
      return fail(ErrorCode::kNotFound,
                  fmt::format("{}: a list names this image, but it is not there; unpack the whole set",
                              image.path.string()));
    }
  }
  return {};
}

}  // namespace

Result<std::vector<TimedImage>> parse_list(std::string_view text, const fs::path& folder,
                                           const std::string& name) {
  std::vector<TimedImage> images;
  for (const Line& line : lines_of(text)) {
    const auto time = number(line.words[0]);
    if (!time || line.words.size() != 2) return bad_line(name, line.number, "a time and a file's name");
    images.push_back({folder / line.words[1], *time});
  }
  sort(images);
  return images;
}

Result<ImageFolder> parse_associations(std::string_view text, const fs::path& folder,
                                       const std::string& name) {
  ImageFolder images;
  images.has_lists = true;
  for (const Line& line : lines_of(text)) {
    if (line.words.size() != 4 || !number(line.words[0]) || !number(line.words[2])) {
      return bad_line(name, line.number, "a time, a file's name, a time and a file's name");
    }
    const TimedImage first{folder / line.words[1], *number(line.words[0])};
    const TimedImage second{folder / line.words[3], *number(line.words[2])};
    const bool depth_first = is_depth(line.words[1]);
    if (depth_first == is_depth(line.words[3])) {
      return bad_line(name, line.number, "one image with \"depth\" in its name and one without");
    }
    images.depth.push_back(depth_first ? first : second);
    images.color.push_back(depth_first ? second : first);
  }
  for (auto* list : {&images.depth, &images.color}) {
    sort(*list);
    // One picture may be in several pairs.
    list->erase(std::unique(list->begin(), list->end()), list->end());
  }
  return images;
}

Result<ImageFolder> find_images(const fs::path& folder, double frames_per_second) {
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) {
    return fail(ErrorCode::kNotFound,
                fmt::format("{}: no such folder; give a folder of images", folder.string()));
  }
  Result<ImageFolder> images = ImageFolder();
  for (const char* name : kAssociationNames) {
    if (const auto text = read(folder / name)) {
      images = parse_associations(*text, folder, (folder / name).string());
      if (!images) return images;
      break;
    }
  }
  if (!images->has_lists) {
    if (const auto depth_text = read(folder / "depth.txt")) {
      auto depth = parse_list(*depth_text, folder, (folder / "depth.txt").string());
      if (!depth) return fail(depth.error());
      images->depth = std::move(*depth);
      images->has_lists = true;
      if (const auto color_text = read(folder / "rgb.txt")) {
        auto color = parse_list(*color_text, folder, (folder / "rgb.txt").string());
        if (!color) return fail(color.error());
        images->color = std::move(*color);
      }
    } else if (fs::is_regular_file(folder / "rgb.txt", ignored)) {
      return fail(
          ErrorCode::kNotFound,
          fmt::format("{}: it lists colour, but there is no depth.txt beside it; unpack the whole set",
                      (folder / "rgb.txt").string()));
    } else {
      images = by_names(folder, frames_per_second);
    }
  }
  if (images->has_lists) time_numbered_frames(*images, frames_per_second);
  for (const auto* list : {&images->depth, &images->color}) {
    if (auto there = check_there(*list); !there) return fail(there.error());
  }
  if (images->depth.empty()) {
    return fail(
        ErrorCode::kNotFound,
        fmt::format("{}: no depth image is in it: none of its lists names one, and no PNG has \"depth\" in "
                    "its name or its folder's",
                    folder.string()));
  }
  return images;
}

}  // namespace copresence::record
