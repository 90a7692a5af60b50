#include "tools/record/image_groups.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <initializer_list>
#include <map>
#include <optional>
#include <string_view>
#include <tuple>

#include "tools/pictures/picture_header.h"

namespace copresence::record {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kEndings[] = {".png",  ".jpg", ".jpeg", ".pgm", ".ppm", ".pnm",  ".pfm", ".tif",
                                         ".tiff", ".bmp", ".webp", ".exr", ".npy", ".heic", ".jp2", ".gif"};

// Lower-case words in names. Whole words are compared, because many other words contain "ir".
constexpr std::string_view kOtherWords[] = {
    "mask",      "masks",      "label",     "labels",      "seg",       "segmentation", "semantic",
    "semantics", "instance",   "instances", "normal",      "normals",   "ir",           "infrared",
    "infra",     "nir",        "panoptic",  "confidence",  "conf",      "amplitude",    "intensity",
    "fisheye",   "thermal",    "flow",      "vis",         "visual",    "preview",      "thumb",
    "thumbnail", "thumbnails", "overlay",   "heatmap",     "colormap",  "colorized",    "pseudo",
    "edges",     "disparity",  "albedo",    "uncertainty", "grayscale", "visualization"};
constexpr std::string_view kDepthWords[] = {"depth", "depths", "dpt", "depthmap", "depthmaps", "dep"};
constexpr std::string_view kColorWords[] = {"color",  "colors", "colour", "rgb",   "bgr",   "image",
                                            "images", "img",    "imgs",   "photo", "photos"};
// Words for depth registered to the colour camera, and for images computed from measurements.
constexpr std::string_view kAlignedWords[] = {"aligned", "registered", "reg"};
constexpr std::string_view kComputedWords[] = {
    "filled",  "inpaint",   "inpainted", "completed",    "completion", "dense",
    "pred",    "predicted", "estimated", "rendered",     "render",     "gt",
    "refined", "smooth",    "smoothed",  "filtered",     "denoised",   "raw",
    "noisy",   "mono",      "fill",      "interpolated", "undistorted"};

constexpr int kRankAligned = 0, kRankPlain = 1, kRankLoose = 2, kRankComputed = 3, kRankByContent = 4;

template <std::size_t N>
bool is_in(const std::string_view (&words)[N], const std::string& word) {
  return std::find(std::begin(words), std::end(words), word) != std::end(words);
}

// Splits a name: "alignedDepth_0012.left" has the words aligned, depth and left.
std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words;
  bool begins = true, was_lower = false;
  for (const char c : text) {
    const auto letter = static_cast<unsigned char>(c);
    if (!std::isalpha(letter)) {
      begins = true;
      continue;
    }
    if (begins || (std::isupper(letter) && was_lower)) words.emplace_back();
    words.back() += static_cast<char>(std::tolower(letter));
    was_lower = std::islower(letter);
    begins = false;
  }
  return words;
}

std::optional<ImageKind> kind_of_word(const std::string& word) {
  if (is_in(kOtherWords, word)) return ImageKind::kOther;
  if (is_in(kDepthWords, word) || word.find("depth") != std::string::npos) return ImageKind::kDepth;
  if (is_in(kColorWords, word)) return ImageKind::kColor;
  return std::nullopt;
}

enum class Content { kDepth, kColor, kGrey, kPalette, kUnreadable };

Content content_of(const fs::path& path) {
  const auto header = pictures::read_header(path);
  if (!header) return Content::kUnreadable;
  if (header->is_palette) return Content::kPalette;
  if (header->channels >= 3) return Content::kColor;
  return header->bits >= 16 ? Content::kDepth : Content::kGrey;
}

// The kind of a group. `content` is the content of its first readable image.
ImageKind kind_of(const NamedKind& named, Content content) {
  if (!named.known) {
    return content == Content::kDepth   ? ImageKind::kDepth
           : content == Content::kColor ? ImageKind::kColor
                                        : ImageKind::kOther;
  }
  if (named.kind == ImageKind::kColor && content == Content::kDepth) return ImageKind::kOther;
  return named.kind;
}

int rank_of(const fs::path& relative, const NamedKind& named, Content content) {
  if (!named.known) return kRankByContent;
  int rank = kRankPlain;
  for (const std::string& part : {relative.parent_path().string(), relative.stem().string()}) {
    for (const std::string& word : words_of(part)) {
      if (is_in(kAlignedWords, word)) rank = std::min(rank, kRankAligned);
      if (is_in(kComputedWords, word)) rank = kRankComputed;
      if ((word.starts_with("image") || word.starts_with("img")) && rank == kRankPlain) rank = kRankLoose;
    }
  }
  // The content contradicts the name, as for a visualisation of depth. Such a group is chosen only
  // if there is nothing else, and is then reported.
  if (named.kind == ImageKind::kDepth && content != Content::kDepth) return kRankByContent + 1;
  if (named.kind == ImageKind::kColor && content != Content::kColor) return kRankByContent + 1;
  return rank;
}

std::string pattern_of(const fs::path& path) {
  std::string pattern;
  for (const char c : path.filename().string()) {
    const bool is_digit = std::isdigit(static_cast<unsigned char>(c));
    if (!is_digit) pattern += c;
    if (is_digit && !pattern.ends_with('*')) pattern += '*';
  }
  return pattern;
}

bool is_hidden(const fs::path& path) {
  const std::string name = path.filename().string();
  return name.starts_with('.') || name == "__MACOSX" || name == "Thumbs.db" || name == "desktop.ini";
}

// Adds the images of a folder to `images` and counts hidden files in `hidden`. Ignores subfolders.
void list(const fs::path& folder, std::vector<fs::path>& images, std::size_t& hidden) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    if (!entry.is_regular_file(ignored)) continue;
    if (is_hidden(entry.path())) {
      ++hidden;
    } else if (has_image_ending(entry.path())) {
      images.push_back(entry.path());
    }
  }
}

// Returns the words in a file name that distinguish groups: "depth_left_1" and "depth_right_1"
// belong to different groups. Names that differ in other words belong to the same group.
std::string distinguishing_words(const fs::path& relative) {
  std::string words;
  for (const std::string& word : words_of(relative.stem().string())) {
    const bool distinguishes = word == "d" || word == "r" || kind_of_word(word) ||
                               is_in(kAlignedWords, word) || is_in(kComputedWords, word) || word == "left" ||
                               word == "right";
    if (distinguishes) words += word + ' ';
  }
  return words;
}

}  // namespace

NamedKind kind_by_name(const fs::path& relative) {
  std::vector<std::string> parts{relative.stem().string()};
  for (fs::path parent = relative.parent_path(); !parent.empty(); parent = parent.parent_path()) {
    parts.push_back(parent.filename().string());
    if (parent == parent.parent_path()) break;
  }
  // A word for another kind, such as mask, decides in any part of the path.
  for (const std::string& part : parts) {
    for (const std::string& word : words_of(part)) {
      if (kind_of_word(word) == ImageKind::kOther) return {ImageKind::kOther, true};
    }
  }
  for (const std::string& part : parts) {
    for (const std::string& word : words_of(part)) {
      if (const auto kind = kind_of_word(word)) return {*kind, true};
    }
  }
  // File names of NYU and fakenect: "d-1294886362.665769-...pgm" and "r-...ppm".
  const std::string& stem = parts.front();
  const bool is_letter_and_number =
      stem.size() > 1 && stem.find_first_of("0123456789") == stem.find_first_not_of("-_", 1);
  if (is_letter_and_number && (stem[0] == 'd' || stem[0] == 'D')) return {ImageKind::kDepth, true};
  if (is_letter_and_number && (stem[0] == 'r' || stem[0] == 'R')) return {ImageKind::kColor, true};
  return {};
}

bool has_image_ending(const fs::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(std::begin(kEndings), std::end(kEndings), ending) != std::end(kEndings);
}

bool holds_depth(const fs::path& path) {
  return content_of(path) == Content::kDepth;
}

FolderContent list_images(const fs::path& folder) {
  FolderContent content;
  std::vector<fs::path> images;
  list(folder, images, content.hidden);
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    if (!entry.is_directory(ignored)) continue;
    std::vector<fs::path> inner;
    list(entry.path(), inner, content.hidden);
    if (is_hidden(entry.path())) {
      content.hidden += inner.size();
    } else {
      images.insert(images.end(), inner.begin(), inner.end());
    }
  }
  std::sort(images.begin(), images.end());

  using Key = std::tuple<std::string, std::string, Content>;
  std::map<Key, std::vector<fs::path>> by_key;
  std::map<std::string, std::size_t> groups_in;
  for (const fs::path& path : images) {
    const fs::path relative = path.lexically_relative(folder);
    const bool is_named = kind_by_name(relative).known;
    // If the path has no known word, groups are divided by content. If it has one, an image with
    // other content is reported as an error.
    const Content kind = is_named ? Content::kUnreadable : content_of(path);
    auto& paths = by_key[{relative.parent_path().string(), distinguishing_words(relative), kind}];
    if (paths.empty()) ++groups_in[relative.parent_path().string()];
    paths.push_back(path);
  }
  for (auto& [key, paths] : by_key) {
    const fs::path relative = paths.front().lexically_relative(folder);
    const NamedKind named = kind_by_name(relative);
    Content first = Content::kUnreadable;
    for (auto path = paths.begin(); path != paths.end() && first == Content::kUnreadable; ++path) {
      first = content_of(*path);
    }
    ImageGroup group;
    group.folder = std::get<0>(key);
    group.kind = kind_of(named, first);
    group.rank = rank_of(relative, named, first);
    const bool is_alone = !group.folder.empty() && groups_in[group.folder] == 1;
    group.label = is_alone ? group.folder + '/' : (fs::path(group.folder) / pattern_of(relative)).string();
    group.paths = std::move(paths);
    content.groups.push_back(std::move(group));
  }
  return content;
}

Result<const ImageGroup*> choose(const FolderContent& content, ImageKind kind, const std::string& wanted,
                                 const std::string& folder) {
  const std::string flag = kind == ImageKind::kDepth ? "--depth" : "--color";
  const std::string what = kind == ImageKind::kDepth ? "depth" : "colour";
  std::vector<const ImageGroup*> best;
  for (const ImageGroup& group : content.groups) {
    if (!wanted.empty()) {
      const bool matches = group.label == wanted || group.folder == wanted || group.label == wanted + '/' ||
                           group.folder + '/' == wanted;
      if (matches && (group.label == wanted || group.kind == kind || best.empty())) {
        if (!best.empty() && best.front()->kind != kind) best.clear();
        best.push_back(&group);
      }
      continue;
    }
    if (group.kind != kind || (!best.empty() && group.rank > best.front()->rank)) continue;
    if (!best.empty() && group.rank < best.front()->rank) best.clear();
    best.push_back(&group);
  }
  if (best.empty() && !wanted.empty()) {
    return fail(
        ErrorCode::kNotFound,
        fmt::format(
            "{0}: there are no images called \"{2}\", which {1} names; give the name of a folder in it",
            folder, flag, wanted));
  }
  if (best.size() > 1) {
    std::string labels;
    for (const ImageGroup* group : best) labels += (labels.empty() ? "" : ", ") + group->label;
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: several groups of images could be {}: {}; choose one with {} {}", folder,
                            what, labels, flag, best.front()->label));
  }
  return best.empty() ? nullptr : best.front();
}

}  // namespace copresence::record
