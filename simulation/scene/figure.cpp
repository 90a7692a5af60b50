#include "simulation/scene/figure.h"

#include <cassert>
#include <cmath>
#include <numbers>

#include "simulation/scene/scene.h"

namespace copresence::simulation {
namespace {

using Eigen::AngleAxisf;
using Eigen::Isometry3f;
using Eigen::Vector3f;

enum Part {
  kHips,
  kChest,
  kHead,
  kHair,
  kUpperArmA,
  kForearmA,
  kHandA,
  kUpperArmB,
  kForearmB,
  kHandB,
  kThighA,
  kShankA,
  kShoeA,
  kThighB,
  kShankB,
  kShoeB,
  kParts
};

// The sizes are in metres. Side A is the right side of the person, at x < 0. Side A appears on the
// left when seen from the front.
constexpr float kHipHeight = 0.93f, kHipSide = 0.095f, kThigh = 0.44f, kShank = 0.42f, kAnkle = 0.085f;
constexpr float kShoulderRise = 0.375f, kShoulderSide = 0.178f, kUpperArm = 0.29f, kForearm = 0.25f;

// Returns a sine with a whole number of periods, so that the motion is periodic.
float wave(double phase, int times, double shift = 0) {
  return static_cast<float>(std::sin(2 * std::numbers::pi * (times * phase + shift)));
}

AngleAxisf about_x(float angle) {
  return {angle, Vector3f::UnitX()};
}
AngleAxisf about_y(float angle) {
  return {angle, Vector3f::UnitY()};
}
AngleAxisf about_z(float angle) {
  return {angle, Vector3f::UnitZ()};
}

Isometry3f joint(const Vector3f& position, const Eigen::Quaternionf& rotation) {
  Isometry3f pose = Isometry3f::Identity();
  pose.translate(position);
  pose.rotate(rotation);
  return pose;
}

// Inverse kinematics: hip, knee and ankle lie in one plane with the forward direction of the
// figure. So the lengths of thigh and shank determine the position of the knee.
void pose_leg(const Vector3f& hip, const Vector3f& ankle, Isometry3f& thigh, Isometry3f& shank) {
  const Vector3f reach = ankle - hip;
  const float length = std::min(reach.norm(), 0.999f * (kThigh + kShank));
  const float bend = std::acos((kThigh * kThigh + length * length - kShank * kShank) / (2 * kThigh * length));
  const Vector3f down = reach.normalized();
  const Vector3f forward = (-Vector3f::UnitZ() + down * down.z()).normalized();
  const Vector3f thigh_down = down * std::cos(bend) + forward * std::sin(bend);
  const Vector3f knee = hip + kThigh * thigh_down;
  const auto along = [](const Vector3f& position, const Vector3f& y) {
    Isometry3f pose = Isometry3f::Identity();
    const Vector3f x = y.cross(Vector3f::UnitZ()).normalized();
    pose.linear() << x, y, x.cross(y);
    pose.translation() = position;
    return pose;
  };
  thigh = along(hip, thigh_down);
  shank = along(knee, (ankle - knee).normalized());
}

std::vector<Isometry3f> move_person(double phase) {
  std::vector<Isometry3f> parts_in_figure(kParts);
  auto& p = parts_in_figure;

  const Vector3f hip_center(0.030f * wave(phase, 1), -kHipHeight + 0.012f * (1 + wave(phase, 2, 0.25)),
                            0.012f * wave(phase, 2));
  p[kHips] = joint(
      hip_center, Eigen::Quaternionf(about_y(0.10f * wave(phase, 1, 0.1)) * about_z(0.03f * wave(phase, 1))));
  p[kChest] =
      p[kHips] * joint({0, -0.10f, 0}, Eigen::Quaternionf(about_y(0.13f * wave(phase, 1, 0.3)) *
                                                          about_x(-0.03f + 0.03f * wave(phase, 2, 0.1)) *
                                                          about_z(-0.05f * wave(phase, 1))));
  const Isometry3f neck =
      p[kChest] * joint({0, -0.47f, -0.005f}, Eigen::Quaternionf(about_y(0.30f * wave(phase, 1, 0.55)) *
                                                                 about_x(0.07f * wave(phase, 2, 0.4)) *
                                                                 about_z(0.05f * wave(phase, 1, 0.2))));
  p[kHead] = p[kHair] = neck;

  // Arm A waves above the head, arm B gestures in front of the chest.
  const auto arm = [&](Part upper, float side, const Eigen::Quaternionf& shoulder,
                       const Eigen::Quaternionf& elbow, const Eigen::Quaternionf& wrist) {
    p[upper] = p[kChest] * joint({side * kShoulderSide, -kShoulderRise, 0}, shoulder);
    p[upper + 1] = p[upper] * joint({0, kUpperArm, 0}, elbow);
    p[upper + 2] = p[upper + 1] * joint({0, kForearm, 0}, wrist);
  };
  arm(kUpperArmA, -1, Eigen::Quaternionf(about_z(1.15f + 0.12f * wave(phase, 1, 0.6)) * about_x(-0.25f)),
      Eigen::Quaternionf(about_z(1.45f + 0.42f * wave(phase, 2)) * about_x(-0.30f)),
      Eigen::Quaternionf(about_z(0.25f * wave(phase, 2, -0.12))));
  arm(kUpperArmB, 1,
      Eigen::Quaternionf(about_z(-0.22f - 0.08f * wave(phase, 1, 0.2)) *
                         about_x(-0.30f + 0.22f * wave(phase, 1, 0.8))),
      Eigen::Quaternionf(about_z(0.35f + 0.25f * wave(phase, 2, 0.3)) *
                         about_x(-1.35f + 0.35f * wave(phase, 1, 0.45))),
      Eigen::Quaternionf(about_x(-0.1f + 0.2f * wave(phase, 2, 0.2)) * about_y(0.8f)));

  for (const float side : {-1.0f, 1.0f}) {
    const Part thigh = side < 0 ? kThighA : kThighB;
    const Vector3f hip = p[kHips] * Vector3f(side * kHipSide, 0.02f, 0);
    const Vector3f ankle(side * 0.13f, -kAnkle, side < 0 ? -0.06f : 0.04f);
    pose_leg(hip, ankle, p[thigh], p[thigh + 1]);
    p[thigh + 2] = joint(ankle, Eigen::Quaternionf(about_y(-side * 0.22f)));
  }
  return parts_in_figure;
}

}  // namespace

std::vector<Isometry3f> Figure::pose(double phase) const {
  if (empty()) return {};
  std::vector<Isometry3f> parts_in_world = motion(phase);
  assert(parts_in_world.size() == parts.size());
  for (Isometry3f& part : parts_in_world) part = world_from_figure * part;
  return parts_in_world;
}

Figure make_person(Scene& scene) {
  const auto paint = [&](Pattern pattern, std::uint32_t color, std::uint32_t accent, float scale,
                         float infrared) {
    return scene.add(Material{pattern, srgb(color), srgb(accent), scale, 0, 0, infrared});
  };
  // Girth of the middle ring in metres, from which loft() derives texture coordinates.
  constexpr float kHeadGirth = 0.5156f;
  const int face =
      scene.add(Material{Pattern::kFace, srgb(0xD9A27E), srgb(0x3A2417), kHeadGirth, 0, 0, 0.65f});
  const int skin = paint(Pattern::kPlain, 0xD9A27E, 0xC98F6B, 0.03f, 0.65f);
  const int shirt = paint(Pattern::kPlaid, 0x2F6DB0, 0x9C2B3B, 0.085f, 0.55f);
  const int jeans = paint(Pattern::kFabric, 0x2C3E5C, 0x4A6288, 0.012f, 0.45f);
  const int shoe = paint(Pattern::kPlain, 0xE8E4DA, 0xC9C2B2, 0.03f, 0.6f);
  const int hair = paint(Pattern::kHair, 0x3A2417, 0x24160D, 0.012f, 0.06f);

  const Isometry3f here = Isometry3f::Identity();
  Figure figure;
  figure.motion = move_person;
  figure.parts.resize(kParts);
  figure.capsules.resize(kParts);
  const auto body = [&](Part part, int material, std::vector<Ring> rings, float square = 0, int around = 28) {
    figure.parts[part] = loft(here, rings, material, square, around, 5);
    const Ring& first = rings.front();
    const Ring& last = rings.back();
    float radius = 0;
    for (const Ring& ring : rings) radius = std::max(radius, 0.5f * (ring.half_x + ring.half_z));
    const float inset = std::min(radius, 0.5f * (last.y - first.y));
    figure.capsules[part] = {
        {first.x, first.y + inset, first.z}, {last.x, last.y - inset, last.z}, 0.92f * radius};
  };

  body(kHips, jeans,
       {{-0.13f, 0.145f, 0.095f},
        {-0.06f, 0.16f, 0.11f},
        {0.02f, 0.175f, 0.12f},
        {0.08f, 0.165f, 0.11f},
        {0.12f, 0.09f, 0.07f}},
       0.3f);
  body(kChest, shirt,
       {{-0.475f, 0.05f, 0.05f},
        {-0.455f, 0.085f, 0.065f},
        {-0.42f, 0.17f, 0.085f},
        {-0.37f, 0.20f, 0.105f},
        {-0.27f, 0.195f, 0.125f},
        {-0.15f, 0.165f, 0.115f},
        {-0.03f, 0.16f, 0.11f},
        {0.06f, 0.172f, 0.12f},
        {0.10f, 0.17f, 0.118f}},
       0.35f, 40);
  // Neck and head are one part; the chin points forward.
  body(kHead, face,
       {{-0.300f, 0.02f, 0.03f, 0, -0.005f},
        {-0.285f, 0.055f, 0.07f, 0, -0.005f},
        {-0.235f, 0.076f, 0.096f, 0, -0.008f},
        {-0.175f, 0.078f, 0.100f, 0, -0.012f},
        {-0.125f, 0.072f, 0.092f, 0, -0.018f},
        {-0.085f, 0.056f, 0.075f, 0, -0.026f},
        {-0.060f, 0.050f, 0.058f, 0, -0.010f},
        {-0.03f, 0.052f, 0.054f, 0, 0.004f},
        {0.03f, 0.060f, 0.060f, 0, 0.006f}},
       0.1f, 32);
  const auto add_to = [&](Part part, Mesh more) {
    // At this point, the face pattern is plain skin.
    for (Vertex& vertex : more.vertices) vertex.uv = {0, -0.2f};
    Mesh& mesh = figure.parts[part];
    const auto offset = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), more.vertices.begin(), more.vertices.end());
    for (const auto& t : more.triangles)
      mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  };
  const Ring nose[] = {{-0.200f, 0.008f, 0.012f, 0, -0.100f},
                       {-0.165f, 0.015f, 0.022f, 0, -0.112f},
                       {-0.150f, 0.016f, 0.016f, 0, -0.110f},
                       {-0.145f, 0.004f, 0.004f, 0, -0.105f}};
  add_to(kHead, loft(here, nose, skin, 0, 12, 3));
  for (const float side : {-1.0f, 1.0f}) {
    const Ring ear[] = {{-0.205f, 0.004f, 0.010f, side * 0.078f, 0.005f},
                        {-0.185f, 0.012f, 0.022f, side * 0.082f, 0.008f},
                        {-0.145f, 0.008f, 0.012f, side * 0.076f, 0.002f}};
    add_to(kHead, loft(here, ear, skin, 0, 12, 3));
  }
  // The hair is high above the forehead and low at the back.
  body(kHair, hair,
       {{-0.325f, 0.015f, 0.02f, 0, 0.005f},
        {-0.312f, 0.062f, 0.076f, 0, 0.004f},
        {-0.27f, 0.084f, 0.104f, 0, 0.006f},
        {-0.235f, 0.086f, 0.098f, 0, 0.014f},
        {-0.19f, 0.084f, 0.082f, 0, 0.032f},
        {-0.14f, 0.074f, 0.058f, 0, 0.052f},
        {-0.10f, 0.05f, 0.03f, 0, 0.062f}},
       0, 32);

  for (const Part upper : {kUpperArmA, kUpperArmB}) {
    body(upper, shirt,
         {{-0.060f, 0.015f, 0.015f},
          {-0.050f, 0.036f, 0.036f},
          {-0.02f, 0.056f, 0.058f},
          {0.03f, 0.062f, 0.066f},
          {0.10f, 0.056f, 0.058f},
          {0.22f, 0.048f, 0.05f},
          {kUpperArm, 0.046f, 0.046f},
          {kUpperArm + 0.04f, 0.02f, 0.02f}},
         0, 24);
    const Part forearm = Part(upper + 1), hand = Part(upper + 2);
    body(forearm, shirt,
         {{-0.045f, 0.02f, 0.02f},
          {-0.03f, 0.042f, 0.042f},
          {0.05f, 0.047f, 0.047f},
          {0.14f, 0.042f, 0.04f},
          {0.215f, 0.038f, 0.034f},
          {0.225f, 0.036f, 0.032f}},
         0, 24);
    body(hand, skin,
         {{-0.05f, 0.022f, 0.019f},
          {0, 0.026f, 0.019f},
          {0.03f, 0.038f, 0.018f},
          {0.07f, 0.042f, 0.017f},
          {0.09f, 0.040f, 0.015f},
          {0.10f, 0.034f, 0.012f}},
         0.4f, 20);
    for (int finger = 0; finger < 4; ++finger) {
      const float x = -0.031f + 0.0207f * static_cast<float>(finger);
      const float length = 0.062f + (finger == 1 || finger == 2 ? 0.015f : 0.0f);
      const Ring digit[] = {{0.085f, 0.009f, 0.010f, x},
                            {0.09f + 0.5f * length, 0.0088f, 0.0095f, 1.12f * x, -0.004f},
                            {0.088f + length, 0.006f, 0.007f, 1.25f * x, -0.012f}};
      add_to(hand, loft(here, digit, skin, 0, 10, 3));
    }
    const Ring thumb[] = {{0.02f, 0.012f, 0.012f, 0.032f},
                          {0.05f, 0.011f, 0.011f, 0.055f, -0.008f},
                          {0.085f, 0.007f, 0.007f, 0.068f, -0.014f}};
    add_to(hand, loft(here, thumb, skin, 0, 10, 3));
  }
  for (const Part thigh : {kThighA, kThighB}) {
    body(thigh, jeans,
         {{-0.06f, 0.05f, 0.05f},
          {-0.02f, 0.082f, 0.095f},
          {0.08f, 0.088f, 0.098f},
          {0.25f, 0.072f, 0.080f},
          {kThigh - 0.04f, 0.060f, 0.066f},
          {kThigh + 0.04f, 0.045f, 0.05f}},
         0, 24);
    body(Part(thigh + 1), jeans,
         {{-0.05f, 0.03f, 0.03f},
          {-0.02f, 0.055f, 0.058f},
          {0.08f, 0.06f, 0.065f, 0, 0.008f},
          {0.20f, 0.055f, 0.06f, 0, 0.006f},
          {0.36f, 0.054f, 0.060f},
          {0.40f, 0.057f, 0.064f}},
         0, 24);
    // The toes point to -z.
    body(Part(thigh + 2), shoe,
         {{-0.03f, 0.03f, 0.04f, 0, 0.0f},
          {0.0f, 0.04f, 0.065f, 0, -0.01f},
          {0.035f, 0.046f, 0.115f, 0, -0.055f},
          {0.06f, 0.05f, 0.135f, 0, -0.065f},
          {0.083f, 0.05f, 0.138f, 0, -0.066f}},
         0.25f, 28);
  }
  return figure;
}

}  // namespace copresence::simulation
