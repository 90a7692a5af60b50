// Buffers, textures, framebuffers and programs: what goes in comes out, and shaders see it.

#include <array>
#include <numeric>
#include <type_traits>
#include <utility>

#include "common/gl/buffer.h"
#include "common/gl/framebuffer.h"
#include "common/gl/program.h"
#include "common/gl/texture.h"
#include "tests/support/gl_test.h"

namespace copresence::gl {
namespace {

template <class T>
constexpr bool kOwnsAlone = std::is_move_constructible_v<T>&& std::is_move_assignable_v<T> &&
                            !std::is_copy_constructible_v<T> && !std::is_copy_assignable_v<T>;
static_assert(kOwnsAlone<Buffer> && kOwnsAlone<Texture> && kOwnsAlone<Framebuffer> && kOwnsAlone<Program>);
static_assert(!std::is_copy_constructible_v<Context> && !std::is_move_constructible_v<Context>);

using BufferGl = GlTest;
using TextureGl = GlTest;
using ProgramGl = GlTest;
using FramebufferGl = GlTest;

TEST_F(BufferGl, GivesBackWhatWasWritten) {
  Buffer buffer(context(), 64);
  std::vector<std::uint32_t> in(16), out(16, 7);
  buffer.read(std::span(out));
  EXPECT_EQ(out, std::vector<std::uint32_t>(16, 0)) << "new buffers are zero";
  std::iota(in.begin(), in.end(), 100u);
  buffer.write(std::span(std::as_const(in)));
  buffer.write(std::span<const std::uint32_t>(in).first(1), 60);
  buffer.read(std::span(out));
  in[15] = 100;
  EXPECT_EQ(out, in);
  buffer.clear();
  buffer.read(std::span(out));
  EXPECT_EQ(out, std::vector<std::uint32_t>(16, 0));
}

TEST_F(BufferGl, MovesItsNameAndLeavesNone) {
  Buffer first(context(), 4);
  const std::uint32_t id = first.id();
  const Buffer second(std::move(first));
  EXPECT_EQ(second.id(), id);
  EXPECT_EQ(first.id(), 0u);  // NOLINT(bugprone-use-after-move): that is the promise
}

template <class Pixel>
Image<Pixel> numbered(int width, int height) {
  Image<Pixel> image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) image(x, y) = Pixel(3 * x + 50 * y + 1);
  }
  return image;
}

TEST_F(TextureGl, GivesBackEveryFormatAtOddSizes) {
  const auto round_trip = [&]<class Pixel>(Format format, const Image<Pixel>& image) {
    Texture texture(context(), format, image.width(), image.height());
    Image<Pixel> back;
    texture.upload(image);
    texture.read(back);
    EXPECT_EQ(back, image) << int(format);
  };
  round_trip(Format::kR8ui, numbered<std::uint8_t>(5, 3));
  round_trip(Format::kR16ui, numbered<std::uint16_t>(7, 3));
  round_trip(Format::kR32ui, numbered<std::uint32_t>(7, 3));
  round_trip(Format::kR32f, numbered<float>(5, 3));
  round_trip(Format::kRgba8, Image<Rgba8>(5, 3, Rgba8{1, 2, 3, 4}));
  round_trip(Format::kDepth32f, Image<float>(5, 3, 0.625f));
}

TEST_F(TextureGl, WidensColor) {
  Texture texture(context(), Format::kRgba8, 3, 2);
  texture.upload(ColorImage(3, 2, Rgb8{10, 20, 30}));
  Image<Rgba8> back;
  texture.read(back);
  EXPECT_EQ(back, Image<Rgba8>(3, 2, Rgba8{10, 20, 30, 255}));
}

TEST_F(TextureGl, KeepsLayersApart) {
  Texture texture(context(), Format::kR16ui, 5, 3, 2);
  const auto second = numbered<std::uint16_t>(5, 3);
  texture.upload(second, 1);
  Image<std::uint16_t> back;
  texture.read(back, 0);
  EXPECT_EQ(back, Image<std::uint16_t>(5, 3)) << "new textures are zero";
  texture.read(back, 1);
  EXPECT_EQ(back, second);
  texture.clear();
  texture.read(back, 1);
  EXPECT_EQ(back, Image<std::uint16_t>(5, 3));
}

constexpr std::string_view kAddConstant = R"(#version 450 core
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform usampler2D source;
layout(r16ui, binding = 0) writeonly uniform uimage2D target;
uniform int addend;
void main() {
  const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at, imageSize(target)))) return;
  imageStore(target, at, texelFetch(source, at, 0) * FACTOR + addend);
}
)";

TEST_F(ProgramGl, ComputesOverEveryPixelWithItsDefinesAndUniforms) {
  const std::array defines = {Define{"FACTOR", "2"}};
  auto program = Program::compute(context(), kAddConstant, defines);
  ASSERT_TRUE(program.has_value()) << program.error().what;
  Texture source(context(), Format::kR16ui, 21, 13), target(context(), Format::kR16ui, 21, 13);
  const auto image = numbered<std::uint16_t>(21, 13);
  source.upload(image);
  source.bind(0);
  target.bind_image(0, Access::kWrite);
  program->set("addend", 5);
  program->dispatch_over(21, 13);
  context().barrier(Reader::kHost);
  Image<std::uint16_t> back;
  target.read(back);
  for (int y = 0; y < 13; ++y) {
    for (int x = 0; x < 21; ++x) ASSERT_EQ(back(x, y), image(x, y) * 2 + 5);
  }
}

constexpr std::string_view kCount = R"(#version 450 core
layout(local_size_x = 4) in;
layout(std430, binding = 1) buffer Counter { uint count; };
void main() { atomicAdd(count, 1u); }
)";

TEST_F(ProgramGl, RunsTheGroupsThatABufferNames) {
  const auto program = Program::compute(context(), kCount);
  ASSERT_TRUE(program.has_value()) << program.error().what;
  Buffer command(context(), 32), counter(context(), 4);
  command.write(std::span<const DispatchCommand>(std::array{DispatchCommand{7, 2, 1}}), 16);
  counter.bind_storage(1);
  program->dispatch_indirect(command, 16);
  context().barrier(Reader::kHost);
  std::array<std::uint32_t, 1> count{};
  counter.read(std::span(count));
  EXPECT_EQ(count[0], 4u * 7u * 2u);
}

TEST_F(ProgramGl, SaysWhereAShaderIsWrong) {
  const auto program = Program::compute(
      context(), "#version 450 core\nlayout(local_size_x = 1) in;\nvoid main() { int a = 0.5; }\n");
  ASSERT_FALSE(program.has_value());
  EXPECT_EQ(program.error().code, ErrorCode::kInvalid);
  EXPECT_NE(program.error().what.find(":3("), std::string::npos)
      << "the file's own line: " << program.error().what;
  context().take_errors();  // the driver says it too
}

TEST_F(ProgramGl, SaysThatShadersDoNotFitTogether) {
  const auto program =
      Program::graphics(context(), "#version 450 core\nvoid main() { gl_Position = vec4(0); }\n",
                        "#version 450 core\nin vec4 missing;\nout vec4 o;\nvoid main() { o = missing; }\n");
  ASSERT_FALSE(program.has_value());
  EXPECT_NE(program.error().what.find("link"), std::string::npos) << program.error().what;
  context().take_errors();
}

// Three vertices that cover everything, at a depth of 2 * `z` - 1 in clip space.
constexpr std::string_view kCoverVertex = R"(#version 450 core
uniform float z;
void main() {
  const vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
  gl_Position = vec4(corner * 2.0 - 1.0, z * 2.0 - 1.0, 1.0);
}
)";
constexpr std::string_view kPlainFragment = R"(#version 450 core
layout(location = 0) out vec4 color;
layout(location = 1) out uint mark;
uniform float brightness;
void main() { color = vec4(brightness); mark = uint(gl_FragCoord.y); }
)";

TEST_F(FramebufferGl, DrawsTheNearerOfTwo) {
  auto program = Program::graphics(context(), kCoverVertex, kPlainFragment);
  ASSERT_TRUE(program.has_value()) << program.error().what;
  Texture color(context(), Format::kRgba8, 6, 4), mark(context(), Format::kR32ui, 6, 4);
  Texture depth(context(), Format::kDepth32f, 6, 4);
  Framebuffer framebuffer(context(), {&color, &mark}, &depth);
  framebuffer.clear_color(0, {0, 0, 0, 0});
  framebuffer.clear_integers(1, {9, 9, 9, 9});
  framebuffer.clear_depth(1.0f);
  program->set("z", 0.25f);
  program->set("brightness", 1.0f);
  framebuffer.draw(*program, 3);
  program->set("z", 0.75f);
  program->set("brightness", 0.0f);
  framebuffer.draw(*program, 3);
  Image<Rgba8> colors;
  color.read(colors);
  EXPECT_EQ(colors, Image<Rgba8>(6, 4, Rgba8{255, 255, 255, 255}));
  Image<float> depths;
  depth.read(depths);
  EXPECT_FLOAT_EQ(depths(5, 3), 0.25f);
  Image<std::uint32_t> marks;
  mark.read(marks);
  EXPECT_EQ(marks(0, 0), 0u) << "the fragment at y = 0 lies in the first row";
  EXPECT_EQ(marks(0, 3), 3u);
}

TEST_F(FramebufferGl, DrawsTheIndicesThatBuffersName) {
  auto program = Program::graphics(context(), kCoverVertex, kPlainFragment);
  ASSERT_TRUE(program.has_value()) << program.error().what;
  program->set("z", 0.5f);
  program->set("brightness", 1.0f);
  Texture color(context(), Format::kRgba8, 6, 4, 3), mark(context(), Format::kR32ui, 6, 4, 3);
  Framebuffer layer_two(context(), {&color, &mark}, nullptr, 2);
  Buffer indices(context(), 12), command(context(), sizeof(DrawCommand));
  indices.write(std::span<const std::uint32_t>(std::array{0u, 1u, 2u}));
  layer_two.draw_indirect(*program, indices, command);  // of a zeroed command: nothing
  Image<Rgba8> colors;
  color.read(colors, 2);
  EXPECT_EQ(colors(0, 0).r, 0);
  command.write(std::span<const DrawCommand>(std::array{DrawCommand{.indices = 3}}));
  layer_two.draw_indirect(*program, indices, command);
  color.read(colors, 2);
  EXPECT_EQ(colors(0, 0).r, 255);
  color.read(colors, 1);
  EXPECT_EQ(colors(0, 0).r, 0) << "other layers stay";
}

}  // namespace
}  // namespace copresence::gl
