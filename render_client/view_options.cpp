#include "render_client/view_options.h"

namespace copresence::client {
namespace {

using display::Command;
using display::ViewColors;
using renderer::MergeMode;
using Show = renderer::UnseenStyle::Show;

Show after(Show show) {
  if (show == Show::kExtend) return Show::kDim;
  return show == Show::kDim ? Show::kBlack : Show::kExtend;
}

MergeMode after(MergeMode mode) {
  if (mode == MergeMode::kBlend) return MergeMode::kBest;
  return mode == MergeMode::kBest ? MergeMode::kNearest : MergeMode::kBlend;
}

const char* name_of(MergeMode mode) {
  if (mode == MergeMode::kBlend) return "blend";
  return mode == MergeMode::kBest ? "best pixel" : "nearest pixel";
}

const char* name_of(Show show) {
  if (show == Show::kExtend) return "extend";
  return show == Show::kDim ? "dim" : "black";
}

const char* on_or_off(bool is_on) {
  return is_on ? "on" : "off";
}

}  // namespace

bool ViewOptions::apply(Command command) {
  const auto toggle = [this](ViewColors other) { colors = colors == other ? ViewColors::kCameras : other; };
  switch (command) {
    case Command::kNextMerge:
      merge = after(merge);
      return true;
    case Command::kCorrectColors:
      corrects_colors = !corrects_colors;
      return true;
    case Command::kNextUnseen:
      unseen.show = after(unseen.show);
      return true;
    case Command::kColorByCamera:
      toggle(ViewColors::kLayers);
      return true;
    case Command::kColorByQuality:
      toggle(ViewColors::kQuality);
      return true;
    case Command::kWireframe:
      wireframe = can_draw_wireframe && !wireframe;
      return can_draw_wireframe;
    default:
      return false;
  }
}

renderer::UnseenStyle ViewOptions::shown_unseen() const {
  renderer::UnseenStyle style = unseen;
  if (wireframe) style.show = Show::kBlack;
  return style;
}

std::vector<overlay::Switch> ViewOptions::switches() const {
  return {display::switch_of(Command::kNextMerge, "merge", name_of(merge)),
          display::switch_of(Command::kCorrectColors, "colour correction", on_or_off(corrects_colors)),
          display::switch_of(Command::kNextUnseen, "unseen", name_of(unseen.show)),
          display::switch_of(Command::kColorByCamera, "colours by camera",
                             on_or_off(colors == ViewColors::kLayers)),
          display::switch_of(Command::kColorByQuality, "colours by quality",
                             on_or_off(colors == ViewColors::kQuality)),
          display::switch_of(Command::kWireframe, "wireframe",
                             can_draw_wireframe ? on_or_off(wireframe) : "needs --renderer gl")};
}

}  // namespace copresence::client
