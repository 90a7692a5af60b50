#version 450 core
// checked with: -DCELL=8 -DCELL_PIXELS=16 -DUNKNOWN_INCIDENCE=0.25
//
// Computes cos(theta) of each cell of CELL x CELL pixels (merge_rules.h, kCell). If the cell is not
// a planar block, a plane is fitted to its pixels with depth. Each invocation handles one cell.
layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform usampler2D depth;
layout(binding = 1) uniform sampler2D planes;  // The planes of blocks of CELL pixels.
layout(binding = 0, r32f) writeonly uniform image2D incidences;
uniform float units_per_metre;
uniform vec2 focal;   // Pixels.
uniform vec2 center;  // Pixels.

float cos_theta(float w, vec2 slope, vec2 ray) {
  const vec3 normal = vec3(slope, w - dot(ray, slope));
  return min(1.0, w / (length(normal) * length(vec3(ray, 1.0))));
}

// Fits a plane: inverse depth at the cell's middle, and its change per pixel. Returns zero if the
// pixels with depth are too few or lie on one line.
vec3 fit(ivec2 cell) {
  const ivec2 begin = cell * CELL;
  const ivec2 end = min(begin + CELL, textureSize(depth, 0));
  float n = 0.0, w = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
  vec2 sum = vec2(0.0), sum_w = vec2(0.0);
  for (int y = begin.y; y < end.y; ++y) {
    for (int x = begin.x; x < end.x; ++x) {
      const uint value = texelFetch(depth, ivec2(x, y), 0).r;
      if (value == 0u) continue;
      const float inverse = units_per_metre / float(value);
      const vec2 at = vec2(ivec2(x, y) - begin) - 0.5 * float(CELL);
      n += 1.0;
      w += inverse;
      sum += at;
      sum_w += at * inverse;
      xx += at.x * at.x;
      xy += at.x * at.y;
      yy += at.y * at.y;
    }
  }
  if (n < float(CELL_PIXELS)) return vec3(0.0);
  const float sxx = xx - sum.x * sum.x / n, sxy = xy - sum.x * sum.y / n, syy = yy - sum.y * sum.y / n;
  const vec2 s = sum_w - sum * w / n;
  const float determinant = sxx * syy - sxy * sxy;
  if (determinant < 1.0) return vec3(0.0);
  const vec2 slope = vec2(s.x * syy - s.y * sxy, s.y * sxx - s.x * sxy) / determinant;
  return vec3((w - dot(sum, slope)) / n, slope);
}

void main() {
  const ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(cell, imageSize(incidences)))) return;
  vec3 plane = vec3(0.0);
  if (all(lessThan(cell, textureSize(planes, 0)))) plane = texelFetch(planes, cell, 0).xyz;
  if (plane.x <= 0.0) plane = fit(cell);
  const vec2 ray = ((vec2(cell) + 0.5) * float(CELL) - center) / focal;
  imageStore(incidences, cell, vec4(plane.x > 0.0 ? cos_theta(plane.x, plane.yz * focal, ray) : UNKNOWN_INCIDENCE));
}
