// Prints a checksum of what each FAST module computes from one scene. portable_test.py compares the lines with and without
// AVX2. The scene itself is computed by this program, which is built for x86-64-v2 only.

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "capture_server/hole_filling/hole_filler.h"
#include "capture_server/registration/registration.h"
#include "capture_server/temporal_filter/color_filter.h"
#include "capture_server/temporal_filter/depth_filter.h"
#include "common/color/yuv420.h"
#include "common/depth/depth_codec.h"
#include "render_client/background_memory/background_memory.h"
#include "render_client/color_matching/color_matcher.h"
#include "tests/render_client/renderer/rendering.h"

namespace copresence {
namespace {

// FNV-1a.
class Checksum {
 public:
  template <class T>
  void add(const T* first, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(first);
    for (std::size_t i = 0; i < count * sizeof(T); ++i) value_ = (value_ ^ bytes[i]) * 0x100000001b3;
  }
  template <class Image>
  void add(const Image& image) {
    add(image.pixels().data(), image.pixels().size());
  }
  void print(std::string_view what) const { fmt::print("{} {:016x}\n", what, value_); }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325;
};

renderer::Looking camera_at(double x_m) {
  using namespace renderer;
  Rigid3 world_from_camera;
  world_from_camera.translation.x() = x_m;
  const Surface seen = together({wall(3), plane(Eigen::Vector3d(0.2, 1, 0.1).normalized(), 1.1),
                                 sphere({0.1 - x_m, 0, 1.9}, 0.4), sphere({-0.6 - x_m, 0.3, 1.5}, 0.2)});
  Looking camera(kinect_model(), seen, Paint(gradient), world_from_camera);
  measure_like_a_kinect(camera.frame, 0.04, unsigned(10 + x_m * 10));
  return camera;
}

void try_depth_codecs(const RgbdFrame& frame) {
  depth::DepthFormat format;
  format.width = frame.depth.width();
  format.height = frame.depth.height();
  format.unit = DepthUnit::k100Micrometres;
  for (const std::string_view name : depth::codec_names()) {
    auto encoder = depth::Encoder::open(name, format);
    if (!encoder) continue;  // a name that needs a parameter
    auto decoder = depth::Decoder::open(encoder->description(), format);
    DepthImage depth;
    StateImage states;
    const auto planes = encoder->encode(frame.depth, frame.state, true);
    if (!planes || !decoder || !decoder->decode(*planes, depth, states)) {
      fmt::print("depth {} failed\n", name);
      continue;
    }
    Checksum sum;
    sum.add(depth);
    sum.add(states);
    sum.print(fmt::format("depth {}", name));
  }
}

void try_color(const ColorImage& image) {
  Picture picture(PixelFormat::kYuv420, image.width(), image.height());
  color::rgb_to_yuv420(image, picture);
  ColorImage back(image.width(), image.height());
  color::yuv420_to_rgb(picture, back);
  Checksum sum;
  for (int plane = 0; plane < 3; ++plane) sum.add(picture.plane8(plane).data(), picture.plane8(plane).size());
  sum.add(back);
  sum.print("color");
}

void try_registration(const RgbdFrame& frame) {
  registration::SensorCameras cameras;
  cameras.depth = renderer::kinect_model();
  cameras.color = cameras.depth;
  cameras.color->distortion = {0.1, -0.2, 0.001, -0.001, 0, 0, 0, 0};
  cameras.color_from_depth.translation = {0.025, 0.001, -0.002};
  cameras.unit = DepthUnit::k100Micrometres;
  auto opened = registration::Registration::open(cameras);
  if (!opened) return fmt::print("registration: {}\n", opened.error().what);
  const RgbdFrame registered = opened->apply(frame);
  Checksum sum;
  sum.add(registered.depth);
  sum.add(*registered.color);
  sum.print("registration");
}

void try_hole_filling(RgbdFrame frame, hole_filling::Method method) {
  hole_filling::FrameFormat format;
  format.unit = DepthUnit::k100Micrometres;
  auto filler = hole_filling::open(method, hole_filling::Compute::kCpu, format);
  if (!filler || !(*filler)->fill(frame)) return fmt::print("hole filling {} failed\n", name(method));
  Checksum sum;
  sum.add(frame.depth);
  sum.add(frame.state);
  sum.print(fmt::format("hole filling {}", name(method)));
}

void try_renderer(renderer::Looking& left, renderer::Looking& right) {
  for (double degrees : {0.0, 20.0}) {
    const auto eye = renderer::orbiting_eye(640, 360, degrees, 2);
    InlineExecutor workers;
    const auto renderer = renderer::make_cpu_renderer(workers);
    renderer->set_unseen({.show = renderer::UnseenStyle::Show::kExtend});
    renderer::MergedView view;
    if (!renderer->render(renderer::views_of({&left, &right}), eye, {.color = true, .depth = true}, view))
      return fmt::print("renderer failed\n");
    Checksum sum;
    sum.add(view.depth_m);
    sum.add(view.color);
    sum.print("renderer");
  }
}

// Filters 24 frames with different noise as the server does, and remembers the background.
void try_filters_over_time(renderer::Looking camera) {
  const DepthImage true_depth = camera.frame.depth;
  temporal_filter::DepthFilter depth_filter(true_depth.width(), true_depth.height(),
                                            DepthUnit::k100Micrometres, kKinectV1Noise);
  temporal_filter::ColorFilter color_filter;
  background_memory::BackgroundMemory memory;
  memory.begin(DepthUnit::k100Micrometres, kKinectV1Noise);
  Checksum sum;
  for (unsigned i = 0; i < 24; ++i) {
    RgbdFrame frame = camera.frame;
    renderer::measure_like_a_kinect(frame, 0.04, i);
    if (i == 23) {
      for (int y = 100; y < 300; ++y) std::fill_n(&frame.depth(200, y), 100, std::uint16_t{8000});
    }
    depth_filter.apply(frame.depth, frame.state);
    Picture picture;
    color::rgb_to_yuv420(*frame.color, picture);
    color_filter.apply(picture, depth_filter.is_camera_moving());
    color::yuv420_to_rgb(picture, *frame.color);
    memory.learn(frame);
    sum.add(frame.depth);
    sum.add(*frame.color);
  }
  sum.print("temporal filter");
  if (!memory.covered()) return fmt::print("background memory failed\n");
  Checksum remembered;
  remembered.add(memory.covered()->depth);
  remembered.print("background memory");
}

void try_color_matching(const renderer::Looking& left, const renderer::Looking& right) {
  std::vector<color_matching::PosedFrame> frames;
  for (const renderer::Looking* camera : {&left, &right}) {
    frames.push_back({.frame = &camera->frame,
                      .model = camera->view.model,
                      .unit = camera->view.unit,
                      .noise = {},
                      .world_from_camera = camera->view.world_from_camera});
  }
  Checksum sum;
  for (const auto& correction : color_matching::match_colors(frames)) {
    if (correction) sum.add(correction->data(), std::size_t(correction->size()));
  }
  sum.print("color matching");
}

}  // namespace
}  // namespace copresence

int main() {
  using namespace copresence;
  renderer::Looking left = camera_at(-0.2), right = camera_at(0.2);
  try_depth_codecs(left.frame);
  try_color(*left.frame.color);
  try_registration(left.frame);
  for (const auto method :
       {hole_filling::Method::kMedian, hole_filling::Method::kBilateral, hole_filling::Method::kJoint}) {
    try_hole_filling(left.frame, method);
  }
  try_renderer(left, right);
  try_filters_over_time(left);
  try_color_matching(left, right);
}
