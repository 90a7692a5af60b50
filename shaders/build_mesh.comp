#version 450 core
// Makes triangles from a depth image (merge_rules.h, Surface). A planar block becomes two
// triangles. Other pixels are connected to neighbours on the same surface. Each invocation handles
// the quad to the lower right of one pixel.
layout(local_size_x = 16, local_size_y = 16) in;

layout(binding = 0) uniform sampler2D inverse;   // Result of stitch_planar_blocks.comp.
layout(binding = 1) uniform sampler2D planes_4;  // Result of find_planar_blocks.comp.
layout(binding = 2) uniform sampler2D planes_8;
layout(binding = 3) uniform sampler2D planes_16;
layout(std430, binding = 0) buffer Command {
  uint index_count;
  uint instances, first_index;
  int base_vertex;
  uint base_instance;
};
layout(std430, binding = 1) writeonly buffer Indices { uint indices[]; };
uniform float gap, slope;   // As in SurfaceLimits (merge_rules.h).
uniform int largest_block;  // Pixels a side. With 1, planar blocks are ignored.

shared uint group_triangles;
shared uint group_begin;

bool connected(float p, float q, float r) {
  const float nearest = max(p, max(q, r));
  const float farthest = min(p, min(q, r));
  return farthest > 0.0 && nearest - farthest <= gap + slope * farthest;
}

// Returns the side of the largest planar block that contains the pixel, or 1 if there is none.
int planar_side(ivec2 at) {
  if (largest_block >= 16 && texelFetch(planes_16, at / 16, 0).x > 0.0) return 16;
  if (largest_block >= 8 && texelFetch(planes_8, at / 8, 0).x > 0.0) return 8;
  if (largest_block >= 4 && texelFetch(planes_4, at / 4, 0).x > 0.0) return 4;
  return 1;
}

float w_at(ivec2 at) { return texelFetch(inverse, at, 0).r; }

void main() {
  const uint invocation = gl_LocalInvocationIndex;
  if (invocation == 0u) group_triangles = 0u;
  barrier();

  // The corners of the quad are a, b, c, d, clockwise from the top left as the camera sees them.
  const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  const ivec2 last = textureSize(inverse, 0) - 1;
  uvec3 first = uvec3(0u), second = uvec3(0u);
  bool has_first = false, has_second = false;
  if (all(lessThan(at, last))) {
    const int side = planar_side(at);
    const ivec2 to = min(at + side, last);
    const int width = last.x + 1;
    const uint a = uint(at.y * width + at.x), b = uint(at.y * width + to.x);
    const uint c = uint(to.y * width + to.x), d = uint(to.y * width + at.x);
    bool from_a_to_c = false;  // Whether the diagonal runs from a to c, not from b to d.
    if (side > 1) {
      has_first = has_second = at % side == ivec2(0);
    } else {
      const float wa = w_at(at), wb = w_at(ivec2(to.x, at.y)), wc = w_at(to), wd = w_at(ivec2(at.x, to.y));
      const bool abd = connected(wa, wb, wd), bcd = connected(wb, wc, wd);
      const bool abc = connected(wa, wb, wc), acd = connected(wa, wc, wd);
      from_a_to_c = !(abd && bcd) && (abc && acd || !(abd || bcd));
      has_first = from_a_to_c ? abc : abd;
      has_second = from_a_to_c ? acd : bcd;
    }
    first = from_a_to_c ? uvec3(a, b, c) : uvec3(a, b, d);
    second = from_a_to_c ? uvec3(a, c, d) : uvec3(b, c, d);
  }
  const uint count = uint(has_first) + uint(has_second);

  // Each group reserves its indices by a single global atomic operation.
  const uint in_group = count > 0u ? atomicAdd(group_triangles, count) : 0u;
  barrier();
  if (invocation == 0u) group_begin = atomicAdd(index_count, 3u * group_triangles);
  barrier();
  uint to = group_begin + 3u * in_group;
  if (has_first) {
    indices[to] = first.x;
    indices[to + 1u] = first.y;
    indices[to + 2u] = first.z;
    to += 3u;
  }
  if (has_second) {
    indices[to] = second.x;
    indices[to + 1u] = second.y;
    indices[to + 2u] = second.z;
  }
}
