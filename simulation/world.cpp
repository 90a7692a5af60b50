#include "simulation/world.h"

#include <algorithm>
#include <cassert>

#include "simulation/board_world.h"
#include "simulation/marker_world.h"

namespace copresence::simulation {

double phase_of_frame(std::uint64_t frame, std::uint64_t frames) {
  assert(frames > 0);
  const std::uint64_t periods = std::max<std::uint64_t>(1, (frames + kPeriodFrames / 2) / kPeriodFrames);
  // Reduced to whole numbers first: frame and frame + frames give the same double.
  return static_cast<double>(frame * periods % frames) / static_cast<double>(frames);
}

std::vector<std::string> World::names() {
  return {"room", "empty-room", "markers", "board", "still-board"};
}

Result<World> World::make(std::string_view name) {
  if (name == "markers") return of(furnish_markers());
  if (name == "still-board") return of(furnish_still_board());
  if (name == "board") {
    Furnishing bare = furnish_bare_room();
    Figure board = make_moving_board(bare);
    return of(std::move(bare), std::move(board));
  }
  if (name != "room" && name != "empty-room") {
    std::string all;
    for (const std::string& known : names()) all += (all.empty() ? "" : ", ") + known;
    return fail(ErrorCode::kInvalid, "there is no world \"" + std::string(name) + "\"; there are " + all);
  }
  Furnishing furnishing = furnish_room();
  Figure figure;
  if (name == "room") figure = make_person(furnishing);
  return of(std::move(furnishing), std::move(figure));
}

Result<World> World::of(Furnishing furnishing, Figure figure) {
  World world;
  world.furnishing_ = std::move(furnishing);
  world.figure_ = std::move(figure);
  auto still = RayScene::make(world.furnishing_.meshes);
  if (!still) return fail(still.error());
  world.still_ = std::make_shared<RayScene>(std::move(*still));
  auto parts = PosedScene::Parts::make(world.figure_.parts);
  if (!parts) return fail(parts.error());
  world.parts_ = std::make_shared<PosedScene::Parts>(std::move(*parts));
  world.light_ = bake_light(world.furnishing_, *world.still_);
  return world;
}

}  // namespace copresence::simulation
