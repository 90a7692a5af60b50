// Smooths one estimated block per fragment (extension_rules.h, Estimate).
uniform sampler2D estimates;  // As `blocks` in extend_blocks.frag.
uniform sampler2D gaps;
layout(location = 0) out vec4 smoothed;

const ivec2 kBeside[4] = ivec2[](ivec2(1, 0), ivec2(-1, 0), ivec2(0, 1), ivec2(0, -1));

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy), size = textureSize(estimates, 0);
  vec4 own = texelFetch(estimates, at, 0);
  vec4 sum = 2.0 * own;
  float weight = 2.0;
  if (texelFetch(gaps, at, 0).r > 0.5 && own.a > 0.0) {
    for (int i = 0; i < 4; ++i) {
      ivec2 beside = at + kBeside[i];
      if (any(lessThan(beside, ivec2(0))) || any(greaterThanEqual(beside, size))) continue;
      vec4 other = texelFetch(estimates, beside, 0);
      if (other.a <= 0.0 || abs(other.a - own.a) > SAME_SURFACE) continue;
      sum += other;
      weight += 1.0;
    }
  }
  smoothed = sum / weight;
}
