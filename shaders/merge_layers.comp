#version 450 core
// checked with: -DLAYERS=2
//
// Merges the fragments of all cameras (merge_rules.h, Merge). Among the fragments within the
// uncertainty range of the nearest, the best is shown. Fragments of similar weight are blended.
// Each invocation handles one pixel of the view.
layout(local_size_x = 16, local_size_y = 16) in;

layout(binding = 0) uniform sampler2DArray fragments;  // Colour and weight; 0 without a fragment.
layout(binding = 1) uniform sampler2DArray depths;     // Depth: 0 at the near plane, 1 at the far plane.
layout(binding = 0, rgba8) writeonly uniform image2D merged;
layout(binding = 1, r32f) writeonly uniform image2D merged_depth;
layout(binding = 2, r8ui) writeonly uniform uimage2D merged_camera;
layout(binding = 3, r32f) writeonly uniform image2D merged_quality;

uniform int wants_depth;  // If 0, only `merged` is written.
uniform int nearest_only;  // If not 0, the nearest fragment is shown alone (MergeMode::kNearest).
uniform float tie_ratio;   // As tie_ratio() (merge_rules.h).
uniform vec2 w_near_far;  // Inverse depth of the near and the far plane, 1/m.
uniform vec4 ray_from_pixel;  // The ray (x, y) at z = 1 in the eye's frame is xy * pixel + zw.
uniform vec4 camera_axis[LAYERS];         // As MergeLayers::Camera::axis (gl_programs.h).
uniform float calibration_error[LAYERS];  // Metres.
uniform float noise_per_square[LAYERS];   // As uncertainty_per_square() (merge_rules.h), 1/m.
uniform float precision_factor[LAYERS];   // As precision() (merge_rules.h).

const uint kNoCamera = 255u;

void main() {
  const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at, imageSize(merged)))) return;
  const vec3 ray = vec3(vec2(at) * ray_from_pixel.xy + ray_from_pixel.zw, 1.0);

  vec3 color[LAYERS];
  float incidence[LAYERS], z[LAYERS], uncertainty[LAYERS], quality[LAYERS];
  int nearest = -1;
  float nearest_z = 0.0, nearest_uncertainty = 0.0;
  for (int i = 0; i < LAYERS; ++i) {
    const vec4 fragment = texelFetch(fragments, ivec3(at, i), 0);
    color[i] = fragment.rgb;
    incidence[i] = fragment.a;
    if (incidence[i] <= 0.0) continue;
    z[i] = 1.0 / mix(w_near_far.x, w_near_far.y, texelFetch(depths, ivec3(at, i), 0).r);
    const float camera_z = dot(camera_axis[i], vec4(ray * z[i], 1.0));
    uncertainty[i] = noise_per_square[i] * (camera_z * camera_z) + calibration_error[i];
    quality[i] = precision_factor[i] * incidence[i] / (camera_z * camera_z);
    if (nearest >= 0 && z[i] >= nearest_z) continue;
    nearest = i;
    nearest_z = z[i];
    nearest_uncertainty = uncertainty[i];
  }

  float weight[LAYERS];
  float best_weight = 0.0, best_z = 0.0, best_quality = 0.0;
  uint best = kNoCamera;
  for (int i = 0; i < LAYERS; ++i) {
    weight[i] = 0.0;
    if (incidence[i] <= 0.0 || (nearest_only != 0 && i != nearest)) continue;
    const float range = nearest_uncertainty + uncertainty[i];
    weight[i] = quality[i] * clamp(2.0 - 2.0 * (z[i] - nearest_z) / range, 0.0, 1.0);
    if (weight[i] <= best_weight) continue;
    best = uint(i);
    best_weight = weight[i];
    best_z = z[i];
    best_quality = quality[i];
  }

  vec4 shown = vec4(0.0);
  if (best != kNoCamera) {
    float sum = 0.0;
    for (int i = 0; i < LAYERS; ++i) {
      const float share = clamp((weight[i] - tie_ratio * best_weight) / ((1.0 - tie_ratio) * best_weight), 0.0, 1.0);
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
