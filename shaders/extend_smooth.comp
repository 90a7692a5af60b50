#version 450 core
// checked with: -DSAME_SURFACE=0.045
//
// Smooths one estimated block per invocation (extension_rules.h, Estimate).
layout(local_size_x = 16, local_size_y = 16) in;

layout(binding = 0) uniform sampler2D estimates;  // As `surfaces` in extend_blocks.comp.
layout(binding = 1) uniform usampler2D gaps;
layout(binding = 0, rgba32f) writeonly uniform image2D smoothed;

const ivec2 kBeside[4] = ivec2[](ivec2(1, 0), ivec2(-1, 0), ivec2(0, 1), ivec2(0, -1));

void main() {
  const ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = imageSize(smoothed);
  if (any(greaterThanEqual(at, size))) return;
  const vec4 own = texelFetch(estimates, at, 0);
  vec4 sum = 2.0 * own;
  float weight = 2.0;
  if (texelFetch(gaps, at, 0).r != 0u && own.a > 0.0) {
    for (int i = 0; i < 4; ++i) {
      const ivec2 beside = at + kBeside[i];
      if (any(lessThan(beside, ivec2(0))) || any(greaterThanEqual(beside, size))) continue;
      const vec4 other = texelFetch(estimates, beside, 0);
      if (other.a <= 0.0 || abs(other.a - own.a) > SAME_SURFACE) continue;
      sum += other;
      weight += 1.0;
    }
  }
  imageStore(smoothed, at, sum / weight);
}
