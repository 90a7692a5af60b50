#version 450 core
// checked with: -DLAYERS=2
//
// Fades the fragments of stale cameras, and clears them where a live camera has a fragment
// (merge_rules.h, Stale). Each invocation handles one pixel of the view.
layout(local_size_x = 16, local_size_y = 16) in;

layout(binding = 0, rgba8) uniform image2DArray fragments;  // As in merge_layers.comp.

uniform float opacity[LAYERS];  // It is 1 for a live camera.

void main() {
  const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at, imageSize(fragments).xy))) return;
  bool is_live = false;
  for (int i = 0; i < LAYERS; ++i) {
    if (opacity[i] >= 1.0 && imageLoad(fragments, ivec3(at, i)).a > 0.0) is_live = true;
  }
  for (int i = 0; i < LAYERS; ++i) {
    if (opacity[i] >= 1.0) continue;
    const vec4 fragment = imageLoad(fragments, ivec3(at, i));
    imageStore(fragments, ivec3(at, i), is_live ? vec4(0.0) : vec4(opacity[i] * fragment.rgb, fragment.a));
  }
}
