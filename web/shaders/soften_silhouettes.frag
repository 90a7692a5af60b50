// Mixes the colours of both sides of a silhouette edge along rows or columns (merge_rules.h,
// Silhouettes).
uniform sampler2D merged;
uniform sampler2D surfaces;  // As `surface` in merge_layers.frag.
uniform ivec2 direction;     // (1, 0) along rows, (0, 1) along columns.
uniform float apart;  // At a silhouette edge, the inverse depths differ by more than this, 1/m.
layout(location = 0) out vec4 softened;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy), size = textureSize(merged, 0);
  vec4 own = texelFetch(merged, at, 0);
  vec3 color = own.rgb;
  float w = texelFetch(surfaces, at, 0).g;
  for (int side = -1; side <= 1; side += 2) {
    ivec2 beside = at + side * direction;
    if (w <= 0.0 || any(lessThan(beside, ivec2(0))) || any(greaterThanEqual(beside, size))) continue;
    float other = texelFetch(surfaces, beside, 0).g;
    if (other > 0.0 && abs(w - other) > apart)
      color += SILHOUETTE_SHARE * (texelFetch(merged, beside, 0).rgb - own.rgb);
  }
  softened = vec4(color, own.a);
}
