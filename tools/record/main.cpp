// The program record: describes, repairs, cuts, creates and exports recordings.

#include <fmt/format.h>

#include <csignal>
#include <optional>

#include "capture_server/recording/oni_repair.h"
#include "tools/progress/progress.h"
#include "tools/record/from_images.h"
#include "tools/record/image_export.h"
#include "tools/record/recording_info.h"
#include "tools/record/settings.h"

namespace copresence::record {
namespace {

constexpr int kSteps = 100;
constexpr double kNoEnd = 1e18;  // In seconds.

/// A progress bar with steps of one percent.
class Bar {
 public:
  explicit Bar(std::string what) : what_(std::move(what)), progress_(kSteps) {}

  recording::ProgressReport report() {
    return [this](double share) {
      for (; done_ < static_cast<int>(share * kSteps); ++done_) progress_.begin(what_);
    };
  }

 private:
  std::string what_;
  tools::Progress progress_;
  int done_ = 0;
};

Result<std::string> run(const InfoSettings& settings) {
  std::optional<Bar> bar(std::in_place, settings.recording);
  const auto info = read_info(settings.recording, bar->report());
  bar.reset();
  if (!info) return fail(info.error());
  return settings.json ? to_json(*info) : to_table(*info);
}

file::Existing existing(bool overwrite) {
  return overwrite ? file::Existing::kReplace : file::Existing::kKeep;
}

std::string frames(const recording::RepairReport& report) {
  std::string text =
      fmt::format("{} frames of depth, {} of colour", report.depth_frames, report.color_frames);
  if (report.infrared_frames) text += fmt::format(", {} of infrared", report.infrared_frames);
  return text;
}

Result<std::string> run(const RepairSettings& settings) {
  Bar bar(settings.recording);
  const auto done =
      recording::repair(settings.recording, settings.out, existing(settings.overwrite), bar.report());
  if (!done) return fail(done.error());
  const std::string& file = settings.out.empty() ? settings.recording : settings.out;
  if (done->was_whole) return fmt::format("{}: complete, with {}; nothing to repair\n", file, frames(*done));
  std::string text = fmt::format("{}: finished with {}", file, frames(*done));
  if (done->dropped_bytes)
    text += fmt::format("; {} bytes of an incomplete frame were dropped", done->dropped_bytes);
  if (done->gaps) text += fmt::format("; {} damaged places were skipped", done->gaps);
  return text + '\n';
}

Result<std::string> run(const CutSettings& settings) {
  Bar bar(settings.out);
  const auto done = recording::cut(settings.recording, settings.from_s, settings.to_s.value_or(kNoEnd),
                                   settings.out, existing(settings.overwrite), bar.report());
  if (!done) return fail(done.error());
  std::string text = fmt::format("{}: {} frames of depth, {} of colour\n", settings.out, done->depth_frames,
                                 done->color_frames);
  if (settings.to_s && *settings.to_s > done->whole_s) {
    text += fmt::format("{} is only {:.1f} s long, so the copy ends there and not at {:g} s\n",
                        settings.recording, done->whole_s, *settings.to_s);
  }
  return text;
}

Result<std::string> run(const FromImagesSettings& settings) {
  Bar bar(settings.out);
  const auto done = make_from_images(settings, bar.report());
  if (!done) return fail(done.error());
  std::string text;
  for (const std::string& remark : done->remarks) text += remark + '\n';
  text += fmt::format("{}: {} frames of depth{}, {} of colour, {:.1f} MB\n", settings.out, done->depth_frames,
                      done->depth_per_metre
                          ? fmt::format(" ({:g} per metre in the images)", done->depth_per_metre)
                          : std::string(),
                      done->color_frames, static_cast<double>(done->bytes) * 1e-6);
  if (done->too_far) {
    text += fmt::format(
        "{} depth pixels are too far for the unit and became holes; --unit mm has a larger range\n",
        done->too_far);
  }
  return text;
}

Result<std::string> run(const ExportSettings& settings) {
  Bar bar(settings.out);
  const auto done = export_images(settings, bar.report());
  if (!done) return fail(done.error());
  std::string text;
  for (const std::string& remark : done->remarks) text += remark + '\n';
  for (const std::string& folder : done->folders) text += folder + '\n';
  return text + fmt::format("{} images of depth, {} of colour\n", done->depth_images, done->color_images);
}

}  // namespace
}  // namespace copresence::record

// Only a lack of memory can throw here, and then the program has to end.
// NOLINTNEXTLINE(bugprone-exception-escape).
int main(int argc, char** argv) {
  // If a file exceeds the file size limit (ulimit -f), writing fails with an error instead of a
  // signal.
  std::signal(SIGXFSZ, SIG_IGN);
  const auto settings = copresence::record::read_command_line(argc, argv);
  if (!settings) return settings.error();
  const auto done =
      std::visit([](const auto& command) { return copresence::record::run(command); }, *settings);
  if (!done) {
    fmt::print(stderr, "record: {}\n", done.error().what);
    return 1;
  }
  fmt::print("{}", *done);
  return 0;
}
