#include "tools/record/settings.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>

#include "common/command_line/mistakes.h"
#include "common/command_line/values.h"

namespace copresence::record {
namespace {

constexpr const char* kOverwrite =
    "replace the file of --out where it exists; without it an existing file is kept";

}  // namespace

tl::expected<Settings, int> read_command_line(int argc, const char* const* argv) {
  using namespace command_line;
  CLI::App app{"Looks into recordings of depth cameras (.oni), repairs, cuts and makes them.", "record"};
  app.set_version_flag("--version", std::string("record ") + COPRESENCE_VERSION);
  app.require_subcommand(1);

  InfoSettings info;
  auto* info_command =
      app.add_subcommand("info", "what a recording holds: streams, rate, gaps, holes, levels");
  info_command->add_option("FILE.oni", info.recording, "the recording")->required()->check(file_name());
  info_command->add_flag("--json", info.json, "as JSON on standard output");

  RepairSettings repair;
  auto* repair_command =
      app.add_subcommand("repair", "finishes a recording that was cut off; every whole frame is kept");
  repair_command->add_option("FILE.oni", repair.recording, "the recording, changed in place")
      ->required()
      ->check(file_name());
  repair_command
      ->add_option("--out", repair.out,
                   "write the whole recording here and leave FILE.oni as it is; needed where it is "
                   "damaged in the middle")
      ->check(file_name());
  repair_command->add_flag("--overwrite", repair.overwrite, kOverwrite);

  CutSettings cut;
  auto* cut_command = app.add_subcommand("cut", "copies a part of a recording, pictures unchanged");
  cut_command->add_option("FILE.oni", cut.recording, "the recording")->required()->check(file_name());
  cut_command->add_option("--from", cut.from_s, "seconds after the recording's first frame [0]")
      ->check(number(0, 1e6));
  cut_command
      ->add_option("--to", cut.to_s, "seconds after the recording's first frame, not included [its end]")
      ->check(number(0, 1e6));
  cut_command->add_option("--out", cut.out, "the part")->required()->check(file_name());
  cut_command->add_flag("--overwrite", cut.overwrite, kOverwrite);

  FromImagesSettings images;
  Intrinsics intrinsics;
  std::vector<double> distortion;
  auto* images_command = app.add_subcommand(
      "from-images",
      "makes a recording of a folder of images: depth as 16-bit PNG, PGM or TIFF or as floating-point TIFF "
      "or PFM, "
      "colour as JPEG, PNG, PPM or TIFF. Times and pairs come from associations.txt, or depth.txt and "
      "rgb.txt or "
      "color.txt, else from the names. What is depth and what is colour is recognised by names and contents");
  images_command->add_option("FOLDER", images.folder, "the images")
      ->required()
      ->check(some("a folder's name"));
  images_command->add_option("--out", images.out, "the recording")->required()->check(file_name());
  images_command->add_option("--name", images.name, "the camera's name [the folder's]")
      ->check(some("a name"));
  images_command->add_flag("--overwrite", images.overwrite, kOverwrite);
  images_command->add_option("--fps", images.frames_per_second, "frames a second, where images have no times")
      ->capture_default_str()
      ->check(number(1, 1000));
  images_command
      ->add_option("--times", images.times,
                   "what the numbers in lists and names are: s, ms, us or ns, or frame for frames' numbers "
                   "[recognised]")
      ->transform(one_of<TimeUnit>({{"s", TimeUnit::kSeconds},
                                    {"ms", TimeUnit::kMilliseconds},
                                    {"us", TimeUnit::kMicroseconds},
                                    {"ns", TimeUnit::kNanoseconds},
                                    {"frame", TimeUnit::kFrames}}));
  images_command
      ->add_option("--depth", images.depth,
                   "take depth from this folder in FOLDER, and no lists [the likeliest]")
      ->check(some("a folder's name"));
  images_command->add_option("--color", images.color, "likewise colour")->check(some("a folder's name"));
  images_command
      ->add_option(
          "--depth-scale", images.depth_per_metre,
          "what a depth of 1 m is in the images [5000 with TUM's lists, 1 in floating-point images, else "
          "1000]")
      ->check(number_above_zero(65535));
  images_command->add_option("--unit", images.unit, "depth unit of the recording: mm or 0.1mm [mm]")
      ->transform(one_of<DepthUnit>({{"mm", DepthUnit::kMillimetre}, {"0.1mm", DepthUnit::k100Micrometres}}));
  const char* together = "pixels; fx, fy, cx and cy go together [square pixels, a Kinect's field of view]";
  std::vector<CLI::Option*> lens{
      images_command->add_option("--fx", intrinsics.fx, together)->check(number_above_zero(1e6)),
      images_command->add_option("--fy", intrinsics.fy, together)->check(number_above_zero(1e6)),
      images_command->add_option("--cx", intrinsics.cx, together)->check(number(-1e6, 1e6)),
      images_command->add_option("--cy", intrinsics.cy, together)->check(number(-1e6, 1e6))};
  for (CLI::Option* one : lens) {
    for (CLI::Option* other : lens) {
      if (one != other) one->needs(other);
    }
  }
  images_command->add_option("--distortion", distortion, "k1 k2 p1 p2 k3 k4 k5 k6, OpenCV's order")
      ->expected(1, 8)
      ->check(number(-1e6, 1e6))
      ->needs(lens[0]);
  images_command->add_flag(
      "!--unregistered", images.registered,
      "colour is not as the depth camera sees it (it is taken to be, but for raw disparities)");
  images_command
      ->add_option("--jpeg-quality", images.jpeg_quality, "of colour that is not a JPEG already, 1 to 100")
      ->check(whole_number(1, 100))
      ->capture_default_str();

  try {
    app.parse(argc, argv);
    if (*cut_command && cut.to_s && *cut.to_s <= cut.from_s)
      throw CLI::ValidationError("--to", "must lie after --from");
    if (repair.overwrite && repair.out.empty()) {
      throw CLI::ValidationError("--overwrite",
                                 "without --out the recording itself is repaired: leave it out");
    }
  } catch (const CLI::ParseError& error) {
    return tl::unexpected(explain(app, error));
  }
  if (*info_command) return info;
  if (*repair_command) return repair;
  if (*cut_command) return cut;
  if (lens[0]->count() > 0) {
    std::copy(distortion.begin(), distortion.end(), intrinsics.distortion.begin());
    images.intrinsics = intrinsics;
  }
  if (images.name.empty()) {
    images.name = std::filesystem::absolute(images.folder).lexically_normal().filename().string();
    if (images.name.empty()) images.name = "images";
  }
  return images;
}

}  // namespace copresence::record
