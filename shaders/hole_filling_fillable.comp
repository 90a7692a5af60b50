#version 450 core
// checked with: -DWIDEST_GAP=40 -DBORDER=28
//
// Finds the holes that are narrow enough to be filled, one pixel per invocation (fillable.h).
layout(local_size_x = 16, local_size_y = 16) in;

layout(binding = 0) uniform usampler2D depth;
layout(binding = 0, r8ui) writeonly uniform uimage2D fillable;

// Counts the holes from `at` to the next pixel with depth in a direction, at most WIDEST_GAP. The
// border of the image counts as BORDER holes.
int holes(ivec2 at, ivec2 direction) {
  const ivec2 size = textureSize(depth, 0);
  for (int i = 0; i < WIDEST_GAP; ++i) {
    at += direction;
    if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, size))) return min(i + BORDER, WIDEST_GAP);
    if (texelFetch(depth, at, 0).r != 0u) return i;
  }
  return WIDEST_GAP;
}

bool is_narrow(ivec2 at, ivec2 axis) {
  const int before = holes(at, -axis);
  return before < WIDEST_GAP && before + 1 + holes(at, axis) <= WIDEST_GAP;
}

void main() {
  const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at, textureSize(depth, 0)))) return;
  const bool fills = texelFetch(depth, at, 0).r == 0u && (is_narrow(at, ivec2(1, 0)) || is_narrow(at, ivec2(0, 1)));
  imageStore(fillable, at, uvec4(fills ? 1u : 0u));
}
