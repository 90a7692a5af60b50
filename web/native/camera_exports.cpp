// One camera's stream, for the worker that decodes it.

#include <algorithm>
#include <array>
#include <cassert>
#include <memory>
#include <vector>

#include "common/bitstream/access_unit.h"
#include "common/wire/message_codec.h"
#include "render_client/renderer/merge_rules.h"
#include "web/native/camera_stream.h"
#include "web/native/exports.h"

namespace copresence::web {
namespace {

std::unique_ptr<CameraStream>& stream() {
  static std::unique_ptr<CameraStream> open;
  return open;
}

JsonObject describe(const StreamDescription& description) {
  const CameraModel& model = description.model;
  const DepthNoise& noise = description.noise;
  std::array<double, 12> pose;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      pose[4 * row + column] = description.world_from_camera.rotation(row, column);
    pose[4 * row + 3] = description.world_from_camera.translation(row);
  }
  JsonObject out;
  out.add("camera", description.camera)
      .add("width", double(model.width))
      .add("height", double(model.height))
      .add("fx", model.fx)
      .add("fy", model.fy)
      .add("cx", model.cx)
      .add("cy", model.cy)
      .add("distortion", std::span<const double>(model.distortion))
      .add("metresPerUnit", metres_per_unit(description.unit))
      .add("framesPerSecond", description.frames_per_second)
      .add("hasColor", description.has_color)
      .add("hasPose", description.has_pose)
      .add("worldFromCamera", std::span<const double>(pose))
      .add("codec", description.codec.name)
      .add("pictureFormat", name(description.codec.format))
      .add("noise", JsonObject()
                        .add("inverseStep", renderer::inverse_step(noise))
                        .add("uncertaintyPerSquare", renderer::uncertainty_per_square(noise))
                        .add("precision", renderer::precision(noise)));
  return out;
}

// The name of the H.264 profile and level, as in RFC 6381: avc1.PPCCLL.
std::string codec_string(std::span<const std::uint8_t> access_unit) {
  const auto nals = bitstream::split_access_unit(access_unit);
  if (!nals) return {};
  for (const bitstream::Nal& nal : *nals) {
    if (nal.type() == bitstream::NalType::kSequenceParameters && nal.bytes.size() > 3)
      return fmt::format("avc1.{:02X}{:02X}{:02X}", nal.bytes[1], nal.bytes[2], nal.bytes[3]);
  }
  return {};
}

JsonObject describe(Picture& picture) {
  std::array<double, 3> planes{};
  for (int i = 0; i < picture.planes(); ++i) {
    planes[i] = static_cast<double>(picture.bytes_per_sample() == 2
                                        ? reinterpret_cast<std::uintptr_t>(picture.plane10().data())
                                        : reinterpret_cast<std::uintptr_t>(picture.plane8(i).data()));
  }
  return JsonObject()
      .add("planes", std::span<const double>(planes).first(picture.planes()))
      .add("width", double(picture.width()))
      .add("height", double(picture.height()))
      .add("chromaWidth", double(picture.planes() > 1 ? picture.plane_width(1) : 0))
      .add("chromaHeight", double(picture.planes() > 1 ? picture.plane_height(1) : 0))
      .add("bytesPerSample", double(picture.bytes_per_sample()));
}

// A picture that the browser must decode.
JsonObject describe(std::span<const std::uint8_t> access_unit, Picture& picture, bool keyframe) {
  JsonObject out;
  out.add_memory("bytes", access_unit).add("picture", describe(picture));
  if (keyframe) out.add("codec", codec_string(access_unit));
  return out;
}

Result<EncodedFrame> read_frame(std::span<const std::uint8_t> message) {
  const auto cut = [] { return fail(ErrorCode::kCorrupt, "a frame that is cut"); };
  constexpr std::size_t kBody = wire::kHeaderBytes, kAccessUnits = kBody + wire::kFrameHeadBytes;
  if (message.size() < kAccessUnits) return cut();
  const auto header = wire::decode_header(message.first<kBody>());
  if (!header) return fail(header.error());
  if (header->type != wire::MessageType::kFrame || header->body_bytes != message.size() - kBody) return cut();
  const auto head =
      wire::decode_frame_head(message.subspan<kBody, wire::kFrameHeadBytes>(), header->body_bytes);
  if (!head) return fail(head.error());
  const auto depth = message.subspan(kAccessUnits, head->depth_bytes);
  const auto color = message.subspan(kAccessUnits + head->depth_bytes, head->color_bytes);
  return EncodedFrame{.keyframe = head->keyframe,
                      .sequence = head->sequence,
                      .depth = {depth.begin(), depth.end()},
                      .color = {color.begin(), color.end()},
                      .durations = head->durations};
}

std::vector<std::uint32_t>& triangle_memory(int number) {
  static std::array<std::vector<std::uint32_t>, 2> memory;
  return memory[number];
}

// Lists the corners of all triangles as indices of the mesh's vertices.
void list_triangles(const renderer::DepthMesh& mesh, std::vector<std::uint32_t>& corners) {
  corners.clear();
  corners.reserve(6 * mesh.quads.size() + 3 * mesh.triangles.size());
  for (const auto& patch : mesh.patches) {
    for (std::uint32_t i = 0; i < patch.quads; ++i) {
      const auto& quad = mesh.quads[patch.first_quad + i];
      for (const int corner : {0, 1, 3, 1, 2, 3}) corners.push_back(patch.first_vertex + quad[corner]);
    }
    for (std::uint32_t i = 0; i < patch.triangles; ++i) {
      for (const std::uint16_t corner : mesh.triangles[patch.first_triangle + i])
        corners.push_back(patch.first_vertex + corner);
    }
  }
}

JsonObject describe(const renderer::CameraSurface& surface, int number) {
  const renderer::DepthMesh& mesh = surface.mesh();
  auto& triangles = triangle_memory(number);
  list_triangles(mesh, triangles);
  const auto numbers = [&](const auto& vector) { return std::span(vector).first(mesh.vertices()); };
  JsonObject out;
  out.add_memory("x", numbers(mesh.x))
      .add_memory("y", numbers(mesh.y))
      .add_memory("w", numbers(mesh.w))
      .add_memory("u", numbers(mesh.u))
      .add_memory("v", numbers(mesh.v))
      .add_memory("triangles", std::span(triangles))
      .add_memory("texture", surface.texture().pixels());
  return out;
}

}  // namespace

// The input is a welcome message.
COPRESENCE_EXPORT(open_stream) int open_stream(std::uint32_t bytes) {
  const auto message = input(bytes);
  if (message.size() < wire::kHeaderBytes) return fail_with({ErrorCode::kCorrupt, "a welcome that is cut"});
  const auto welcome = wire::decode_welcome(message.subspan(wire::kHeaderBytes));
  if (!welcome) return fail_with(welcome.error());
  auto opened = CameraStream::open(welcome->description);
  if (!opened) return fail_with(opened.error());
  stream() = std::move(*opened);
  return succeed(describe(welcome->description));
}

// The input is a frame message. Requires open_stream(). The result has "depth" and "color" if the
// browser must decode these pictures.
COPRESENCE_EXPORT(begin_frame) int begin_frame(std::uint32_t bytes) {
  CameraStream& camera = *stream();
  auto frame = read_frame(input(bytes));
  if (!frame) return fail_with(frame.error());
  if (const auto begun = camera.begin(std::move(*frame)); !begun) return fail_with(begun.error());
  const bool keyframe = camera.is_keyframe();
  JsonObject out;
  out.add("sequence", static_cast<double>(camera.metadata().sequence))
      .add("capturedAt", microseconds(camera.metadata().captured_at))
      .add("keyframe", keyframe);
  if (!camera.depth_access_unit().empty())
    out.add("depth", describe(camera.depth_access_unit(), camera.depth_picture(), keyframe));
  if (!camera.color_access_unit().empty())
    out.add("color", describe(camera.color_access_unit(), camera.color_picture(), keyframe));
  return succeed(out);
}

// Returns where the page may copy the colours as RGBA pixels if the browser gives no planes.
COPRESENCE_EXPORT(color_pixels) std::uint8_t* color_pixels() {
  return stream()->color_pixels().data();
}

// `color` is a CameraStream::Color. The result has the memory of depth and states.
COPRESENCE_EXPORT(finish_frame) int finish_frame(std::int32_t color) {
  CameraStream& camera = *stream();
  if (const auto finished = camera.finish(static_cast<CameraStream::Color>(color)); !finished)
    return fail_with(finished.error());
  return succeed(JsonObject()
                     .add_memory("depth", camera.frame().depth.pixels())
                     .add_memory("states", camera.frame().state.pixels()));
}

COPRESENCE_EXPORT(abandon_frame) void abandon_frame() {
  stream()->abandon();
}

// The arguments are the rows of the 3x4 colour correction.
COPRESENCE_EXPORT(set_color_correction)
int set_color_correction(double a, double b, double c, double d, double e, double f, double g, double h,
                         double i, double j, double k, double l) {
  Eigen::Matrix<double, 3, 4> correction;
  correction << a, b, c, d, e, f, g, h, i, j, k, l;
  stream()->set_color_correction(correction.cast<float>());
  return succeed(JsonObject());
}

COPRESENCE_EXPORT(set_step) int set_step(std::int32_t step) {
  stream()->set_step(step);
  return succeed(JsonObject());
}

// The result has the finished frame's mesh, its texture, and the pose of the camera. "remembered" is
// the remembered background's. "rememberedVersion" changes whenever that is another one.
COPRESENCE_EXPORT(make_surface) int make_surface() {
  CameraStream& camera = *stream();
  camera.make_surface();
  const Rigid3& pose = camera.frame().metadata.world_from_camera;
  std::array<double, 12> numbers;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) numbers[4 * row + column] = pose.rotation(row, column);
    numbers[4 * row + 3] = pose.translation(row);
  }
  JsonObject out;
  out.add("surface", describe(camera.surface(), 0))
      .add("width", double(camera.surface_frame().depth.width()))
      .add("height", double(camera.surface_frame().depth.height()))
      .add_memory("surfaceDepth", camera.surface_frame().depth.pixels())
      .add_memory("depth", camera.frame().depth.pixels())
      .add_memory("states", camera.frame().state.pixels())
      .add("hasColor", camera.frame().color.has_value())
      .add("worldFromCamera", std::span<const double>(numbers))
      .add("rememberedVersion", static_cast<double>(camera.remembered_version()));
  if (camera.frame().color) out.add_memory("colors", camera.frame().color->pixels());
  if (camera.remembered()) out.add("remembered", describe(camera.remembered_surface(), 1));
  return succeed(out);
}

}  // namespace copresence::web
