// Fills the empty pixels of a view from the estimated blocks, or with the background
// (extension_rules.h, Pixel).
uniform sampler2D estimates;  // As `blocks` in extend_blocks.frag.
uniform sampler2D opacities;  // As in extend_fade.frag.
uniform sampler2D color;
uniform sampler2D surfaces;   // As `surface` in merge_layers.frag.
uniform bool extends;         // If false, all empty pixels show the background.
uniform float brightness;     // Factor of the extended surfaces' colours.
uniform vec3 background;
layout(location = 0) out vec4 filled;   // Alpha is 0 where the background is shown.
layout(location = 1) out vec4 surface;  // As in merge_layers.frag.

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  surface = texelFetch(surfaces, at, 0);
  filled = vec4(texelFetch(color, at, 0).rgb, 1.0);
  if (surface.r > 0.0) return;
  vec4 sum = vec4(0.0);
  float opacity = 0.0, weight = 0.0;
  if (extends) {
    ivec2 last = textureSize(estimates, 0) - 1;
    vec2 block = (vec2(at) + 0.5) / float(BLOCK) - 0.5;
    ivec2 first = clamp(ivec2(floor(block)), ivec2(0), max(last - 1, ivec2(0)));
    vec2 share = clamp(block - vec2(first), 0.0, 1.0);
    float farthest = 1e9;
    for (int i = 0; i < 4; ++i) {
      float w = texelFetch(estimates, min(first + ivec2(i & 1, i >> 1), last), 0).a;
      if (w > 0.0) farthest = min(farthest, w);
    }
    for (int i = 0; i < 4; ++i) {
      ivec2 corner = ivec2(i & 1, i >> 1), from = min(first + corner, last);
      vec4 estimate = texelFetch(estimates, from, 0);
      if (estimate.a == 0.0 || abs(estimate.a - farthest) > SAME_SURFACE) continue;
      vec2 shares = mix(1.0 - share, share, vec2(corner));
      float s = shares.x * shares.y + 1e-4;
      sum += s * estimate;
      opacity += s * texelFetch(opacities, from, 0).r;
      weight += s;
    }
  }
  if (weight == 0.0 || opacity < weight / 255.0) {
    filled = vec4(background, 0.0);
    surface = vec4(0.0, 0.0, ORIGIN_EMPTY, 0.0);
    return;
  }
  filled = vec4(mix(background, brightness * sum.rgb / weight, opacity / weight), 1.0);
  surface = vec4(weight / sum.a, 0.0, ORIGIN_EXTENDED, 0.0);
}
