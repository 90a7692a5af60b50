#include "tools/record/image_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "tools/pictures/picture_header.h"
#include "tools/record/image_groups.h"
#include "tools/record/image_list.h"
#include "tools/record/name_times.h"

namespace copresence::record {
namespace {

namespace fs = std::filesystem;
using std::chrono::microseconds;

// Depth and colour that are farther apart in time do not belong together.
constexpr microseconds kFarthestApart = std::chrono::seconds(10);

using Listed = std::vector<ListedImage>;

struct FoundImages {
  ListedStreams streams;
  std::optional<TimeScale> depth_scale, color_scale;  // Time scales, if the names determine them.
};

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
  if (content.hidden) add(fmt::format("{} hidden files of an operating system", content.hidden));
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
  if (auto taken = take(**depth, found.streams.depth, found.depth_scale); !taken) return fail(taken.error());
  if (*color && *color != *depth) {
    remarks.push_back("colour: " + counted(**color));
    if (auto taken = take(**color, found.streams.color, found.color_scale); !taken)
      return fail(taken.error());
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
  // An image may be in several pairs.
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
      fmt::format("{}: depth is from {:.3f} to {:.3f} s and colour from {:.3f} to {:.3f} s, so they were not "
                  "taken together or their times have different units; give --times, or lists of pairs",
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
          fmt::format(
              "{}: the images are in deeper folders, such as {}; give the folder that contains the depth and "
              "colour images, or one folder of each",
              folder.string(), inner->path().parent_path().string()));
    }
  }
  return fail(
      ErrorCode::kNotFound,
      fmt::format(
          "{}: there is no depth image: no list names one, and neither the folder nor its subfolders contain "
          "an image with one channel of 16 bits",
          folder.string()));
}

}  // namespace

Result<ImageFolder> find_images(const fs::path& given, const FolderChoice& choice) {
  std::error_code ignored;
  if (!fs::is_directory(given, ignored)) {
    return fail(ErrorCode::kNotFound,
                fmt::format("{}: there is no such folder; give a folder of images", given.string()));
  }
  const fs::path folder = given.has_filename() ? given : given.parent_path();
  ImageFolder images;
  const FolderContent content = list_images(folder);
  const bool asked_for_names = !choice.depth.empty() || !choice.color.empty();
  Result<std::optional<ListedStreams>> listed = std::optional<ListedStreams>();
  if (!asked_for_names) listed = read_lists(folder, images.remarks);
  if (!listed) return fail(listed.error());
  FoundImages found;
  if (*listed) {
    found.streams = std::move(**listed);
  } else {
    auto named = by_names(folder, content, choice, images.remarks);
    if (!named) return fail(named.error());
    found = std::move(*named);
  }
  if (found.streams.depth.empty()) return no_depth(folder, content);

  if (!found.depth_scale) {
    auto scale = scale_of(found.streams.depth, choice, folder);
    if (!scale) return fail(scale.error());
    found.depth_scale = *scale;
  }
  const TimeScale scale = *found.depth_scale;
  if (found.color_scale && found.color_scale->unit != scale.unit && found.streams.color.size() > 1 &&
      found.streams.depth.size() > 1) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format(
            "{}: the names of depth images have {} and those of colour images {}, so they cannot be paired; "
            "give a list of pairs (associations.txt), or --times",
            folder.string(), name(scale.unit), name(found.color_scale->unit)));
  }
  images.has_tum_depth = found.streams.has_tum_depth;
  images.unit = scale.unit;
  images.since_1970 = scale.since_1970;
  auto depth = timed(found.streams.depth, scale.unit, choice.frames_per_second);
  if (!depth) return fail(depth.error());
  auto color = timed(found.streams.color, scale.unit, choice.frames_per_second);
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
