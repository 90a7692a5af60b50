#include "simulation/marker_world.h"

#include <array>
#include <cstdint>

namespace copresence::simulation {
namespace {

using Eigen::Vector3f;

constexpr float kHalfRoom = 2.4f, kHeight = 2.6f;  // metres
constexpr int kCells = 6;                          // of a marker's side: four bits in a frame of one cell
constexpr float kBorder = 1.3f;                    // side of the white board, in sides of the marker
constexpr float kThickness = 0.01f;                // of a board, metres
constexpr float kAbove = 0.0004f;                  // of the ink over the board, metres

// The bits of DICT_4X4_50, row by row from the top left, 1 for white; ids 0 to 15.
constexpr std::array<std::uint16_t, 16> kBits{0xB532, 0x0F9A, 0x332D, 0x9946, 0x549E, 0x79CD, 0x9E2E, 0xC4F2,
                                              0xFEDA, 0xCF56, 0xF991, 0x11A7, 0x0EB7, 0x2A0F, 0x24B1, 0x263E};

bool is_white(int id, int column, int row) {
  if (column == 0 || row == 0 || column == kCells - 1 || row == kCells - 1) return false;
  return (kBits[static_cast<std::size_t>(id)] >> (15 - (4 * (row - 1) + column - 1))) & 1;
}

// One panel for each run of black cells in a row.
void print_marker(Furnishing& world, const PlacedMarker& marker, int ink) {
  const Vector3f across = marker.half_u * (2.0f / kCells), down = marker.half_v * (2.0f / kCells);
  const Vector3f corner = marker.center - marker.half_u - marker.half_v;
  for (int row = 0; row < kCells; ++row) {
    for (int first = 0; first < kCells; ++first) {
      if (is_white(marker.id, first, row)) continue;
      int end = first;
      while (end < kCells && !is_white(marker.id, end, row)) ++end;
      const auto begin_f = static_cast<float>(first), end_f = static_cast<float>(end);
      const Vector3f center =
          corner + across * (0.5f * (begin_f + end_f)) + down * (static_cast<float>(row) + 0.5f);
      world.add(panel(center, across * (0.5f * (end_f - begin_f)), down * 0.5f, ink, 0.1f));
      first = end;
    }
  }
}

// The white board that a marker is printed on, just behind its ink.
void hang_board(Furnishing& world, const PlacedMarker& marker, int paper) {
  const Vector3f towards = marker.half_v.cross(marker.half_u).normalized();  // where it faces
  world.add(
      panel(marker.center - kAbove * towards, kBorder * marker.half_u, kBorder * marker.half_v, paper, 0.1f));
}

}  // namespace

Furnishing furnish_bare_room() {
  Furnishing world;
  const auto paint = [&](Pattern pattern, std::uint32_t color, std::uint32_t accent, float scale) {
    return world.add(Material{pattern, srgb(color), srgb(accent), scale, 0, 0, 0.6f});
  };
  const int floor = paint(Pattern::kParquet, 0xB98A5A, 0x8A5F38, 0.085f);
  const int wall = paint(Pattern::kPlaster, 0xB9C2C6, 0xA5B0B5, 0.2f);
  const int white = paint(Pattern::kPlaster, 0xF2EEE6, 0xE0DACE, 0.25f);
  const float r = kHalfRoom, h = kHeight / 2;
  world.add(panel({0, 0, 0}, {r, 0, 0}, {0, 0, -r}, floor, 0.15f));
  world.add(panel({0, -kHeight, 0}, {r, 0, 0}, {0, 0, r}, white, 0.15f));
  world.add(panel({0, -h, r}, {r, 0, 0}, {0, h, 0}, wall, 0.15f));
  world.add(panel({0, -h, -r}, {-r, 0, 0}, {0, h, 0}, wall, 0.15f));
  world.add(panel({-r, -h, 0}, {0, 0, r}, {0, h, 0}, wall, 0.15f));
  world.add(panel({r, -h, 0}, {0, 0, -r}, {0, h, 0}, wall, 0.15f));
  for (const float z : {-1.3f, 1.3f}) {
    world.lights.push_back({{0, -kHeight + 0.02f, z}, {1.2f, 0, 0}, {0, 0, 0.3f}, Vector3f::Constant(1.6f)});
  }
  world.ambient = Vector3f::Constant(0.35f);
  return world;
}

std::vector<PlacedMarker> placed_markers() {
  const std::array<Vector3f, 6> hanging{Vector3f(-0.62f, -1.30f, 0.15f), {0.00f, -1.50f, 0.55f},
                                        {0.62f, -1.30f, -0.05f},         {-0.62f, -0.86f, -0.30f},
                                        {0.24f, -1.00f, -0.45f},         {0.75f, -0.90f, 0.35f}};
  const std::array<Vector3f, 4> lying{Vector3f(-0.40f, -0.30f, 0.00f),
                                      {0.02f, -0.30f, 0.17f},
                                      {0.40f, -0.34f, 0.00f},
                                      {-0.02f, -0.32f, -0.22f}};
  constexpr float kHanging = 0.10f, kLying = 0.127f;  // half the black square's side
  std::vector<PlacedMarker> markers;
  int id = 0;
  for (const Vector3f& place : hanging) markers.push_back({id++, place, {kHanging, 0, 0}, {0, kHanging, 0}});
  for (const Vector3f& place : hanging) {
    markers.push_back({id++, place + Vector3f(0, 0, kThickness), {-kHanging, 0, 0}, {0, kHanging, 0}});
  }
  for (const Vector3f& place : lying) markers.push_back({id++, place, {kLying, 0, 0}, {0, 0, -kLying}});
  return markers;
}

Furnishing furnish_markers() {
  Furnishing world = furnish_bare_room();
  const int paper = world.add(Material{Pattern::kPlain, srgb(0xE8E8E4), srgb(0xE8E8E4), 0.1f, 0, 0, 0.7f});
  const int ink = world.add(Material{Pattern::kPlain, srgb(0x202020), srgb(0x202020), 0.1f, 0, 0, 0.3f});
  const int card = world.add(Material{Pattern::kPlain, srgb(0x9A7B55), srgb(0x8A6B45), 0.1f, 0, 0, 0.6f});
  for (const PlacedMarker& marker : placed_markers()) {
    hang_board(world, marker, paper);
    print_marker(world, marker, ink);
    if (marker.half_v.y() != 0) continue;
    const float top = -marker.center.y() - 0.002f, side = 2.6f * marker.half_u.norm();
    world.add(box({marker.center.x(), -0.5f * top, marker.center.z()}, {side, top, side}, card));
  }
  return world;
}

}  // namespace copresence::simulation
