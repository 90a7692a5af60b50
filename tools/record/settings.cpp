#include "tools/record/settings.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>

#include "common/command_line/mistakes.h"
#include "common/command_line/values.h"

namespace copresence::record {

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

  CutSettings cut;
  auto* cut_command = app.add_subcommand("cut", "copies a part of a recording, pictures unchanged");
  cut_command->add_option("FILE.oni", cut.recording, "the recording")->required()->check(file_name());
  cut_command->add_option("--from", cut.from_s, "seconds after the recording's first frame [0]")
      ->check(number(0, 1e6));
  cut_command
      ->add_option("--to", cut.to_s, "seconds after the recording's first frame, not included [its end]")
      ->check(number(0, 1e6));
  cut_command->add_option("--out", cut.out, "the part")->required()->check(file_name());

  FromImagesSettings images;
  Intrinsics intrinsics;
  std::vector<double> distortion;
  auto* images_command = app.add_subcommand(
      "from-images",
      "makes a recording of a folder of images: depth as 16-bit PNG, colour as JPEG or PNG; with TUM's lists "
      "(depth.txt and rgb.txt, or associations.txt) by their times, else by their names: files or folders "
      "with "
      "\"depth\" in their name are depth, the others colour, numbered alike");
  images_command->add_option("FOLDER", images.folder, "the images")
      ->required()
      ->check(some("a folder's name"));
  images_command->add_option("--out", images.out, "the recording")->required()->check(file_name());
  images_command->add_option("--name", images.name, "the camera's name [the folder's]")
      ->check(some("a name"));
  images_command->add_option("--fps", images.frames_per_second, "frames a second, where images have no times")
      ->capture_default_str()
      ->check(number(1, 1000));
  images_command
      ->add_option("--depth-scale", images.depth_per_metre,
                   "what a depth of 1 m is in the PNGs [5000 with TUM's lists, else 1000]")
      ->check(number(1, 65535));
  images_command->add_option("--unit", images.unit, "depth unit of the recording: mm or 0.1mm [mm]")
      ->transform(one_of<DepthUnit>({{"mm", DepthUnit::kMillimetre}, {"0.1mm", DepthUnit::k100Micrometres}}));
  const char* together = "pixels; fx, fy, cx and cy go together [a Kinect's]";
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
  images_command->add_flag("!--unregistered", images.registered,
                           "colour is not as the depth camera sees it (it is taken to be otherwise)");
  images_command->add_option("--jpeg-quality", images.jpeg_quality, "of colour that comes as PNG, 1 to 100")
      ->check(whole_number(1, 100))
      ->capture_default_str();

  try {
    app.parse(argc, argv);
    if (*cut_command && cut.to_s <= cut.from_s) throw CLI::ValidationError("--to", "must lie after --from");
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
