// Merges the fragments of all cameras (merge_rules.h, Merge). Among the fragments within the
// uncertainty range of the nearest, the best is shown. Fragments of similar weight are blended.
uniform highp sampler2DArray fragments;  // Colour and weight; 0 without a fragment.
uniform highp sampler2DArray depths;     // Depth: 0 at the near plane, 1 at the far plane.
uniform vec2 w_near_far;                 // Inverse depth of the near and the far plane, 1/m.
uniform vec4 ray_from_pixel;  // The ray (x, y) at z = 1 in the eye's frame is xy * pixel + zw.
uniform vec4 camera_axis[LAYERS];         // The dot product with a point of the eye's frame is its depth.
uniform float calibration_error[LAYERS];  // Metres.
uniform float noise_per_square[LAYERS];   // As uncertainty_per_square() (merge_rules.h), 1/m.
uniform float precision_factor[LAYERS];   // As precision() (merge_rules.h).
uniform float opacity[LAYERS];            // Factor of the colours.
uniform int rank[LAYERS];                 // As Rank (merge_rules.h); 3 for a layer that is not drawn.
layout(location = 0) out vec4 merged;     // Alpha is 0 where no camera shows anything.
// Depth in metres, the inverse depth of the nearest fragment in 1/m, and the Origin (renderer.h).
layout(location = 1) out vec4 surface;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec3 ray = vec3(vec2(at) * ray_from_pixel.xy + ray_from_pixel.zw, 1.0);

  vec4 fragment[LAYERS];
  int least = 3;
  for (int i = 0; i < LAYERS; ++i) {
    fragment[i] = rank[i] < 3 ? texelFetch(fragments, ivec3(at, i), 0) : vec4(0.0);
    if (fragment[i].a > 0.0) least = min(least, rank[i]);
  }

  float z[LAYERS], uncertainty[LAYERS], quality[LAYERS];
  float nearest_z = 0.0, nearest_uncertainty = 0.0;
  for (int i = 0; i < LAYERS; ++i) {
    if (rank[i] > least) fragment[i].a = 0.0;
    if (fragment[i].a <= 0.0) continue;
    z[i] = 1.0 / mix(w_near_far.x, w_near_far.y, texelFetch(depths, ivec3(at, i), 0).r);
    float camera_z = dot(camera_axis[i], vec4(ray * z[i], 1.0));
    uncertainty[i] = noise_per_square[i] * (camera_z * camera_z) + calibration_error[i];
    quality[i] = precision_factor[i] * fragment[i].a / (camera_z * camera_z);
    if (nearest_z > 0.0 && z[i] >= nearest_z) continue;
    nearest_z = z[i];
    nearest_uncertainty = uncertainty[i];
  }

  float weight[LAYERS];
  float best_weight = 0.0, best_z = 0.0;
  for (int i = 0; i < LAYERS; ++i) {
    weight[i] = 0.0;
    if (fragment[i].a <= 0.0) continue;
    float range = nearest_uncertainty + uncertainty[i];
    weight[i] = quality[i] * clamp(2.0 - 2.0 * (z[i] - nearest_z) / range, 0.0, 1.0);
    if (weight[i] <= best_weight) continue;
    best_weight = weight[i];
    best_z = z[i];
  }

  merged = vec4(0.0);
  surface = vec4(0.0, 0.0, ORIGIN_EMPTY, 0.0);
  if (best_weight <= 0.0) return;
  float sum = 0.0;
  for (int i = 0; i < LAYERS; ++i) {
    float share = clamp((weight[i] - TIE_RATIO * best_weight) / ((1.0 - TIE_RATIO) * best_weight), 0.0, 1.0);
    merged.rgb += share * opacity[i] * fragment[i].rgb;
    sum += share;
  }
  merged = vec4(merged.rgb / sum, 1.0);
  surface = vec4(best_z, 1.0 / nearest_z, least == 2 ? ORIGIN_REMEMBERED : ORIGIN_SEEN, 0.0);
}
