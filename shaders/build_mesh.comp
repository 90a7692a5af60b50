#version 450 core
// checked with: -DGAP_INVERSE=0.0114 -DMAX_SLOPE=5.7
//
// The triangles between neighbouring pixels that lie on one surface (merge_rules.h, Surface and joined()). One
// invocation per quad, named after its top left pixel; corners run a, b, c, d from there clockwise as the camera sees
// them.
layout(local_size_x = 16, local_size_y = 16) in;

layout(binding = 0) uniform usampler2D depth;
layout(std430, binding = 0) buffer Command {
  uint index_count;
  uint instances, first_index;
  int base_vertex;
  uint base_instance;
};
layout(std430, binding = 1) writeonly buffer Indices { uint indices[]; };
uniform float metres_per_unit;
uniform float pixel_angle;  // radians between neighbours

shared uint group_triangles;
shared uint group_begin;

bool joined(float p, float q, float r) {
  const float nearest = max(p, max(q, r));
  const float farthest = min(p, min(q, r));
  return farthest > 0.0 && nearest - farthest <= GAP_INVERSE + MAX_SLOPE * pixel_angle * farthest;
}

float inverse_depth(ivec2 at) {
  const uint value = texelFetch(depth, at, 0).r;
  return value == 0u ? 0.0 : 1.0 / (float(value) * metres_per_unit);
}

void main() {
  if (gl_LocalInvocationIndex == 0u) group_triangles = 0u;
  barrier();

  const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  const ivec2 size = textureSize(depth, 0);
  uvec3 triangles[2];
  uint count = 0u;
  if (all(lessThan(at, size - 1))) {
    const float wa = inverse_depth(at), wb = inverse_depth(at + ivec2(1, 0));
    const float wd = inverse_depth(at + ivec2(0, 1)), wc = inverse_depth(at + ivec2(1, 1));
    const uint a = uint(at.y * size.x + at.x), b = a + 1u, d = a + uint(size.x), c = d + 1u;
    const bool abd = joined(wa, wb, wd), bcd = joined(wb, wc, wd);
    const bool abc = joined(wa, wb, wc), acd = joined(wa, wc, wd);
    if (abd && bcd || !(abc && acd)) {
      if (abd) triangles[count++] = uvec3(a, b, d);
      if (bcd) triangles[count++] = uvec3(b, c, d);
    }
    if (count == 0u) {
      if (abc) triangles[count++] = uvec3(a, b, c);
      if (acd) triangles[count++] = uvec3(a, c, d);
    }
  }

  // One global atomic per group.
  const uint in_group = count > 0u ? atomicAdd(group_triangles, count) : 0u;
  barrier();
  if (gl_LocalInvocationIndex == 0u) group_begin = atomicAdd(index_count, 3u * group_triangles);
  barrier();
  for (uint i = 0u; i < count; ++i) {
    const uint to = group_begin + 3u * (in_group + i);
    indices[to] = triangles[i].x;
    indices[to + 1u] = triangles[i].y;
    indices[to + 2u] = triangles[i].z;
  }
}
