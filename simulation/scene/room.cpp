#include <cmath>
#include <numbers>

#include "simulation/scene/noise.h"
#include "simulation/scene/scene.h"

namespace copresence::simulation {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float kHalfX = 2.4f, kHalfZ = 2.25f, kHeight = 2.6f;

Vector3f at(float x, float height, float z) {
  return {x, -height, z};
}

// The pose of an upright object at the point (x, -height, z).
Eigen::Isometry3f upright(float x, float height, float z) {
  Eigen::Isometry3f pose = Eigen::Isometry3f::Identity();
  pose.translate(at(x, height, z));
  return pose;
}

class Room {
 public:
  Scene build() {
    shell();
    window_and_curtains();
    door();
    bookshelf();
    sofa();
    coffee_table();
    screen_on_sideboard();
    plant();
    chair(1.55f, 0.55f, 2.3f);
    chair(-1.75f, -1.1f, -0.9f);
    cabinet();
    wall_pictures();
    lamp();
    return std::move(room_);
  }

 private:
  int paint(Pattern pattern, std::uint32_t color, std::uint32_t accent, float scale, float infrared = 0.6f,
            float mirror = 0) {
    return room_.add(Material{pattern, srgb(color), srgb(accent), scale, 0, mirror, infrared});
  }
  void solid(const Vector3f& center, const Vector3f& size, int material, float yaw = 0, float cell = 0.08f) {
    room_.add(box(center, size, material, yaw, cell));
  }

  void shell() {
    const int parquet = paint(Pattern::kParquet, 0xB98A5A, 0x8A5F38, 0.085f, 0.55f);
    const int ceiling = paint(Pattern::kPlaster, 0xF2EEE6, 0xE0DACE, 0.25f, 0.8f);
    const int paper = paint(Pattern::kWallpaper, 0xD9CBAF, 0xA98F6D, 0.24f, 0.75f);
    const int sage = paint(Pattern::kPlaster, 0xA9B79C, 0x95A588, 0.18f, 0.7f);
    const int cream = paint(Pattern::kPlaster, 0xE4D9C4, 0xCFC2A8, 0.2f, 0.75f);
    const int skirting = paint(Pattern::kWood, 0xF0EBE0, 0xD8CFBE, 0.05f, 0.7f);
    const float x = kHalfX, z = kHalfZ, h = kHeight / 2, cell = 0.11f;
    room_.add(panel(at(0, 0, 0), {x, 0, 0}, {0, 0, -z}, parquet, cell));
    room_.add(panel(at(0, kHeight, 0), {x, 0, 0}, {0, 0, z}, ceiling, cell));
    room_.add(panel(at(0, h, z), {x, 0, 0}, {0, h, 0}, paper, cell));
    room_.add(panel(at(0, h, -z), {-x, 0, 0}, {0, h, 0}, cream, cell));
    room_.add(panel(at(-x, h, 0), {0, 0, z}, {0, h, 0}, sage, cell));
    room_.add(panel(at(x, h, 0), {0, 0, -z}, {0, h, 0}, sage, cell));
    solid(at(0, 0.05f, z - 0.01f), {2 * x, 0.1f, 0.02f}, skirting);
    solid(at(0, 0.05f, -z + 0.01f), {2 * x, 0.1f, 0.02f}, skirting);
    solid(at(-x + 0.01f, 0.05f, 0), {0.02f, 0.1f, 2 * z}, skirting);
    solid(at(x - 0.01f, 0.05f, 0), {0.02f, 0.1f, 2 * z}, skirting);
    const int rug = paint(Pattern::kRug, 0x8E2F35, 0x27406B, 1.0f, 0.45f);
    room_.add(panel(at(0.05f, 0.008f, 0.1f), {1.25f, 0, 0}, {0, 0, -0.9f}, rug, 0.08f, true));
  }

  // The window is in the wall to the right. The pane reflects almost no infrared light.
  void window_and_curtains() {
    Material outdoors{Pattern::kOutdoors, srgb(0xFFFFFF), srgb(0xFFFFFF), 1.0f, 1.1f, 0.0f, 0.01f};
    const int pane = room_.add(outdoors);
    const int frame = paint(Pattern::kPlain, 0xF5F2EA, 0xE0DCD0, 0.1f, 0.7f);
    const float x = kHalfX - 0.02f, z = 0.35f;
    room_.add(panel(at(x, 1.5f, z), {0, 0, -0.65f}, {0, 0.6f, 0}, pane, 0.1f, true));
    for (const float side : {-0.67f, 0.0f, 0.67f})
      solid(at(x - 0.02f, 1.5f, z + side), {0.06f, 1.28f, 0.05f}, frame);
    for (const float side : {-0.62f, 0.0f, 0.62f})
      solid(at(x - 0.02f, 1.5f + side, z), {0.06f, 0.05f, 1.36f}, frame);
    solid(at(x - 0.09f, 0.84f, z), {0.2f, 0.04f, 1.5f}, frame);
    const int cloth = paint(Pattern::kFabric, 0x3E6C77, 0x5B94A0, 0.03f, 0.5f);
    for (const float side : {-0.93f, 0.93f}) {
      room_.add(sheet(40, 22, 0.5f, 2.0f, cloth, [&](float u, float v) {
        const float fold = 0.035f * std::sin(u * 6 * 2 * std::numbers::pi_v<float>) * (0.6f + 0.4f * v);
        return at(x - 0.13f + fold, 2.25f - 2.0f * v, z + side + 0.42f * (u - 0.5f));
      }));
    }
    const int rail = paint(Pattern::kPlain, 0x6B4A2E, 0x523820, 0.1f, 0.4f);
    solid(at(x - 0.13f, 2.27f, z), {0.03f, 0.03f, 2.5f}, rail);
    room_.lights.push_back(
        {at(x - 0.1f, 1.5f, z), {0, 0, -0.6f}, {0, 0.55f, 0}, Vector3f(0.62f, 0.72f, 0.86f) * 1.5f});
  }

  void door() {
    const int white = paint(Pattern::kWood, 0xEDE7DA, 0xD3C9B4, 0.12f, 0.7f);
    const int brass = paint(Pattern::kPlain, 0xB08D45, 0x8A6B2E, 0.05f, 0.1f, 0.3f);
    const float z = -kHalfZ + 0.03f;
    solid(at(1.35f, 1.02f, z), {0.9f, 2.04f, 0.06f}, white);
    for (const float height : {0.55f, 1.45f})
      solid(at(1.35f, height, z + 0.04f), {0.6f, 0.65f, 0.03f}, white);
    solid(at(1.02f, 1.02f, z + 0.08f), {0.12f, 0.03f, 0.06f}, brass);
  }

  void bookshelf() {
    const int wood = paint(Pattern::kWood, 0x7A5230, 0x4E3019, 0.06f, 0.35f);
    const float x = -1.45f, z = kHalfZ - 0.17f, width = 1.3f, height = 2.0f, depth = 0.32f;
    for (const float side : {-1.0f, 1.0f})
      solid(at(x + side * width / 2, height / 2, z), {0.03f, height, depth}, wood);
    solid(at(x, height / 2, z + depth / 2), {width, height, 0.02f}, wood);
    constexpr int kShelves = 5;
    static constexpr std::uint32_t kCovers[] = {0x9B2335, 0x1F4E79, 0x2E6B4F, 0xC98B2B, 0x5B3A6E, 0xD8CFBD,
                                                0x30343F, 0xB5532A, 0x6D8A96, 0x7A1F3D, 0x3C6E71, 0xE0B04A};
    std::vector<int> covers;
    for (const std::uint32_t cover : kCovers) {
      const bool pale = (cover >> 16) > 0xB0;
      covers.push_back(paint(Pattern::kBook, cover, pale ? 0x3A3A3A : 0xE7D9A8, 0.26f,
                             0.25f + 0.4f * (pale ? 1.0f : 0.5f)));
    }
    for (int shelf = 0; shelf <= kShelves; ++shelf) {
      const float level = 0.06f + 0.38f * static_cast<float>(shelf);
      solid(at(x, level, z), {width, 0.025f, depth}, wood);
      if (shelf == kShelves) break;
      float left = x - width / 2 + 0.03f;
      for (std::uint32_t book = 0;; ++book) {
        const std::uint32_t roll = hash(static_cast<std::uint32_t>(shelf), book, 77);
        const float thick = 0.022f + 0.034f * unit(roll), tall = 0.19f + 0.11f * unit(mix(roll + 1));
        if (left + thick > x + width / 2 - 0.03f) break;
        if (unit(mix(roll + 2)) < 0.07f) {  // Leave a gap.
          left += 0.08f;
          continue;
        }
        const float deep = 0.16f + 0.06f * unit(mix(roll + 3));
        solid(at(left + thick / 2, level + 0.0125f + tall / 2, z - depth / 2 + 0.04f + deep / 2),
              {thick, tall, deep}, covers[roll % covers.size()], 0, 0.15f);
        left += thick + 0.002f;
      }
    }
    const int clay = paint(Pattern::kPlain, 0xB5643C, 0x8A4526, 0.05f, 0.55f);
    const Ring globe[] = {{-0.30f, 0.03f, 0.03f},
                          {-0.26f, 0.05f, 0.05f},
                          {-0.16f, 0.11f, 0.11f},
                          {-0.04f, 0.07f, 0.07f},
                          {0, 0.06f, 0.06f}};
    room_.add(loft(upright(x + 0.35f, height, z), globe, clay));
  }

  void sofa() {
    const int cloth = paint(Pattern::kFabric, 0x5E6B86, 0x7886A3, 0.025f, 0.5f);
    const int mustard = paint(Pattern::kFabric, 0xD9A032, 0xB57F1D, 0.02f, 0.65f);
    const int striped = paint(Pattern::kStripes, 0xE8DFCB, 0xA33B3B, 0.08f, 0.65f);
    const float x = 0.95f, z = kHalfZ - 0.45f;
    const auto cushion = [&](float cx, float height, float cz, Vector3f half, int material) {
      const Ring rings[] = {{-half.y(), 0.45f * half.x(), 0.45f * half.z()},
                            {-0.8f * half.y(), 0.95f * half.x(), 0.95f * half.z()},
                            {0, half.x(), half.z()},
                            {0.8f * half.y(), 0.95f * half.x(), 0.95f * half.z()},
                            {half.y(), 0.45f * half.x(), 0.45f * half.z()}};
      room_.add(loft(upright(cx, height, cz), rings, material, 0.8f, 32));
    };
    solid(at(x, 0.20f, z), {1.75f, 0.24f, 0.80f}, cloth);
    for (const float side : {-0.38f, 0.38f})
      cushion(x + side, 0.40f, z - 0.06f, {0.39f, 0.10f, 0.36f}, cloth);
    for (const float side : {-0.38f, 0.38f})
      cushion(x + side, 0.66f, z + 0.28f, {0.39f, 0.24f, 0.12f}, cloth);
    for (const float side : {-0.87f, 0.87f}) cushion(x + side, 0.38f, z, {0.11f, 0.24f, 0.40f}, cloth);
    cushion(x - 0.5f, 0.62f, z + 0.08f, {0.19f, 0.17f, 0.08f}, mustard);
    cushion(x + 0.52f, 0.62f, z + 0.08f, {0.2f, 0.17f, 0.08f}, striped);
    const int feet = paint(Pattern::kWood, 0x4A3220, 0x2E1E12, 0.05f, 0.3f);
    for (const float a : {-0.8f, 0.8f}) {
      for (const float b : {-0.33f, 0.33f}) solid(at(x + a, 0.04f, z + b), {0.05f, 0.08f, 0.05f}, feet);
    }
  }

  // A low round table left of the person, with a mirror-like vase, a bowl of fruit and a book.
  void coffee_table() {
    const int wood = paint(Pattern::kWood, 0xC49A6C, 0x9A6F42, 0.08f, 0.55f);
    const int metal = paint(Pattern::kPlain, 0x6E7276, 0x55585C, 0.05f, 0.04f, 0.75f);
    const float x = -1.15f, z = 0.85f, top = 0.46f;
    const Ring plate[] = {
        {0, 0.40f, 0.40f}, {0.012f, 0.42f, 0.42f}, {0.024f, 0.42f, 0.42f}, {0.035f, 0.40f, 0.40f}};
    room_.add(loft(upright(x, top, z), plate, wood, 0, 40, 2));
    for (int leg = 0; leg < 3; ++leg) {
      const float angle = 0.5f + static_cast<float>(leg) * 2.094f;
      const Ring rod[] = {{0, 0.02f, 0.02f},
                          {0.43f, 0.015f, 0.015f, 0.08f * std::cos(angle), 0.08f * std::sin(angle)}};
      room_.add(loft(upright(x + 0.27f * std::cos(angle), top - 0.03f, z + 0.27f * std::sin(angle)), rod,
                     wood, 0, 12));
    }
    const Ring vase[] = {{-0.30f, 0.035f, 0.035f},
                         {-0.26f, 0.028f, 0.028f},
                         {-0.17f, 0.075f, 0.075f},
                         {-0.06f, 0.07f, 0.07f},
                         {0, 0.045f, 0.045f}};
    room_.add(loft(upright(x - 0.16f, top, z - 0.08f), vase, metal, 0, 32, 6));
    const int bowl = paint(Pattern::kPlain, 0xE9EEF2, 0xB8C4CE, 0.05f, 0.7f);
    const Ring dish[] = {{-0.08f, 0.14f, 0.14f}, {-0.04f, 0.12f, 0.12f}, {0, 0.06f, 0.06f}};
    room_.add(loft(upright(x + 0.16f, top, z + 0.1f), dish, bowl));
    static constexpr std::uint32_t kFruit[] = {0xC8312B, 0xE08A1E, 0x8FB339, 0xD9B42C};
    for (int i = 0; i < 4; ++i) {
      const int fruit = paint(Pattern::kPlain, kFruit[i], kFruit[i], 0.03f, 0.6f);
      const float angle = 1.57f * static_cast<float>(i);
      const Ring ball[] = {{-0.04f, 0.005f, 0.005f},
                           {-0.03f, 0.027f, 0.027f},
                           {0, 0.04f, 0.04f},
                           {0.03f, 0.027f, 0.027f},
                           {0.04f, 0.005f, 0.005f}};
      room_.add(loft(
          upright(x + 0.16f + 0.055f * std::cos(angle), top + 0.105f, z + 0.1f + 0.055f * std::sin(angle)),
          ball, fruit, 0, 16, 3));
    }
    const int pages = paint(Pattern::kPlain, 0xF4EFE2, 0xD8D0BC, 0.02f, 0.8f);
    const int cover = paint(Pattern::kPlain, 0x22577A, 0x163A52, 0.05f, 0.4f);
    solid(at(x + 0.05f, top + 0.008f, z - 0.24f), {0.30f, 0.012f, 0.21f}, cover, 0.3f);
    solid(at(x + 0.05f, top + 0.022f, z - 0.24f), {0.28f, 0.016f, 0.19f}, pages, 0.3f);
  }

  // The screen is at the wall to the left. A Kinect measures no depth on its black glass.
  void screen_on_sideboard() {
    const int oak = paint(Pattern::kWood, 0xA97C50, 0x7C5530, 0.07f, 0.5f);
    const int black = paint(Pattern::kPlain, 0x0B0C0E, 0x08090A, 0.1f, 0.01f, 0.12f);
    const int plastic = paint(Pattern::kPlain, 0x1C1D20, 0x141517, 0.05f, 0.10f);
    const float x = -kHalfX + 0.22f, z = 0.25f;
    solid(at(x, 0.28f, z), {0.42f, 0.48f, 1.6f}, oak);
    for (const float side : {-0.53f, 0.0f, 0.53f})
      solid(at(x + 0.21f, 0.28f, z + side), {0.02f, 0.40f, 0.50f}, oak);
    solid(at(x - 0.05f, 0.93f, z), {0.04f, 0.68f, 1.16f}, plastic);
    room_.add(panel(at(x - 0.025f, 0.93f, z), {0, 0, 0.56f}, {0, 0.32f, 0}, black, 0.08f));
    solid(at(x, 0.55f, z), {0.2f, 0.06f, 0.4f}, plastic);
    const int pot = paint(Pattern::kPlain, 0x8EB1A5, 0x6A8C80, 0.04f, 0.6f);
    const Ring jar[] = {
        {-0.22f, 0.04f, 0.04f}, {-0.18f, 0.06f, 0.06f}, {-0.08f, 0.08f, 0.08f}, {0, 0.05f, 0.05f}};
    room_.add(loft(upright(x + 0.02f, 0.52f, z - 0.68f), jar, pot));
  }

  void plant() {
    const int pot = paint(Pattern::kPlain, 0xC7693F, 0x9E4A26, 0.06f, 0.6f);
    const int leaf = paint(Pattern::kLeaf, 0x3F7D3A, 0x7FB069, 0.03f, 0.75f);
    const float x = kHalfX - 0.38f, z = kHalfZ - 0.38f;
    const Ring bucket[] = {{-0.34f, 0.17f, 0.17f}, {-0.30f, 0.17f, 0.17f}, {0, 0.12f, 0.12f}};
    room_.add(loft(upright(x, 0, z), bucket, pot));
    for (std::uint32_t i = 0; i < 26; ++i) {
      const float angle = 2.4f * static_cast<float>(i), reach = 0.18f + 0.22f * unit(mix(i + 100));
      const float rise = 0.45f + 0.75f * unit(mix(i + 200)), width = 0.03f + 0.025f * unit(mix(i + 300));
      const Vector2f out(std::cos(angle), std::sin(angle));
      Mesh blade = sheet(2, 10, 1, 1, leaf, [&](float u, float v) {
        const float along = reach * v * (0.4f + 0.6f * v),
                    side = (u - 0.5f) * 2 * width * std::sin(3.0f * v + 0.14f);
        const float height = 0.33f + rise * (1.15f * v - 0.45f * v * v) + 0.01f * std::abs(u - 0.5f);
        return at(x + out.x() * along - out.y() * side, height, z + out.y() * along + out.x() * side);
      });
      for (Vertex& vertex : blade.vertices) vertex.uv.x() -= 0.5f;
      room_.add(std::move(blade));
    }
  }

  void chair(float x, float z, float yaw) {
    const int wood = paint(Pattern::kWood, 0x8C5A33, 0x5E3A1D, 0.05f, 0.45f);
    const int seat = paint(Pattern::kFabric, 0xB8473C, 0x8E2F28, 0.02f, 0.5f);
    const auto rotated = [&](float dx, float height, float dz) {
      return at(x + dx * std::cos(yaw) + dz * std::sin(yaw), height,
                z - dx * std::sin(yaw) + dz * std::cos(yaw));
    };
    for (const float a : {-0.19f, 0.19f}) {
      solid(rotated(a, 0.22f, -0.19f), {0.04f, 0.44f, 0.04f}, wood, yaw);
      solid(rotated(a, 0.46f, 0.19f), {0.04f, 0.92f, 0.04f}, wood, yaw);
    }
    solid(rotated(0, 0.44f, 0), {0.44f, 0.04f, 0.44f}, wood, yaw);
    solid(rotated(0, 0.475f, -0.01f), {0.40f, 0.04f, 0.40f}, seat, yaw);
    for (const float height : {0.64f, 0.76f, 0.88f})
      solid(rotated(0, height, 0.19f), {0.36f, 0.07f, 0.02f}, wood, yaw);
  }

  void cabinet() {
    const int painted = paint(Pattern::kWood, 0x5F7F8C, 0x47626D, 0.1f, 0.5f);
    const int knob = paint(Pattern::kPlain, 0xD8C27A, 0xB09A55, 0.02f, 0.3f, 0.2f);
    const float x = -0.35f, z = -kHalfZ + 0.24f;
    solid(at(x, 0.95f, z), {1.1f, 1.9f, 0.46f}, painted);
    for (const float side : {-0.27f, 0.27f}) {
      solid(at(x + side, 0.95f, z + 0.24f), {0.50f, 1.78f, 0.02f}, painted);
      solid(at(x + 0.25f * side, 0.95f, z + 0.27f), {0.03f, 0.12f, 0.03f}, knob);
    }
  }

  void wall_pictures() {
    const int frame = paint(Pattern::kWood, 0x3B2A1E, 0x251910, 0.03f, 0.25f);
    const int painting =
        room_.add(Material{Pattern::kPicture, srgb(0xFFFFFF), srgb(0xFFFFFF), 1.0f, 0, 0, 0.6f});
    const int poster =
        room_.add(Material{Pattern::kPoster, srgb(0xFFFFFF), srgb(0xFFFFFF), 1.0f, 0, 0, 0.7f});
    const float z = kHalfZ - 0.02f;
    solid(at(0.95f, 1.62f, z), {1.10f, 0.78f, 0.03f}, frame);
    room_.add(panel(at(0.95f, 1.62f, z - 0.018f), {0.51f, 0, 0}, {0, 0.35f, 0}, painting, 0.1f, true));
    room_.add(panel(at(-kHalfX + 0.01f, 1.6f, -1.35f), {0, 0, 0.32f}, {0, 0.45f, 0}, poster, 0.1f, true));
    solid(at(0.57f, 1.5f, -z), {0.5f, 0.66f, 0.03f}, frame);
    room_.add(panel(at(0.57f, 1.5f, -z + 0.018f), {-0.22f, 0, 0}, {0, 0.30f, 0}, poster, 0.1f, true));
  }

  void lamp() {
    Material glow{Pattern::kPlain, srgb(0xFFF1D8), srgb(0xFFF1D8), 0.2f, 1.6f, 0.0f, 0.5f};
    const int shade = room_.add(glow);
    const int cord = paint(Pattern::kPlain, 0x2A2A2A, 0x1A1A1A, 0.1f, 0.3f);
    const Ring globe[] = {{-0.10f, 0.05f, 0.05f},
                          {-0.06f, 0.19f, 0.19f},
                          {0, 0.24f, 0.24f},
                          {0.05f, 0.19f, 0.19f},
                          {0.07f, 0.05f, 0.05f}};
    room_.add(loft(upright(0.15f, 2.32f, -0.75f), globe, shade, 0, 32));
    solid(at(0.15f, 2.5f, -0.75f), {0.015f, 0.2f, 0.015f}, cord);
    room_.lights.push_back(
        {at(0.15f, 2.22f, -0.75f), {0.2f, 0, 0}, {0, 0, 0.2f}, Vector3f(1.0f, 0.92f, 0.80f) * 2.6f});
    room_.ambient = Vector3f(0.17f, 0.165f, 0.16f);
  }

  Scene room_;
};

}  // namespace

Scene make_room() {
  return Room().build();
}

}  // namespace copresence::simulation
