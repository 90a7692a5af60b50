#include "capture_server/hole_filling/gl_joint_filling.h"

#include <array>
#include <cassert>
#include <cstdio>
#include <string>
#include <utility>

#include "capture_server/hole_filling/filling_rules.h"
#include "shaders/hole_filling_cells.comp.h"
#include "shaders/hole_filling_fillable.comp.h"
#include "shaders/hole_filling_guess.comp.h"
#include "shaders/hole_filling_joint.comp.h"
#include "shaders/hole_filling_slopes.comp.h"

namespace copresence::hole_filling {
namespace {

using gl::Define;
using gl::Format;
using gl::Reader;

// Sizes of the shaders' structures in the layout std430.
constexpr std::size_t kCellBytes = 32, kGuessBytes = 64;

struct Commands {
  gl::DispatchCommand guess;
  std::uint32_t wanted_count = 0;
  gl::DispatchCommand fill;
  std::uint32_t unused = 0;
};
constexpr std::size_t kFillCommandAt = 16;
static_assert(sizeof(Commands) == 32);

enum Texture : int { kDepth = 0, kFillable = 1, kColor = 2 };
enum Block : int { kCommands = 0, kWanted = 1, kMeasuredCells = 2, kCells = 3, kGuesses = 4 };

// Returns a GLSL literal with exactly this value.
std::string literal(float value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.9e", double(value));
  return text.data();
}

int cells_along(int pixels) {
  return (pixels + kCellPx - 1) / kCellPx;
}

class OwnContext final : public HoleFiller {
 public:
  OwnContext(std::unique_ptr<gl::Context> context, std::unique_ptr<GlJointFilling> filler)
      : context_(std::move(context)), filler_(std::move(filler)) {}
  std::string_view name() const override { return filler_->name(); }
  bool is_free_of_threads() const override { return filler_->is_free_of_threads(); }
  Result<void> fill(RgbdFrame& frame) override { return filler_->fill(frame); }

 private:
  std::unique_ptr<gl::Context> context_;
  std::unique_ptr<GlJointFilling> filler_;
};

}  // namespace

Result<GlJointFilling::Programs> GlJointFilling::compile(gl::Context& context, const FrameFormat& format) {
  static_assert(kCellPx == 4 && kWindowPx == 2, "written out in the shaders");
  const std::array defines = {
      Define{"WIDEST_GAP", std::to_string(kWidestGapPx)},
      Define{"BORDER", std::to_string(kWidestGapPx - kWidestAtBorderPx)},
      Define{"ONE_SURFACE", literal(kOneSurface)},
      Define{"STEPS_TIMES_UNITS", literal(steps_times_units(format.unit, format.noise))},
      Define{"CELL_ENOUGH", std::to_string(kCellEnough)},
      Define{"STEEPEST", literal(kSteepest)},
      Define{"REACH_CELLS", std::to_string(kReachCells)},
      Define{"LINKED", literal(kLinked)},
      Define{"WORTH_PIXELS", std::to_string(kWorthPixels)},
      Define{"SHADOW_PX_PER_STEP", literal(kShadowPxPerStep)},
      Define{"SHADOW_SLACK_PX", literal(kShadowSlackPx)},
      Define{"SAME_SURFACE", literal(kSameSurface)},
      Define{"GUESS_WEIGHT", literal(kCandidateWeight)},
      Define{"COLOR_SIGMA", literal(kColorSigma)}};
  const auto make = [&](std::string_view source) { return gl::Program::compute(context, source, defines); };
  auto find_fillable = make(shaders::hole_filling_fillable_comp);
  if (!find_fillable) return fail(find_fillable.error());
  auto see_cells = make(shaders::hole_filling_cells_comp);
  if (!see_cells) return fail(see_cells.error());
  auto find_slopes = make(shaders::hole_filling_slopes_comp);
  if (!find_slopes) return fail(find_slopes.error());
  auto guess = make(shaders::hole_filling_guess_comp);
  if (!guess) return fail(guess.error());
  auto fill = make(shaders::hole_filling_joint_comp);
  if (!fill) return copresence::fail(fill.error());
  return Programs{std::move(*find_fillable), std::move(*see_cells), std::move(*find_slopes),
                  std::move(*guess), std::move(*fill)};
}

Result<std::unique_ptr<GlJointFilling>> GlJointFilling::open(gl::Context& context,
                                                             const FrameFormat& format) {
  auto programs = compile(context, format);
  if (!programs) return fail(programs.error());
  auto filler = std::unique_ptr<GlJointFilling>(new GlJointFilling(context, format, std::move(*programs)));
  if (auto made = context.check("preparing hole filling"); !made) return fail(made.error());
  return filler;
}

GlJointFilling::GlJointFilling(gl::Context& context, const FrameFormat& format, Programs programs)
    : context_(context),
      grid_(cells_along(format.width), cells_along(format.height)),
      range_(to_units(format.range, format.unit).near, to_units(format.range, format.unit).far),
      programs_(std::move(programs)),
      depth_(context, Format::kR16ui, format.width, format.height),
      color_(context, Format::kRgba8, format.width, format.height),
      fillable_(context, Format::kR8ui, format.width, format.height),
      filled_(context, Format::kR16ui, format.width, format.height),
      commands_(context, sizeof(Commands)),
      wanted_(context, sizeof(std::uint32_t) * grid_.prod()),
      measured_cells_(context, kCellBytes * grid_.prod()),
      cells_(context, kCellBytes * grid_.prod()),
      guesses_(context, kGuessBytes * grid_.prod()) {}

Result<void> GlJointFilling::fill(RgbdFrame& frame) {
  assert(context_.is_on_its_thread() && same_shape(frame.depth, frame.state));
  assert(frame.depth.width() == depth_.width() && frame.depth.height() == depth_.height());
  upload(frame);
  run(frame.color.has_value());
  context_.barrier(Reader::kHost);
  filled_.read(filled_host_);
  if (auto done = context_.check("filling holes"); !done) return done;
  for (std::size_t i = 0; i < filled_host_.pixels().size(); ++i) {
    if (filled_host_.pixels()[i] == 0) continue;
    frame.depth.pixels()[i] = filled_host_.pixels()[i];
    frame.state.pixels()[i] = DepthState::kFilled;
  }
  return {};
}

void GlJointFilling::upload(const RgbdFrame& frame) {
  depth_.upload(frame.depth);
  if (frame.color) color_.upload(*frame.color);
  filled_.clear();
  const std::array zero{Commands{}};
  commands_.write(std::span(zero));
}

void GlJointFilling::run(bool has_color) {
  depth_.bind(kDepth);
  fillable_.bind(kFillable);
  color_.bind(kColor);
  commands_.bind_storage(kCommands);
  wanted_.bind_storage(kWanted);
  measured_cells_.bind_storage(kMeasuredCells);
  cells_.bind_storage(kCells);
  guesses_.bind_storage(kGuesses);

  fillable_.bind_image(0, gl::Access::kWrite);
  programs_.find_fillable.dispatch_over(depth_.width(), depth_.height());
  context_.barrier(Reader::kFetch);
  programs_.see_cells.set("grid", grid_);
  programs_.see_cells.dispatch_over(grid_.x(), grid_.y());
  context_.barrier(Reader::kStorage | Reader::kCommand);
  programs_.find_slopes.set("grid", grid_);
  programs_.find_slopes.dispatch_over(grid_.x(), grid_.y());
  context_.barrier(Reader::kStorage);
  programs_.guess.set("grid", grid_);
  programs_.guess.dispatch_indirect(commands_);
  context_.barrier(Reader::kStorage);
  filled_.bind_image(0, gl::Access::kWrite);
  programs_.fill.set("grid", grid_);
  programs_.fill.set("range", range_);
  programs_.fill.set("has_color", has_color ? 1 : 0);
  programs_.fill.dispatch_indirect(commands_, kFillCommandAt);
}

Result<std::unique_ptr<HoleFiller>> open_gl_joint_filling(const FrameFormat& format, bool hardware_only) {
  auto context = gl::Context::headless();
  if (!context) return fail(context.error());
  if (hardware_only && (*context)->is_software()) {
    return fail(ErrorCode::kUnsupported, "OpenGL is software here: --compute cpu is faster");
  }
  auto filler = GlJointFilling::open(**context, format);
  if (!filler) return fail(filler.error());
  return std::make_unique<OwnContext>(std::move(*context), std::move(*filler));
}

}  // namespace copresence::hole_filling
