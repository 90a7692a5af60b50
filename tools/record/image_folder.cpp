#include "tools/record/image_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <set>

#include "tools/pictures/picture_header.h"
#include "tools/record/image_groups.h"
#include "tools/record/image_list.h"
#include "tools/record/name_times.h"

namespace copresence::record {
namespace {

namespace fs = std::filesystem;
using std::chrono::microseconds;

constexpr const char* kAssociationNames[] = {"associations.txt", "association.txt", "associated.txt",
                                             "associate.txt", "assoc.txt"};
constexpr const char* kDepthLists[] = {"aligned_depth.txt", "depth.txt"};
constexpr const char* kColorLists[] = {"rgb.txt", "color.txt", "colour.txt"};

// Depth and colour farther apart than this were not taken together.
constexpr microseconds kFarthestApart = std::chrono::seconds(10);

// Images with the numbers that stand for their times.
using Listed = std::vector<ListedImage>;

struct FoundImages {
  Listed depth, color;
  bool has_tum_depth = false;
  std::optional<TimeScale> depth_scale, color_scale;  ///< where the way to find the numbers has decided it
};

std::optional<std::string> read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  return std::string(std::istreambuf_iterator<char>(file), {});
}

bool is_depth(const fs::path& relative, const fs::path& path) {
  const NamedKind named = kind_by_name(relative);
  return named.known ? named.kind == ImageKind::kDepth : holds_depth(path);
}

Result<FoundImages> from_associations(const fs::path& list, const std::string& text, const fs::path& folder) {
  auto lines = parse_list(text, folder, list.string(), 2);
  if (!lines) return fail(lines.error());
  FoundImages found;
  found.has_tum_depth = true;
  for (ListLine& line : *lines) {
    const auto relative = [&](const ListedImage& image) { return image.path.lexically_relative(folder); };
    const bool depth_first = is_depth(relative(line.images[0]), line.images[0].path);
    if (depth_first == is_depth(relative(line.images[1]), line.images[1].path)) {
      return fail(
          ErrorCode::kInvalid,
          fmt::format("{}:{}: not one depth image and one colour image: by neither their names nor their "
                      "contents is one depth and the other not",
                      list.string(), line.number));
    }
    ListedImage& color = line.images[depth_first ? 1 : 0];
    if (relative(color).string().find("rgb") == std::string::npos &&
        relative(color).string().find("colo") != std::string::npos) {
      found.has_tum_depth = false;  // OpenLORIS and others that write "color" have millimetres
    }
    found.depth.push_back(std::move(line.images[depth_first ? 0 : 1]));
    found.color.push_back(std::move(color));
  }
  return found;
}

Result<Listed> from_list(const fs::path& list, const std::string& text, const fs::path& folder) {
  auto lines = parse_list(text, folder, list.string(), 1);
  if (!lines) return fail(lines.error());
  Listed images;
  for (ListLine& line : *lines) images.push_back(std::move(line.images[0]));
  return images;
}

Result<void> check_there(const Listed& images) {
  for (const ListedImage& image : images) {
    std::error_code ignored;
    if (!fs::is_regular_file(image.path, ignored)) {
      return fail(ErrorCode::kNotFound,
                  fmt::format("{}: a list names this image, but it is not there; unpack the whole set",
                              image.path.string()));
    }
  }
  return {};
}

// Nothing where the folder has no list.
Result<std::optional<FoundImages>> from_lists(const fs::path& folder, std::vector<std::string>& remarks) {
  for (const char* name : kAssociationNames) {
    const auto text = read(folder / name);
    if (!text) continue;
    auto found = from_associations(folder / name, *text, folder);
    if (!found) return fail(found.error());
    remarks.push_back(fmt::format("times and pairs from {}", name));
    return std::optional(std::move(*found));
  }
  std::optional<FoundImages> found;
  std::error_code ignored;
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
          fmt::format("{}: it lists colour, but there is no depth.txt beside it; unpack the whole set",
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
  return found;
}

std::string counted(const ImageGroup& group) {
  return fmt::format("{} ({} images)", group.label, group.paths.size());
}

void remark_on_rest(const FolderContent& content, const std::set<fs::path>& taken,
                    std::vector<std::string>& remarks) {
  std::string left;
  const auto add = [&](const std::string& what) { left += (left.empty() ? "" : ", ") + what; };
  for (const ImageGroup& group : content.groups) {
    const auto rest = static_cast<std::size_t>(std::count_if(
        group.paths.begin(), group.paths.end(), [&](const fs::path& path) { return !taken.contains(path); }));
    if (rest == group.paths.size()) {
      add(counted(group));
    } else if (rest > 0) {
      add(fmt::format("{} of the {} images of {}", rest, group.paths.size(), group.label));
    }
  }
  if (content.hidden) add(fmt::format("{} hidden files of another system", content.hidden));
  if (!left.empty()) remarks.push_back("left: " + left);
}

Result<FoundImages> by_names(const fs::path& folder, const FolderContent& content, const FolderChoice& choice,
                             std::vector<std::string>& remarks) {
  const auto depth = choose(content, ImageKind::kDepth, choice.depth, folder.string());
  if (!depth) return fail(depth.error());
  const auto color = choose(content, ImageKind::kColor, choice.color, folder.string());
  if (!color) return fail(color.error());
  FoundImages found;
  if (!*depth) return found;
  const auto take = [&](const ImageGroup& group, Listed& list,
                        std::optional<TimeScale>& scale) -> Result<void> {
    auto named = times_of_names(group.paths, choice.times, choice.frames_per_second);
    if (!named)
      return fail(named.error().code,
                  fmt::format("{}: {}", (folder / group.label).string(), named.error().what));
    list = std::move(named->images);
    scale = named->scale;
    return {};
  };
  remarks.push_back("depth: " + counted(**depth));
  if (auto taken = take(**depth, found.depth, found.depth_scale); !taken) return fail(taken.error());
  if (*color && *color != *depth) {
    remarks.push_back("colour: " + counted(**color));
    if (auto taken = take(**color, found.color, found.color_scale); !taken) return fail(taken.error());
  }
  return found;
}

std::vector<TimeNumber> numbers_of(const Listed& images) {
  std::vector<TimeNumber> numbers;
  for (const ListedImage& image : images) numbers.push_back(image.time);
  return numbers;
}

Result<TimeScale> scale_of(const Listed& images, const FolderChoice& choice, const fs::path& folder) {
  const auto numbers = numbers_of(images);
  if (choice.times) return given_times(numbers, *choice.times);
  auto scale = recognise_times(numbers, choice.frames_per_second);
  if (!scale) return fail(scale.error().code, fmt::format("{}: {}", folder.string(), scale.error().what));
  return scale;
}

Result<std::vector<TimedImage>> timed(const Listed& listed, TimeUnit unit, double frames_per_second) {
  std::vector<TimedImage> images;
  for (const ListedImage& image : listed) {
    const auto time = to_time(image.time, unit, frames_per_second);
    if (!time) return fail(time.error().code, fmt::format("{}: {}", image.path.string(), time.error().what));
    images.push_back({image.path, *time});
  }
  std::stable_sort(images.begin(), images.end(),
                   [](const TimedImage& a, const TimedImage& b) { return a.time < b.time; });
  // One picture may be in several pairs.
  images.erase(std::unique(images.begin(), images.end()), images.end());
  return images;
}

Result<void> check_together(const ImageFolder& images, const fs::path& folder) {
  if (images.depth.empty() || images.color.empty()) return {};
  const microseconds apart = std::max(images.color.front().time - images.depth.back().time,
                                      images.depth.front().time - images.color.back().time);
  if (apart <= kFarthestApart) return {};
  const auto seconds = [](microseconds time) { return static_cast<double>(time.count()) * 1e-6; };
  return fail(
      ErrorCode::kInvalid,
      fmt::format(
          "{}: depth lies from {:.3f} to {:.3f} s and colour from {:.3f} to {:.3f} s, so they were not "
          "taken together or their times differ in unit; give --times, or lists of pairs",
          folder.string(), seconds(images.depth.front().time), seconds(images.depth.back().time),
          seconds(images.color.front().time), seconds(images.color.back().time)));
}

tl::unexpected<Error> no_depth(const fs::path& folder, const FolderContent& content) {
  for (const ImageGroup& group : content.groups) {
    const auto header = pictures::read_header(group.paths.front());
    if (!header && header.error().code == ErrorCode::kUnsupported) return fail(header.error());
  }
  std::error_code ignored;
  fs::recursive_directory_iterator inner(folder, fs::directory_options::skip_permission_denied, ignored), end;
  for (int looked = 0; inner != end && looked < 10'000; inner.increment(ignored), ++looked) {
    if (inner.depth() >= 2 && content.groups.empty() && has_image_ending(inner->path())) {
      return fail(
          ErrorCode::kNotFound,
          fmt::format("{}: its images lie deeper, in {}; give the folder that holds the depth and the colour "
                      "images or their two folders",
                      folder.string(), inner->path().parent_path().string()));
    }
  }
  return fail(
      ErrorCode::kNotFound,
      fmt::format("{}: no depth image is in it: none of its lists names one, and no image of one channel and "
                  "16 bits lies in it or in its folders",
                  folder.string()));
}

}  // namespace

Result<ImageFolder> find_images(const fs::path& given, const FolderChoice& choice) {
  std::error_code ignored;
  if (!fs::is_directory(given, ignored)) {
    return fail(ErrorCode::kNotFound,
                fmt::format("{}: no such folder; give a folder of images", given.string()));
  }
  const fs::path folder = given.has_filename() ? given : given.parent_path();
  ImageFolder images;
  const FolderContent content = list_images(folder);
  const bool asked_for_names = !choice.depth.empty() || !choice.color.empty();
  Result<std::optional<FoundImages>> listed = std::optional<FoundImages>();
  if (!asked_for_names) listed = from_lists(folder, images.remarks);
  if (!listed) return fail(listed.error());
  FoundImages found;
  if (*listed) {
    found = std::move(**listed);
    for (const auto* list : {&found.depth, &found.color}) {
      if (auto there = check_there(*list); !there) return fail(there.error());
    }
  } else {
    auto named = by_names(folder, content, choice, images.remarks);
    if (!named) return fail(named.error());
    found = std::move(*named);
  }
  if (found.depth.empty()) return no_depth(folder, content);

  if (!found.depth_scale) {
    auto scale = scale_of(found.depth, choice, folder);
    if (!scale) return fail(scale.error());
    found.depth_scale = *scale;
  }
  const TimeScale scale = *found.depth_scale;
  if (found.color_scale && found.color_scale->unit != scale.unit && found.color.size() > 1 &&
      found.depth.size() > 1) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format("{}: depth has {} in its names and colour {}, so that it is not known which were taken "
                    "together; give lists of pairs (associations.txt), or --times",
                    folder.string(), name(scale.unit), name(found.color_scale->unit)));
  }
  images.has_tum_depth = found.has_tum_depth;
  images.unit = scale.unit;
  images.since_1970 = scale.since_1970;
  auto depth = timed(found.depth, scale.unit, choice.frames_per_second);
  if (!depth) return fail(depth.error());
  auto color = timed(found.color, scale.unit, choice.frames_per_second);
  if (!color) return fail(color.error());
  images.depth = std::move(*depth);
  images.color = std::move(*color);
  if (auto together = check_together(images, folder); !together) return fail(together.error());

  std::set<fs::path> taken;
  for (const auto* list : {&images.depth, &images.color}) {
    for (const TimedImage& image : *list) taken.insert(image.path.lexically_normal());
  }
  remark_on_rest(content, taken, images.remarks);
  return images;
}

}  // namespace copresence::record
