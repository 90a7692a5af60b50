#version 450 core
// Fits planes of inverse depth to blocks of 4, 8 and 16 pixels a side (planar_blocks.h). A block
// includes the first pixels of its right and lower neighbours. The plane is zero if the block is
// not planar. Each group handles a 16x16 block, and each invocation a 4x4 block.
layout(local_size_x = 4, local_size_y = 4) in;

layout(binding = 0) uniform usampler2D depth;
// A plane is the inverse depth at the middle of the block and its change per pixel in x and y.
layout(binding = 0, rgba32f) writeonly uniform image2D planes_4;
layout(binding = 1, rgba32f) writeonly uniform image2D planes_8;
layout(binding = 2, rgba32f) writeonly uniform image2D planes_16;
uniform float units_per_metre;
uniform float gap, slope, planar, curvature;  // As in SurfaceLimits (merge_rules.h).

shared vec3 quarters[4][4];
shared vec3 halves[2][2];

const vec3 kNotPlanar = vec3(0.0);

// Waits until all invocations of the group are here and see each other's writes.
void wait_for_group() {
  memoryBarrierShared();
  barrier();
}

float inverse_depth(ivec2 at) {
  const uint value = texelFetch(depth, min(at, textureSize(depth, 0) - 1), 0).r;
  return value == 0u ? 0.0 : units_per_metre / float(value);
}

vec3 fit(ivec2 begin) {
  float w[5][5];
  vec3 plane = vec3(0.0);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 5; ++x) {
      w[y][x] = inverse_depth(begin + ivec2(x, y));
      plane += w[y][x] * vec3(1.0, float(x - 2), float(y - 2));
    }
  }
  // Least squares on a 5 x 5 grid. The squared offsets -2..2 have the sum 10 in each of 5 rows.
  plane *= vec3(1.0 / 25.0, 1.0 / 50.0, 1.0 / 50.0);
  if (abs(plane.y) + abs(plane.z) > gap + slope * plane.x) return kNotPlanar;
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 5; ++x) {
      const float here = dot(plane, vec3(1.0, float(x - 2), float(y - 2)));
      if (abs(w[y][x] - here) > planar) return kNotPlanar;
    }
  }
  return plane;
}

// Returns the distance between two planes at the corner of a quarter. There it is greatest.
float off(vec3 quarter, vec3 whole, float side, vec2 direction) {
  const float middle = whole.x + 0.5 * side * dot(direction, whole.yz);
  return abs(quarter.x - middle) + 0.5 * side * dot(abs(quarter.yz - whole.yz), vec2(1.0));
}

// Returns the common plane of four quarters, each `side` pixels a side, or kNotPlanar.
vec3 join(vec3 a, vec3 b, vec3 c, vec3 d, float side) {
  if (min(min(a.x, b.x), min(c.x, d.x)) <= 0.0) return kNotPlanar;
  const vec3 whole = vec3(0.25 * (a.x + b.x + c.x + d.x), ((b.x - a.x) + (d.x - c.x)) * (0.5 / side),
                          ((c.x - a.x) + (d.x - b.x)) * (0.5 / side));
  const float worst = max(max(off(a, whole, side, vec2(-1.0, -1.0)), off(b, whole, side, vec2(1.0, -1.0))),
                          max(off(c, whole, side, vec2(-1.0, 1.0)), off(d, whole, side, vec2(1.0, 1.0))));
  return worst <= curvature ? whole : kNotPlanar;
}

void main() {
  const ivec2 in_group = ivec2(gl_LocalInvocationID.xy);
  const ivec2 group = ivec2(gl_WorkGroupID.xy);
  const ivec2 block = ivec2(gl_GlobalInvocationID.xy);
  const vec3 quarter = fit(4 * block);
  quarters[in_group.y][in_group.x] = quarter;
  imageStore(planes_4, block, vec4(quarter, 0.0));
  wait_for_group();
  if (all(lessThan(in_group, ivec2(2)))) {
    const ivec2 q = 2 * in_group;
    const vec3 whole = join(quarters[q.y][q.x], quarters[q.y][q.x + 1], quarters[q.y + 1][q.x],
                             quarters[q.y + 1][q.x + 1], 4.0);
    halves[in_group.y][in_group.x] = whole;
    imageStore(planes_8, 2 * group + in_group, vec4(whole, 0.0));
  }
  wait_for_group();
  if (in_group == ivec2(0)) {
    imageStore(planes_16, group, vec4(join(halves[0][0], halves[0][1], halves[1][0], halves[1][1], 8.0), 0.0));
  }
}
