#version 450 core
// Draws the outlines of flat blocks into a depth image, as inverse depth: straight lines between corners on which all
// adjoining blocks agree, so that coarse and fine triangles meet without cracks. One group per block of 16 pixels a side
// and the first pixels of its neighbours, which come out the same in their own groups.
//
// Few invocations, and loops where a condition would do: software runs a condition's body whether or not anybody needs
// it, and pays for every invocation at every barrier.
layout(local_size_x = 32) in;

layout(binding = 0) uniform usampler2D depth;
layout(binding = 1) uniform sampler2D planes_4;  // by block, find_flat_blocks.comp
layout(binding = 2) uniform sampler2D planes_8;
layout(binding = 3) uniform sampler2D planes_16;
layout(binding = 0, r32f) writeonly uniform image2D inverse;
uniform float units_per_metre;
uniform int largest_block;  // pixels a side; 1 leaves every pixel as it is

const int kPatch = 16;
const int kSide = kPatch + 1;
const int kInvocations = 32;

shared float w[kSide * kSide];
shared bool outlined[kSide * kSide];
shared vec3 drawn_planes[36 + 16 + 9];

ivec2 last;  // the image's last pixel
ivec2 patch_begin;

// Until all of the group have come here, and see what the others wrote.
void wait_for_group() {
  memoryBarrierShared();
  barrier();
}

int number(ivec2 in_patch) { return in_patch.y * kSide + in_patch.x; }

int block_size(int level) { return 4 << level; }

vec3 flat_plane(int level, ivec2 block) {
  if (block_size(level) > largest_block) return vec3(0.0);
  // not an array of samplers, whose index would have to be the same in all invocations
  if (level == 0) return texelFetch(planes_4, block, 0).xyz;
  if (level == 1) return texelFetch(planes_8, block, 0).xyz;
  return texelFetch(planes_16, block, 0).xyz;
}

// The plane of a block that is flat, but in no larger flat one; zeros for others and those beyond the image.
vec3 drawn_plane(int level, ivec2 block) {
  if (any(lessThan(block, ivec2(0))) || any(greaterThanEqual(block * block_size(level), last))) return vec3(0.0);
  for (int above = level + 1; above < 3; ++above) {
    if (flat_plane(above, block >> (above - level)).x > 0.0) return vec3(0.0);
  }
  return flat_plane(level, block);
}

int blocks_across(int level) { return kPatch / block_size(level); }

// Where drawn_planes holds a block; (0, 0) is the patch's first one, and there is one more on every side.
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

// A corner's inverse depth: what the blocks that meet there say on average.
void outline_corner(int level, ivec2 corner) {
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
  if (count == 0.0 || outlined[to]) return;
  w[to] = sum / count;
  outlined[to] = true;
}

void outline_edge(int level, ivec2 corner, ivec2 direction) {
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
    if (outlined[to]) continue;
    w[to] = w[number(begin)] + slope * float(k);
    outlined[to] = true;
  }
}

// Large before small: a small block on a large one's outline has to follow it.
void outline_flat_blocks(int invocation) {
  for (int level = 2; level >= 0; --level) {
    const int blocks = blocks_across(level);
    const int corners = blocks + 1;
    for (int i = invocation; i < corners * corners; i += kInvocations) {
      outline_corner(level, ivec2(i % corners, i / corners));
    }
    wait_for_group();
    for (int i = invocation; i < blocks * corners; i += kInvocations) {
      outline_edge(level, ivec2(i % blocks, i / blocks), ivec2(1, 0));
      outline_edge(level, ivec2(i / blocks, i % blocks), ivec2(0, 1));
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
    outlined[i] = false;
  }
  find_drawn_planes(invocation);
  wait_for_group();
  outline_flat_blocks(invocation);
  for (int i = invocation; i < kSide * kSide; i += kInvocations) {
    const ivec2 at = patch_begin + ivec2(i % kSide, i / kSide);
    if (all(lessThanEqual(at, last))) imageStore(inverse, at, vec4(w[i]));
  }
}
