#version 450 core
// checked with: -DLAYERS=2 -DTIE_RATIO=0.3
//
// Of the cameras' fragments within the uncertainty range of the nearest one the best wins, blended where there is no
// clear winner (merge_rules.h, Merge). One invocation per pixel of the view.
layout(local_size_x = 16, local_size_y = 16) in;

layout(binding = 0) uniform sampler2DArray fragments;  // colour; cos(theta), 0 where there is no fragment
layout(binding = 1) uniform sampler2DArray depths;     // 0 at w = w_near, 1 at w = w_far
layout(binding = 0, rgba8) writeonly uniform image2D merged;
layout(binding = 1, r32f) writeonly uniform image2D merged_depth;
layout(binding = 2, r8ui) writeonly uniform uimage2D merged_camera;
layout(binding = 3, r32f) writeonly uniform image2D merged_quality;

uniform int wants_depth;  // else only `merged` is written
uniform vec2 w_near_far;  // 1/m, along the eye's axis
uniform vec4 ray_from_pixel;            // xy * pixel + zw is (x, y) at z = 1 of the eye
uniform vec4 source_axis[LAYERS];       // dot with (point in eye, 1): depth along that camera's axis, m
uniform float calibration_error[LAYERS];  // m
uniform float noise_per_square[LAYERS];   // m, times the square of the depth along that camera's axis
uniform float precision_factor[LAYERS];   // of the quality index

const uint kNoCamera = 255u;

void main() {
  const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at, imageSize(merged)))) return;
  const vec3 ray = vec3(vec2(at) * ray_from_pixel.xy + ray_from_pixel.zw, 1.0);

  vec3 color[LAYERS];
  float cosine[LAYERS], z[LAYERS], uncertainty[LAYERS], quality[LAYERS];
  int nearest = -1;
  float nearest_z = 0.0, nearest_uncertainty = 0.0;
  for (int i = 0; i < LAYERS; ++i) {
    const vec4 fragment = texelFetch(fragments, ivec3(at, i), 0);
    color[i] = fragment.rgb;
    cosine[i] = fragment.a;
    if (cosine[i] <= 0.0) continue;
    z[i] = 1.0 / mix(w_near_far.x, w_near_far.y, texelFetch(depths, ivec3(at, i), 0).r);
    const float source_z = dot(source_axis[i], vec4(ray * z[i], 1.0));
    uncertainty[i] = noise_per_square[i] * (source_z * source_z) + calibration_error[i];
    quality[i] = precision_factor[i] * cosine[i] / (source_z * source_z);
    if (nearest >= 0 && z[i] >= nearest_z) continue;
    nearest = i;
    nearest_z = z[i];
    nearest_uncertainty = uncertainty[i];
  }

  float worth[LAYERS];
  float best_worth = 0.0, best_z = 0.0, best_quality = 0.0;
  uint best = kNoCamera;
  for (int i = 0; i < LAYERS; ++i) {
    worth[i] = 0.0;
    if (cosine[i] <= 0.0) continue;
    const float range = nearest_uncertainty + uncertainty[i];
    worth[i] = quality[i] * clamp(2.0 - 2.0 * (z[i] - nearest_z) / range, 0.0, 1.0);
    if (worth[i] <= best_worth) continue;
    best = uint(i);
    best_worth = worth[i];
    best_z = z[i];
    best_quality = quality[i];
  }

  vec4 shown = vec4(0.0);
  if (best != kNoCamera) {
    float sum = 0.0;
    for (int i = 0; i < LAYERS; ++i) {
      const float share = clamp((worth[i] - TIE_RATIO * best_worth) / ((1.0 - TIE_RATIO) * best_worth), 0.0, 1.0);
      if (share <= 0.0) continue;
      shown.rgb += share * color[i];
      sum += share;
    }
    shown = vec4(shown.rgb / sum, 1.0);
  }
  imageStore(merged, at, shown);
  if (wants_depth != 0) {
    imageStore(merged_depth, at, vec4(best_z));
    imageStore(merged_camera, at, uvec4(best));
    imageStore(merged_quality, at, vec4(best_quality));
  }
}
