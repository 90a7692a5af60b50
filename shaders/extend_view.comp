#version 450 core
// checked with: -DLAYERS=2 -DBLOCK=4 -DSAME_SURFACE=0.045 -DFADE_SHARE=0.06
//
// Fills the empty pixels of a view from the estimated blocks, or with the background
// (extension_rules.h, Fading and Pixel). Each invocation handles one pixel of the view.
layout(local_size_x = 16, local_size_y = 16) in;

layout(binding = 0) uniform sampler2D estimates;  // As `surfaces` in extend_blocks.comp.
layout(binding = 1) uniform usampler2D gaps;
layout(binding = 2) uniform usampler2D camera;  // Is 255 where no camera shows anything.
layout(binding = 0, rgba8) writeonly uniform image2D color;
layout(binding = 1, r32f) uniform image2D depth;  // Metres, 0 where no camera shows anything.
layout(binding = 2, r8ui) writeonly uniform uimage2D origin;

uniform int extends;       // If 0, all empty pixels show the background.
uniform float brightness;  // Factor of the extended surfaces' colours.
uniform vec3 background;
uniform vec4 ray_from_pixel;  // The ray (x, y) at z = 1 in the eye's frame is xy * pixel + zw.
uniform float near;           // Metres.
uniform mat4x3 camera_from_eye[LAYERS];
uniform vec4 intrinsics[LAYERS];    // fx, fy, cx, cy.
uniform vec2 picture[LAYERS];       // Width and height, or 0 if the camera is not drawn.
uniform int is_remembered[LAYERS];  // 1 if the layer is a remembered background.

const uint kSeen = 0u, kRemembered = 1u, kExtended = 2u, kEmpty = 3u;

// Returns the opacity of a block: 1 inside a camera's picture, falling to 0 outside.
float opacity(ivec2 block, float w) {
  if (texelFetch(gaps, block, 0).r == 0u) return 1.0;
  const vec2 pixel = vec2(block * BLOCK) + 0.5 * float(BLOCK - 1);
  const vec3 point = vec3(pixel * ray_from_pixel.xy + ray_from_pixel.zw, 1.0) / w;
  float result = 0.0;
  for (int i = 0; i < LAYERS; ++i) {
    if (picture[i].x == 0.0) continue;
    const vec3 in_camera = camera_from_eye[i] * vec4(point, 1.0);
    if (in_camera.z < near) continue;
    const vec2 uv = in_camera.xy / in_camera.z * intrinsics[i].xy + intrinsics[i].zw;
    const vec2 outside = max(max(-uv, uv - (picture[i] - 1.0)), vec2(0.0));
    result = max(result, 1.0 - max(outside.x, outside.y) / (FADE_SHARE * picture[i].x));
  }
  return result;
}

void main() {
  const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at, imageSize(color)))) return;
  if (imageLoad(depth, at).r > 0.0) {
    const uint shown = texelFetch(camera, at, 0).r;
    imageStore(origin, at, uvec4(is_remembered[shown] != 0 ? kRemembered : kSeen));
    return;
  }
  vec4 sum = vec4(0.0);
  float opacities = 0.0, weight = 0.0;
  if (extends != 0) {
    const ivec2 last = textureSize(estimates, 0) - 1;
    const vec2 block = (vec2(at) + 0.5) / float(BLOCK) - 0.5;
    const ivec2 first = clamp(ivec2(floor(block)), ivec2(0), max(last - 1, ivec2(0)));
    const vec2 share = clamp(block - vec2(first), 0.0, 1.0);
    float farthest = 1e9;
    for (int i = 0; i < 4; ++i) {
      const float w = texelFetch(estimates, min(first + ivec2(i & 1, i >> 1), last), 0).a;
      if (w > 0.0) farthest = min(farthest, w);
    }
    for (int i = 0; i < 4; ++i) {
      const ivec2 corner = ivec2(i & 1, i >> 1), from = min(first + corner, last);
      const vec4 surface = texelFetch(estimates, from, 0);
      if (surface.a == 0.0 || abs(surface.a - farthest) > SAME_SURFACE) continue;
      const vec2 shares = mix(1.0 - share, share, vec2(corner));
      const float s = shares.x * shares.y + 1e-4;
      sum += s * surface;
      opacities += s * opacity(from, surface.a);
      weight += s;
    }
  }
  if (weight == 0.0 || opacities < weight / 255.0) {
    imageStore(color, at, vec4(background, 0.0));
    imageStore(origin, at, uvec4(kEmpty));
    return;
  }
  imageStore(color, at, vec4(mix(background, brightness * sum.rgb / weight, opacities / weight), 1.0));
  imageStore(depth, at, vec4(weight / sum.a));
  imageStore(origin, at, uvec4(kExtended));
}
