#version 450 core
// checked with: -DBLOCK=4 -DOWN_SURFACE=0.02
//
// Computes the surface of one block of the view per invocation (extension_rules.h, Block).
layout(local_size_x = 16, local_size_y = 16) in;

layout(binding = 0) uniform sampler2D color;
layout(binding = 1) uniform sampler2D depth;  // Metres, 0 where no camera shows anything.
// Red, green, blue and inverse depth in 1/m, which is 0 without a surface.
layout(binding = 0, rgba32f) writeonly uniform image2D surfaces;
layout(binding = 1, r8ui) writeonly uniform uimage2D gaps;  // 1 if a pixel of the block is empty.

void main() {
  const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at, imageSize(surfaces)))) return;
  const ivec2 first = at * BLOCK, end = min(first + BLOCK, textureSize(depth, 0));
  float farthest_z = 0.0;
  uint gap = 0u;
  for (int y = first.y; y < end.y; ++y) {
    for (int x = first.x; x < end.x; ++x) {
      const float z = texelFetch(depth, ivec2(x, y), 0).r;
      farthest_z = max(farthest_z, z);
      if (z <= 0.0) gap = 1u;
    }
  }
  vec4 sum = vec4(0.0);
  float count = 0.0;
  if (farthest_z > 0.0) {
    for (int y = first.y; y < end.y; ++y) {
      for (int x = first.x; x < end.x; ++x) {
        const float z = texelFetch(depth, ivec2(x, y), 0).r;
        if (z <= 0.0 || 1.0 / z > 1.0 / farthest_z + OWN_SURFACE) continue;
        sum += vec4(texelFetch(color, ivec2(x, y), 0).rgb, 1.0 / z);
        count += 1.0;
      }
    }
  }
  imageStore(surfaces, at, count > 0.0 ? sum / count : vec4(0.0));
  imageStore(gaps, at, uvec4(gap));
}
