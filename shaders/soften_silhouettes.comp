#version 450 core
// checked with: -DLAYERS=2 -DSHARE=0.25
//
// Mixes the colours of both sides of a silhouette edge along rows or columns (merge_rules.h,
// Silhouettes). Each invocation handles one pixel of the view.
layout(local_size_x = 16, local_size_y = 16) in;

layout(binding = 0) uniform sampler2DArray fragments;  // As in merge_layers.comp.
layout(binding = 1) uniform sampler2DArray depths;
layout(binding = 2) uniform sampler2D merged;
layout(binding = 0, rgba8) writeonly uniform image2D softened;

uniform vec2 w_near_far;  // Inverse depth of the near and the far plane, 1/m.
uniform ivec2 direction;  // (1, 0) along rows, (0, 1) along columns.
uniform float apart;  // At a silhouette edge, the inverse depths differ by more than this, 1/m.

// Returns the inverse depth of the nearest fragment, or 0 if there is none.
float nearest(ivec2 at) {
  float w = 0.0;
  for (int i = 0; i < LAYERS; ++i) {
    if (texelFetch(fragments, ivec3(at, i), 0).a <= 0.0) continue;
    w = max(w, mix(w_near_far.x, w_near_far.y, texelFetch(depths, ivec3(at, i), 0).r));
  }
  return w;
}

void main() {
  const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  const ivec2 size = imageSize(softened);
  if (any(greaterThanEqual(at, size))) return;
  const vec4 own = texelFetch(merged, at, 0);
  vec3 color = own.rgb;
  const float w = nearest(at);
  for (int side = -1; side <= 1; side += 2) {
    const ivec2 beside = at + side * direction;
    if (w <= 0.0 || any(lessThan(beside, ivec2(0))) || any(greaterThanEqual(beside, size))) continue;
    const float other = nearest(beside);
    if (other > 0.0 && abs(w - other) > apart) color += SHARE * (texelFetch(merged, beside, 0).rgb - own.rgb);
  }
  imageStore(softened, at, vec4(color, own.a));
}
