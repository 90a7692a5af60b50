#version 450 core
// checked with: -DCELL=8 -DCELL_PIXELS=16 -DUNKNOWN_COSINE=0.25
//
// cos(theta) by cell of CELL x CELL pixels: a plane of inverse depth fitted to the cell's pixels (merge_rules.h, kCell).
// One invocation per cell.
layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform usampler2D depth;
layout(binding = 0, r32f) writeonly uniform image2D cosines;
uniform float metres_per_unit;
uniform vec2 focal;   // pixels
uniform vec2 center;  // pixels

float cos_theta(float w, vec2 slope, vec2 ray) {
  const vec3 normal = vec3(slope, w - dot(ray, slope));
  return min(1.0, w / (length(normal) * length(vec3(ray, 1.0))));
}

void main() {
  const ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(cell, imageSize(cosines)))) return;
  const ivec2 begin = cell * CELL;
  const ivec2 end = min(begin + CELL, textureSize(depth, 0));
  const float middle = 0.5 * float(CELL);

  float n = 0.0, w = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
  vec2 sum = vec2(0.0), sum_w = vec2(0.0);
  for (int y = begin.y; y < end.y; ++y) {
    for (int x = begin.x; x < end.x; ++x) {
      const uint value = texelFetch(depth, ivec2(x, y), 0).r;
      if (value == 0u) continue;
      const float inverse = 1.0 / (float(value) * metres_per_unit);
      const vec2 at = vec2(ivec2(x, y) - begin) - middle;
      n += 1.0;
      w += inverse;
      sum += at;
      sum_w += at * inverse;
      xx += at.x * at.x;
      xy += at.x * at.y;
      yy += at.y * at.y;
    }
  }

  float cosine = UNKNOWN_COSINE;
  if (n >= float(CELL_PIXELS)) {
    const float sxx = xx - sum.x * sum.x / n, sxy = xy - sum.x * sum.y / n, syy = yy - sum.y * sum.y / n;
    const vec2 s = sum_w - sum * w / n;
    const float determinant = sxx * syy - sxy * sxy;
    if (determinant >= 1.0) {
      const vec2 slope = vec2(s.x * syy - s.y * sxy, s.y * sxx - s.x * sxy) / determinant;
      const float at_middle = (w - dot(sum, slope)) / n;
      const vec2 ray = (vec2(begin) + middle - center) / focal;
      if (at_middle > 0.0) cosine = cos_theta(at_middle, slope * focal, ray);
    }
  }
  imageStore(cosines, cell, vec4(cosine));
}
