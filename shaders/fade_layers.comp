#version 450 core
// checked with: -DLAYERS=2
//
// Fades the fragments of stale cameras and of remembered backgrounds. Clears them where a layer of a
// lower rank has a fragment (merge_rules.h, Stale and Remembered). Each invocation handles one pixel
// of the view.
layout(local_size_x = 16, local_size_y = 16) in;

layout(binding = 0, rgba8) uniform image2DArray fragments;  // As in merge_layers.comp.

uniform float opacity[LAYERS];
uniform int rank[LAYERS];  // 0 for a live camera, 1 for a stale one, 2 for a remembered background.

void main() {
  const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at, imageSize(fragments).xy))) return;
  int least = 3;  // Is greater than any rank.
  for (int i = 0; i < LAYERS; ++i) {
    if (rank[i] < least && imageLoad(fragments, ivec3(at, i)).a > 0.0) least = rank[i];
  }
  for (int i = 0; i < LAYERS; ++i) {
    if (rank[i] == 0) continue;
    const vec4 fragment = imageLoad(fragments, ivec3(at, i));
    imageStore(fragments, ivec3(at, i),
               rank[i] > least ? vec4(0.0) : vec4(opacity[i] * fragment.rgb, fragment.a));
  }
}
