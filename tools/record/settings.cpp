#include "tools/record/settings.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "common/command_line/parse_errors.h"
#include "common/command_line/values.h"

namespace copresence::record {
namespace {

constexpr const char* kOverwrite =
    "replace the file given by --out if it exists; by default existing files are kept";

}  // namespace

tl::expected<Settings, int> read_command_line(int argc, const char* const* argv) {
  using namespace command_line;
  CLI::App app{"Describes, repairs, cuts, creates and exports recordings of depth cameras (.oni).", "record"};
  app.set_version_flag("--version", std::string("record ") + COPRESENCE_VERSION);
  app.require_subcommand(1);

  InfoSettings info;
  auto* info_command =
      app.add_subcommand("info", "describes a recording: streams, frame rate, gaps, holes, depth levels");
  info_command->add_option("FILE.oni", info.recording, "the recording")->required()->check(file_name());
  info_command->add_flag("--json", info.json, "print JSON");

  RepairSettings repair;
  auto* repair_command =
      app.add_subcommand("repair", "completes a recording that was cut off; all complete frames are kept");
  repair_command->add_option("FILE.oni", repair.recording, "the recording; it is changed in place")
      ->required()
      ->check(file_name());
  repair_command
      ->add_option("--out", repair.out,
                   "write the repaired recording to this file and do not change FILE.oni; required if "
                   "FILE.oni is damaged in the middle")
      ->check(file_name());
  repair_command->add_flag("--overwrite", repair.overwrite, kOverwrite);

  CutSettings cut;
  auto* cut_command =
      app.add_subcommand("cut", "copies a part of a recording without coding its pictures again");
  cut_command->add_option("FILE.oni", cut.recording, "the recording")->required()->check(file_name());
  cut_command->add_option("--from", cut.from_s, "start, in seconds after the first frame [0]")
      ->check(number(0, 1e6));
  cut_command
      ->add_option("--to", cut.to_s,
                   "end (exclusive), in seconds after the first frame [end of the recording]")
      ->check(number(0, 1e6));
  cut_command->add_option("--out", cut.out, "the file to write")->required()->check(file_name());
  cut_command->add_flag("--overwrite", cut.overwrite, kOverwrite);

  FromImagesSettings images;
  Intrinsics intrinsics;
  std::vector<double> distortion;
  auto* images_command = app.add_subcommand(
      "from-images",
      "creates a recording from a folder of images. Depth: 16-bit PNG, PGM or TIFF, or floating-point TIFF "
      "or "
      "PFM. Colour: JPEG, PNG, PPM or TIFF. Times and pairs are read from associations.txt, from depth.txt "
      "and "
      "rgb.txt or color.txt, or from file names. Names and contents of the images decide which are depth and "
      "which are colour");
  images_command->add_option("FOLDER", images.folder, "the folder with the images")
      ->required()
      ->check(some("a folder's name"));
  images_command->add_option("--out", images.out, "the recording to write")->required()->check(file_name());
  images_command
      ->add_option("--name", images.name,
                   "name of the camera [that of camera.json, or the name of the folder]")
      ->check(some("a name"));
  images_command->add_flag("--overwrite", images.overwrite, kOverwrite);
  images_command
      ->add_option("--fps", images.frames_per_second, "frames per second if the images have no times")
      ->capture_default_str()
      ->check(number(1, 1000));
  images_command
      ->add_option("--times", images.times,
                   "unit of the numbers in lists and file names: s, ms, us, ns, or frame for frame numbers "
                   "[recognised]")
      ->transform(one_of<TimeUnit>({{"s", TimeUnit::kSeconds},
                                    {"ms", TimeUnit::kMilliseconds},
                                    {"us", TimeUnit::kMicroseconds},
                                    {"ns", TimeUnit::kNanoseconds},
                                    {"frame", TimeUnit::kFrames}}));
  images_command
      ->add_option("--depth", images.depth,
                   "use depth from this folder in FOLDER and ignore lists [chosen automatically]")
      ->check(some("a folder's name"));
  images_command->add_option("--color", images.color, "the same for colour")->check(some("a folder's name"));
  images_command
      ->add_option("--depth-scale", images.depth_per_metre,
                   "pixel value of 1 m in the depth images [that of camera.json, 5000 with lists as in TUM's "
                   "data sets, 1 for floating-point images, otherwise 1000]")
      ->check(number_above_zero(65535));
  images_command
      ->add_option("--unit", images.unit,
                   "depth unit of the recording: mm or 0.1mm [that of camera.json, or mm]")
      ->transform(one_of<DepthUnit>({{"mm", DepthUnit::kMillimetre}, {"0.1mm", DepthUnit::k100Micrometres}}));
  const char* together =
      "intrinsics in pixels; give --fx, --fy, --cx and --cy together [those of camera.json, or square pixels "
      "and "
      "the field of view of a Kinect]";
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
  images_command
      ->add_option("--distortion", distortion,
                   "lens distortion k1 k2 p1 p2 k3 k4 k5 k6, in the order of OpenCV")
      ->expected(1, 8)
      ->check(number(-1e6, 1e6))
      ->needs(lens[0]);
  images_command->add_flag(
      "!--unregistered", images.registered,
      "colour was taken from another viewpoint than depth [registered, except for raw disparities]");
  images_command
      ->add_option("--jpeg-quality", images.jpeg_quality,
                   "JPEG quality for colour images in other formats, 1 to 100")
      ->check(whole_number(1, 100))
      ->capture_default_str();

  ExportSettings exported;
  auto* export_command = app.add_subcommand(
      "export",
      "writes a recording as a folder of images: 16-bit PNG for depth, the recording's JPEG or PNG for "
      "colour, "
      "times, poses and intrinsics; from-images reads it back. A session recording (.mkv) becomes a folder "
      "for each camera");
  export_command->add_option("FILE", exported.recording, "the recording, .oni or .mkv")
      ->required()
      ->check(file_name());
  export_command->add_option("--out", exported.out, "the folder to make; it must be new or empty")
      ->required()
      ->check(some("a folder's name"));
  export_command->add_option("--format", exported.format, "layout of the folder: tum or 7scenes [tum]")
      ->transform(one_of<ExportFormat>({{"tum", ExportFormat::kTum}, {"7scenes", ExportFormat::k7Scenes}}));

  try {
    app.parse(argc, argv);
    if (*cut_command && cut.to_s && *cut.to_s <= cut.from_s)
      throw CLI::ValidationError("--to", "must be after --from");
    if (repair.overwrite && repair.out.empty()) {
      throw CLI::ValidationError("--overwrite",
                                 "needs --out; without --out the recording is repaired in place");
    }
  } catch (const CLI::ParseError& error) {
    return tl::unexpected(report_parse_error(app, error));
  }
  if (*info_command) return info;
  if (*repair_command) return repair;
  if (*cut_command) return cut;
  if (*export_command) return exported;
  if (lens[0]->count() > 0) {
    std::copy(distortion.begin(), distortion.end(), intrinsics.distortion.begin());
    images.intrinsics = intrinsics;
  }
  return images;
}

}  // namespace copresence::record
