#version 450 core
// Closes the cracks between planar blocks of different sizes (block_stitching.h). The inverse depth
// along a block's border becomes a straight line between corners that all adjoining blocks share.
// Each group handles a patch: a block of 16 pixels a side and the first pixels of its neighbours.
// Neighbouring groups compute the same values for these pixels.
//
// The shader uses few invocations, and loops in place of conditions. A software renderer executes
// both branches of a condition, and every invocation costs time at every barrier.
layout(local_size_x = 32) in;

layout(binding = 0) uniform usampler2D depth;
layout(binding = 1) uniform sampler2D planes_4;  // Result of find_planar_blocks.comp.
layout(binding = 2) uniform sampler2D planes_8;
layout(binding = 3) uniform sampler2D planes_16;
layout(binding = 0, r32f) writeonly uniform image2D inverse;
uniform float units_per_metre;
uniform int largest_block;  // Pixels a side. With 1, no pixel is changed.

const int kPatch = 16;
const int kSide = kPatch + 1;
const int kInvocations = 32;

shared float w[kSide * kSide];
shared bool stitched[kSide * kSide];
shared vec3 drawn_planes[36 + 16 + 9];

ivec2 last;  // The last pixel of the image.
ivec2 patch_begin;

// Waits until all invocations of the group are here and see each other's writes.
void wait_for_group() {
  memoryBarrierShared();
  barrier();
}

int number(ivec2 in_patch) { return in_patch.y * kSide + in_patch.x; }

int block_size(int level) { return 4 << level; }

vec3 planar_plane(int level, ivec2 block) {
  if (block_size(level) > largest_block) return vec3(0.0);
  // An array of samplers would need the same index in all invocations.
  if (level == 0) return texelFetch(planes_4, block, 0).xyz;
  if (level == 1) return texelFetch(planes_8, block, 0).xyz;
  return texelFetch(planes_16, block, 0).xyz;
}

// Returns the plane of a planar block that lies in no larger planar block. Returns zero for other
// blocks and beyond the image.
vec3 drawn_plane(int level, ivec2 block) {
  if (any(lessThan(block, ivec2(0))) || any(greaterThanEqual(block * block_size(level), last))) return vec3(0.0);
  for (int above = level + 1; above < 3; ++above) {
    if (planar_plane(above, block >> (above - level)).x > 0.0) return vec3(0.0);
  }
  return planar_plane(level, block);
}

int blocks_across(int level) { return kPatch / block_size(level); }

// Returns the index of a block in drawn_planes. Block (0, 0) is the first one of the patch.
// drawn_planes has one more block on every side of the patch.
int plane_number(int level, ivec2 block) {
  const int across = blocks_across(level) + 2;
  return (level == 0 ? 0 : level == 1 ? 36 : 52) + (block.y + 1) * across + block.x + 1;
}

void find_drawn_planes(int invocation) {
  for (int level = 0; level < 3; ++level) {
    const int across = blocks_across(level) + 2;
    for (int i = invocation; i < across * across; i += kInvocations) {
      const ivec2 block = ivec2(i % across, i / across) - 1;
      drawn_planes[plane_number(level, block)] = drawn_plane(level, patch_begin / block_size(level) + block);
    }
  }
}

// Sets the inverse depth of a corner to the mean of the planes that meet there.
void stitch_corner(int level, ivec2 corner) {
  const int size = block_size(level);
  const ivec2 at = min(patch_begin + corner * size, last);
  float sum = 0.0, count = 0.0;
  for (int dy = -1; dy <= 0; ++dy) {
    for (int dx = -1; dx <= 0; ++dx) {
      const ivec2 block = corner + ivec2(dx, dy);
      const vec3 plane = drawn_planes[plane_number(level, block)];
      if (plane.x <= 0.0) continue;
      sum += dot(plane, vec3(1.0, vec2(at - patch_begin - block * size - size / 2)));
      count += 1.0;
    }
  }
  const int to = number(at - patch_begin);
  if (count == 0.0 || stitched[to]) return;
  w[to] = sum / count;
  stitched[to] = true;
}

void stitch_edge(int level, ivec2 corner, ivec2 direction) {
  const int size = block_size(level);
  if (drawn_planes[plane_number(level, corner)].x <= 0.0 &&
      drawn_planes[plane_number(level, corner - direction.yx)].x <= 0.0) {
    return;
  }
  const ivec2 begin = min(patch_begin + corner * size, last) - patch_begin;
  const ivec2 end = min(patch_begin + (corner + direction) * size, last) - patch_begin;
  const int pixels = (end.x - begin.x) + (end.y - begin.y);
  const float slope = (w[number(end)] - w[number(begin)]) / float(max(pixels, 1));
  for (int k = 1; k < pixels; ++k) {
    const int to = number(begin + k * direction);
    if (stitched[to]) continue;
    w[to] = w[number(begin)] + slope * float(k);
    stitched[to] = true;
  }
}

// Stitches large blocks first, because a small block's border must follow that of a larger one.
void stitch_planar_blocks(int invocation) {
  for (int level = 2; level >= 0; --level) {
    const int blocks = blocks_across(level);
    const int corners = blocks + 1;
    for (int i = invocation; i < corners * corners; i += kInvocations) {
      stitch_corner(level, ivec2(i % corners, i / corners));
    }
    wait_for_group();
    for (int i = invocation; i < blocks * corners; i += kInvocations) {
      stitch_edge(level, ivec2(i % blocks, i / blocks), ivec2(1, 0));
      stitch_edge(level, ivec2(i / blocks, i % blocks), ivec2(0, 1));
    }
    wait_for_group();
  }
}

void main() {
  const int invocation = int(gl_LocalInvocationIndex);
  last = textureSize(depth, 0) - 1;
  patch_begin = ivec2(gl_WorkGroupID.xy) * kPatch;
  for (int i = invocation; i < kSide * kSide; i += kInvocations) {
    const uint value = texelFetch(depth, min(patch_begin + ivec2(i % kSide, i / kSide), last), 0).r;
    w[i] = value == 0u ? 0.0 : units_per_metre / float(value);
    stitched[i] = false;
  }
  find_drawn_planes(invocation);
  wait_for_group();
  stitch_planar_blocks(invocation);
  for (int i = invocation; i < kSide * kSide; i += kInvocations) {
    const ivec2 at = patch_begin + ivec2(i % kSide, i / kSide);
    if (all(lessThanEqual(at, last))) imageStore(inverse, at, vec4(w[i]));
  }
}
