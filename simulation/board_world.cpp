#include "simulation/board_world.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "simulation/marker_world.h"
#include "simulation/simulated_kinect.h"

namespace copresence::simulation {
namespace {

using Eigen::Vector3f;

constexpr float kAbove = 0.0004f;  // of the ink over the board, metres

struct Place {  // of the board's middle before the camera, metres, and its turns, radians
  float x, y, z, pitch, yaw, roll;
};
constexpr std::array<Place, 24> kPlaces{{
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

// The middle at `center`, u to the right and v down as one looks at it, both of length 1.
struct Board {
  Mesh paper, ink;
};
Board print_board(Furnishing& world, float square, const Vector3f& center, const Vector3f& u,
                  const Vector3f& v) {
  const int white = world.add(Material{Pattern::kPlain, srgb(0xE8E8E4), srgb(0xE8E8E4), 0.1f, 0, 0, 0.7f});
  const int black = world.add(Material{Pattern::kPlain, srgb(0x202020), srgb(0x202020), 0.1f, 0, 0, 0.3f});
  const float half_width = 0.5f * square * (kBoardColumns + 1),
              half_height = 0.5f * square * (kBoardRows + 1);
  Board board;
  board.paper =
      panel(center, (half_width + 0.8f * square) * u, (half_height + 0.8f * square) * v, white, 0.1f);
  board.ink.material = black;
  const Vector3f towards = v.cross(u);  // where it faces
  for (int row = 0; row <= kBoardRows; ++row) {
    for (int column = row % 2; column <= kBoardColumns; column += 2) {
      const float x = (static_cast<float>(column) + 0.5f) * square - half_width,
                  y = (static_cast<float>(row) + 0.5f) * square - half_height;
      const Mesh cell =
          panel(center + x * u + y * v + kAbove * towards, 0.5f * square * u, 0.5f * square * v, black, 0.1f);
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
  const auto number = std::min(kPlaces.size() - 1, static_cast<std::size_t>(within * kPlaces.size()));
  const Place& p = kPlaces[number];
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

Figure make_moving_board(Furnishing& world) {
  Board board = print_board(world, kMovingSquare, Vector3f::Zero(), Vector3f::UnitX(), Vector3f::UnitY());
  Figure figure;
  figure.motion = move_board;
  figure.parts = {std::move(board.paper), std::move(board.ink)};
  const Capsule shadow{{-0.1f, 0, 0}, {0.1f, 0, 0}, 0.14f};
  figure.capsules = {shadow, shadow};
  return figure;
}

Furnishing furnish_still_board() {
  Furnishing world = furnish_bare_room();
  Board board = print_board(world, kStillSquare, {0, -1.0f, -0.3f}, Vector3f::UnitX(), Vector3f::UnitY());
  world.add(std::move(board.paper));
  world.add(std::move(board.ink));
  return world;
}

}  // namespace copresence::simulation
