#include "simulation/scene/calibration_worlds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace copresence::simulation {
namespace {

using Eigen::Vector3f;

constexpr float kHalfRoom = 2.4f, kCeiling = 2.6f;  // In metres.
constexpr int kCells = 6;              // Cells per side of a marker: four bits and a border of one cell.
constexpr float kBorder = 1.3f;        // Side of the white board, as a multiple of the marker's side.
constexpr float kThickness = 0.01f;    // Thickness of a hanging board, in metres.
constexpr float kInkOffset = 0.0004f;  // Distance of the ink from the board, in metres.

// The markers with ids 0 to 15 of OpenCV's DICT_4X4_50, row by row from the top left. 1 is white.
constexpr std::array<std::uint16_t, 16> kBits{0xB532, 0x0F9A, 0x332D, 0x9946, 0x549E, 0x79CD, 0x9E2E, 0xC4F2,
                                              0xFEDA, 0xCF56, 0xF991, 0x11A7, 0x0EB7, 0x2A0F, 0x24B1, 0x263E};

bool is_white(int id, int column, int row) {
  if (column == 0 || row == 0 || column == kCells - 1 || row == kCells - 1) return false;
  return (kBits[static_cast<std::size_t>(id)] >> (15 - (4 * (row - 1) + column - 1))) & 1;
}

// Adds the black cells of a marker: one panel for each run of black cells in a row.
void print_marker(Scene& scene, const PlacedMarker& marker, int ink) {
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
      scene.add(panel(center, across * (0.5f * (end_f - begin_f)), down * 0.5f, ink, 0.1f));
      first = end;
    }
  }
}

// Adds the white board just behind the ink of a marker.
void add_board(Scene& scene, const PlacedMarker& marker, int paper) {
  const Vector3f normal = marker.half_v.cross(marker.half_u).normalized();
  scene.add(panel(marker.center - kInkOffset * normal, kBorder * marker.half_u, kBorder * marker.half_v,
                  paper, 0.1f));
}

// A pose of the moving board in the frame of camera 0, in metres and radians.
struct BoardPose {
  float x, y, z, pitch, yaw, roll;
};
constexpr std::array<BoardPose, 24> kBoardPoses{{
    {0, 0, 0.60f, 0, 0, 0},
    {0, 0, 0.70f, 0.5f, 0, 0},
    {0, 0, 0.70f, -0.5f, 0, 0},
    {0, 0, 0.70f, 0, 0.55f, 0},
    {0, 0, 0.70f, 0, -0.55f, 0},
    {0, 0, 0.75f, 0.35f, 0.35f, 0.4f},
    {-0.16f, -0.118f, 0.75f, 0.2f, -0.3f, 0},
    {0.16f, -0.118f, 0.75f, 0.2f, 0.3f, 0},
    {-0.16f, 0.118f, 0.75f, -0.2f, -0.3f, 0},
    {0.16f, 0.118f, 0.75f, -0.2f, 0.3f, 0},
    {-0.25f, -0.20f, 0.90f, -0.3f, 0.3f, 0},
    {0.25f, -0.20f, 0.90f, -0.3f, -0.3f, 0},
    {-0.25f, 0.20f, 0.90f, 0.3f, 0.3f, 0},
    {0.25f, 0.20f, 0.90f, 0.3f, -0.3f, 0},
    {-0.20f, 0, 0.76f, 0, 0.45f, 0},
    {0.20f, 0, 0.76f, 0, -0.45f, 0},
    {0, -0.15f, 0.76f, -0.45f, 0, 0},
    {0, 0.15f, 0.76f, 0.45f, 0, 0},
    {0.05f, 0.02f, 0.80f, 0.2f, -0.3f, 0.8f},
    {-0.06f, 0.03f, 0.85f, -0.3f, 0.2f, -0.7f},
    {0.30f, 0.10f, 1.20f, 0.4f, 0.2f, 0},
    {-0.35f, -0.20f, 1.30f, -0.3f, -0.4f, 0.1f},
    {0.10f, -0.28f, 1.20f, 0, 0.5f, 0},
    {-0.20f, 0.30f, 1.25f, 0.5f, -0.2f, 0},
}};

// A chessboard around `center`. Seen from its front, the unit vectors u and v point right and down.
struct Board {
  Mesh paper, ink;
};
Board print_board(Scene& scene, float square, const Vector3f& center, const Vector3f& u, const Vector3f& v) {
  const int white = scene.add(Material{Pattern::kPlain, srgb(0xE8E8E4), srgb(0xE8E8E4), 0.1f, 0, 0, 0.7f});
  const int black = scene.add(Material{Pattern::kPlain, srgb(0x202020), srgb(0x202020), 0.1f, 0, 0, 0.3f});
  const float half_width = 0.5f * square * (kBoardColumns + 1),
              half_height = 0.5f * square * (kBoardRows + 1);
  Board board;
  board.paper =
      panel(center, (half_width + 0.8f * square) * u, (half_height + 0.8f * square) * v, white, 0.1f);
  board.ink.material = black;
  const Vector3f normal = v.cross(u);
  for (int row = 0; row <= kBoardRows; ++row) {
    for (int column = row % 2; column <= kBoardColumns; column += 2) {
      const float x = (static_cast<float>(column) + 0.5f) * square - half_width,
                  y = (static_cast<float>(row) + 0.5f) * square - half_height;
      const Mesh cell = panel(center + x * u + y * v + kInkOffset * normal, 0.5f * square * u,
                              0.5f * square * v, black, 0.1f);
      const auto first = static_cast<std::uint32_t>(board.ink.vertices.size());
      board.ink.vertices.insert(board.ink.vertices.end(), cell.vertices.begin(), cell.vertices.end());
      for (const auto& t : cell.triangles) {
        board.ink.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
      }
    }
  }
  return board;
}

std::vector<Eigen::Isometry3f> move_board(double phase) {
  const double within = phase - std::floor(phase);
  const auto number = std::min(kBoardPoses.size() - 1, static_cast<std::size_t>(within * kBoardPoses.size()));
  const BoardPose& p = kBoardPoses[number];
  const Rigid3 camera = kinect_poses(1).front();
  Eigen::Isometry3f world_from_board = Eigen::Isometry3f::Identity();
  world_from_board.linear() = camera.rotation.cast<float>();
  world_from_board.translation() = camera.translation.cast<float>();
  world_from_board.translate(Vector3f(p.x, p.y, p.z));
  world_from_board.rotate(Eigen::AngleAxisf(p.yaw, Vector3f::UnitY()) *
                          Eigen::AngleAxisf(p.pitch, Vector3f::UnitX()) *
                          Eigen::AngleAxisf(p.roll, Vector3f::UnitZ()));
  return {world_from_board, world_from_board};
}

}  // namespace

Scene make_bare_room() {
  Scene scene;
  const auto paint = [&](Pattern pattern, std::uint32_t color, std::uint32_t accent, float scale) {
    return scene.add(Material{pattern, srgb(color), srgb(accent), scale, 0, 0, 0.6f});
  };
  const int floor = paint(Pattern::kParquet, 0xB98A5A, 0x8A5F38, 0.085f);
  const int wall = paint(Pattern::kPlaster, 0xB9C2C6, 0xA5B0B5, 0.2f);
  const int white = paint(Pattern::kPlaster, 0xF2EEE6, 0xE0DACE, 0.25f);
  const float r = kHalfRoom, h = kCeiling / 2;
  scene.add(panel({0, 0, 0}, {r, 0, 0}, {0, 0, -r}, floor, 0.15f));
  scene.add(panel({0, -kCeiling, 0}, {r, 0, 0}, {0, 0, r}, white, 0.15f));
  scene.add(panel({0, -h, r}, {r, 0, 0}, {0, h, 0}, wall, 0.15f));
  scene.add(panel({0, -h, -r}, {-r, 0, 0}, {0, h, 0}, wall, 0.15f));
  scene.add(panel({-r, -h, 0}, {0, 0, r}, {0, h, 0}, wall, 0.15f));
  scene.add(panel({r, -h, 0}, {0, 0, -r}, {0, h, 0}, wall, 0.15f));
  for (const float z : {-1.3f, 1.3f}) {
    scene.lights.push_back({{0, -kCeiling + 0.02f, z}, {1.2f, 0, 0}, {0, 0, 0.3f}, Vector3f::Constant(1.6f)});
  }
  scene.ambient = Vector3f::Constant(0.35f);
  return scene;
}

std::vector<PlacedMarker> placed_markers() {
  const std::array<Vector3f, 6> hanging{Vector3f(-0.62f, -1.30f, 0.15f), {0.00f, -1.50f, 0.55f},
                                        {0.62f, -1.30f, -0.05f},         {-0.62f, -0.86f, -0.30f},
                                        {0.24f, -1.00f, -0.45f},         {0.75f, -0.90f, 0.35f}};
  const std::array<Vector3f, 4> lying{Vector3f(-0.40f, -0.30f, 0.00f),
                                      {0.02f, -0.30f, 0.17f},
                                      {0.40f, -0.34f, 0.00f},
                                      {-0.02f, -0.32f, -0.22f}};
  // Half the side of the black square, for hanging and for lying markers.
  constexpr float kHanging = 0.10f, kLying = 0.127f;
  std::vector<PlacedMarker> markers;
  int id = 0;
  for (const Vector3f& center : hanging)
    markers.push_back({id++, center, {kHanging, 0, 0}, {0, kHanging, 0}});
  for (const Vector3f& center : hanging) {
    markers.push_back({id++, center + Vector3f(0, 0, kThickness), {-kHanging, 0, 0}, {0, kHanging, 0}});
  }
  for (const Vector3f& center : lying) markers.push_back({id++, center, {kLying, 0, 0}, {0, 0, -kLying}});
  return markers;
}

Scene make_marker_room() {
  Scene scene = make_bare_room();
  const int paper = scene.add(Material{Pattern::kPlain, srgb(0xE8E8E4), srgb(0xE8E8E4), 0.1f, 0, 0, 0.7f});
  const int ink = scene.add(Material{Pattern::kPlain, srgb(0x202020), srgb(0x202020), 0.1f, 0, 0, 0.3f});
  const int card = scene.add(Material{Pattern::kPlain, srgb(0x9A7B55), srgb(0x8A6B45), 0.1f, 0, 0, 0.6f});
  for (const PlacedMarker& marker : placed_markers()) {
    add_board(scene, marker, paper);
    print_marker(scene, marker, ink);
    if (marker.half_v.y() != 0) continue;
    const float top = -marker.center.y() - 0.002f, side = 2.6f * marker.half_u.norm();
    scene.add(box({marker.center.x(), -0.5f * top, marker.center.z()}, {side, top, side}, card));
  }
  return scene;
}

Figure make_moving_board(Scene& scene) {
  Board board = print_board(scene, kMovingSquare, Vector3f::Zero(), Vector3f::UnitX(), Vector3f::UnitY());
  Figure figure;
  figure.motion = move_board;
  figure.parts = {std::move(board.paper), std::move(board.ink)};
  const Capsule shadow{{-0.1f, 0, 0}, {0.1f, 0, 0}, 0.14f};
  figure.capsules = {shadow, shadow};
  return figure;
}

Scene make_still_board_room() {
  Scene scene = make_bare_room();
  Board board = print_board(scene, kStillSquare, {0, -1.0f, -0.3f}, Vector3f::UnitX(), Vector3f::UnitY());
  scene.add(std::move(board.paper));
  scene.add(std::move(board.ink));
  return scene;
}

}  // namespace copresence::simulation
