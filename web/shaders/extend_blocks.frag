// Computes the surface of one block of the view per fragment (extension_rules.h, Block).
uniform sampler2D color;
uniform sampler2D surfaces;  // As `surface` in merge_layers.frag.
layout(location = 0) out vec4 block;  // Red, green, blue and inverse depth in 1/m; 0 without a surface.
layout(location = 1) out vec4 gap;    // 1 if a pixel of the block is empty.

void main() {
  ivec2 first = ivec2(gl_FragCoord.xy) * BLOCK, end = min(first + BLOCK, textureSize(color, 0));
  float farthest_z = 0.0;
  gap = vec4(0.0);
  for (int y = first.y; y < end.y; ++y) {
    for (int x = first.x; x < end.x; ++x) {
      float z = texelFetch(surfaces, ivec2(x, y), 0).r;
      farthest_z = max(farthest_z, z);
      if (z <= 0.0) gap = vec4(1.0);
    }
  }
  vec4 sum = vec4(0.0);
  float count = 0.0;
  for (int y = first.y; y < end.y; ++y) {
    for (int x = first.x; x < end.x; ++x) {
      float z = texelFetch(surfaces, ivec2(x, y), 0).r;
      if (z <= 0.0 || 1.0 / z > 1.0 / farthest_z + OWN_SURFACE) continue;
      sum += vec4(texelFetch(color, ivec2(x, y), 0).rgb, 1.0 / z);
      count += 1.0;
    }
  }
  block = count > 0.0 ? sum / count : vec4(0.0);
}
