#version 450 core
// checked with: -DOWN_SURFACE=0.02 -DLEAST_VISIBLE_SHARE=0.02 -DMIXED_COLORS=2
//
// Gives extended surfaces the colours of one camera (extension_rules.h, Colour). Runs once per
// camera, the last camera of the list first. Each invocation handles one pixel of the view.
layout(local_size_x = 16, local_size_y = 16) in;

layout(binding = 0) uniform sampler2D depth;            // Metres along the eye's axis.
layout(binding = 1) uniform usampler2D origin;
layout(binding = 2) uniform sampler2D inverse;          // 1/m along the camera's axis, 0 without depth.
layout(binding = 3) uniform sampler2D camera_texture;   // Corrected colours; alpha is 0 for left-out pixels.
layout(binding = 0, rgba8) writeonly uniform image2D color;

uniform vec4 ray_from_pixel;   // The ray (x, y) at z = 1 in the eye's frame is xy * pixel + zw.
uniform mat4x3 camera_from_eye;
uniform vec4 intrinsics;       // fx, fy, cx, cy.
uniform vec4 radial_tangential;  // k1, k2, p1, p2 of CameraModel::distortion.
uniform vec4 rational;           // k3, k4, k5, k6.
uniform float brightness;      // Factor of the colours.

const uint kExtended = 2u;  // An Origin.

vec2 distorted(vec2 ray) {
  const float r2 = dot(ray, ray);
  const float radial = (1.0 + r2 * (radial_tangential.x + r2 * (radial_tangential.y + r2 * rational.x))) /
                       (1.0 + r2 * (rational.y + r2 * (rational.z + r2 * rational.w)));
  const vec2 tangential = radial_tangential.zw;
  return ray * radial + 2.0 * ray.x * ray.y * tangential + tangential.yx * (r2 + 2.0 * ray * ray);
}

// Whether a pixel shows something nearer than `nearest_visible`, or something that is left out.
bool is_hidden(ivec2 at, float nearest_visible) {
  const ivec2 inside = clamp(at, ivec2(0), textureSize(inverse, 0) - 1);
  return texelFetch(inverse, inside, 0).r > nearest_visible || texelFetch(camera_texture, inside, 0).a == 0.0;
}

// Moves `at` away from hidden pixels. The pixels beside them may have some of their colour. Returns
// false if all pixels around are hidden.
bool move_from_edges(inout vec2 at, float nearest_visible) {
  const ivec2 nearest = ivec2(at + 0.5), across = ivec2(MIXED_COLORS, 0), along = across.yx;
  const bvec4 hidden = bvec4(is_hidden(nearest - across, nearest_visible), is_hidden(nearest + across, nearest_visible),
                             is_hidden(nearest - along, nearest_visible), is_hidden(nearest + along, nearest_visible));
  const ivec4 i = ivec4(hidden);
  at = clamp(at + float(MIXED_COLORS) * vec2(i.x - i.y, i.z - i.w), vec2(0.0), vec2(textureSize(inverse, 0) - 1));
  return !all(hidden);
}

void main() {
  const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at, imageSize(color)))) return;
  if (texelFetch(origin, at, 0).r != kExtended) return;
  const float z = texelFetch(depth, at, 0).r;
  const vec3 point = camera_from_eye * vec4(vec3(vec2(at) * ray_from_pixel.xy + ray_from_pixel.zw, 1.0) * z, 1.0);
  if (point.z <= 0.0) return;
  vec2 pixel = distorted(point.xy / point.z) * intrinsics.xy + intrinsics.zw;
  const ivec2 last = textureSize(inverse, 0) - 1;
  if (any(lessThan(pixel, vec2(0.0))) || any(greaterThan(pixel, vec2(last)))) return;
  const float nearest_visible = 1.0 / point.z + OWN_SURFACE;
  if (!move_from_edges(pixel, nearest_visible)) return;
  const ivec2 first = ivec2(pixel);
  const vec2 share = pixel - vec2(first);
  vec3 sum = vec3(0.0);
  float shares = 0.0;
  for (int i = 0; i < 4; ++i) {
    const ivec2 corner = ivec2(i & 1, i >> 1), from = min(first + corner, last);
    if (is_hidden(from, nearest_visible)) continue;
    const vec2 part = mix(1.0 - share, share, vec2(corner));
    sum += part.x * part.y * texelFetch(camera_texture, from, 0).rgb;
    shares += part.x * part.y;
  }
  if (shares < LEAST_VISIBLE_SHARE) return;
  imageStore(color, at, vec4(brightness * sum / shares, 1.0));
}
