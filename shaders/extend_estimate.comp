#version 450 core
// checked with: -DSAME_SURFACE=0.045 -DOWN_SURFACE=0.02 -DMOST_SLOPE=0.02 -DMOST_CHANGE=0.07 -DFARTHEST_M=10.0 -DOWN_WEIGHT=2.0
//
// Estimates the surface of each gap from its sources in eight directions (extension_rules.h, Source
// to Estimate). Each invocation handles one block.
layout(local_size_x = 16, local_size_y = 16) in;

layout(binding = 0) uniform sampler2D surfaces;  // As in extend_blocks.comp.
layout(binding = 1) uniform usampler2D gaps;
layout(binding = 0, rgba32f) writeonly uniform image2D estimates;

const ivec2 kDirections[4] = ivec2[](ivec2(1, 0), ivec2(0, 1), ivec2(1, 1), ivec2(1, -1));
const float kNone = 1e9;

struct Source {
  vec4 surface;    // As in `surfaces`; its inverse depth is 0 if there is no source.
  float distance;  // Distance in blocks along the direction.
  float slope;     // Change of the inverse depth per block towards the gap.
};

bool is_same(float w, float other) { return abs(w - other) <= SAME_SURFACE; }

bool is_surface(ivec2 at) {
  return all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, textureSize(surfaces, 0))) && texelFetch(gaps, at, 0).r == 0u;
}

// Returns the source that a search from `at` in the direction -`direction` finds.
Source find_source(ivec2 at, ivec2 direction) {
  ivec2 edge = at;
  float distance = 0.0;
  while (all(greaterThanEqual(edge, ivec2(0))) && all(lessThan(edge, textureSize(surfaces, 0)))) {
    if (texelFetch(gaps, edge, 0).r == 0u) {
      Source source = Source(texelFetch(surfaces, edge, 0), distance, 0.0);
      const ivec2 second = edge - direction, third = second - direction, fourth = third - direction;
      if (!is_surface(second)) return source;
      const vec4 behind = texelFetch(surfaces, second, 0);
      if (!is_same(behind.a, source.surface.a)) return source;
      source = Source(behind, distance + 1.0, 0.0);
      if (!is_surface(third) || !is_surface(fourth)) return source;
      const float w4 = texelFetch(surfaces, fourth, 0).a;
      const float slope = (behind.a - w4) / 2.0;
      const bool is_straight = abs(texelFetch(surfaces, third, 0).a - (behind.a + w4) / 2.0) <= OWN_SURFACE / 4.0;
      if (is_straight && abs(slope) <= MOST_SLOPE) source.slope = slope;
      return source;
    }
    edge -= direction;
    distance += 1.0;
  }
  return Source(vec4(0.0), 0.0, 0.0);
}

float continued(Source source) { return source.surface.a + source.slope * source.distance; }

vec4 alone(Source source, float most_w) {
  const float w = source.surface.a;
  return vec4(source.surface.rgb, min(clamp(continued(source), (1.0 - MOST_CHANGE) * w, (1.0 + MOST_CHANGE) * w), most_w));
}

void main() {
  const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at, imageSize(estimates)))) return;
  const vec4 own = texelFetch(surfaces, at, 0);
  if (texelFetch(gaps, at, 0).r == 0u) {
    imageStore(estimates, at, own);
    return;
  }
  vec4 candidates[5];
  float weights[5];
  int count = 0;
  if (own.a > 0.0) {
    candidates[0] = own;
    weights[0] = OWN_WEIGHT;
    count = 1;
  }
  for (int pair = 0; pair < 4; ++pair) {
    const float unit = pair < 2 ? 1.0 : 1.41421356;
    const Source one = find_source(at, kDirections[pair]), other = find_source(at, -kDirections[pair]);
    if (one.surface.a == 0.0 && other.surface.a == 0.0) continue;
    if (one.surface.a == 0.0 || other.surface.a == 0.0) {
      const bool has_one = one.surface.a > 0.0;
      candidates[count] = has_one ? alone(one, kNone) : alone(other, kNone);
      weights[count] = 1.0 / (1.0 + unit * (has_one ? one.distance : other.distance));
    } else if (is_same(continued(one), continued(other))) {
      candidates[count] = mix(other.surface, one.surface, other.distance / (one.distance + other.distance));
      weights[count] = 2.0 / (1.0 + unit * min(one.distance, other.distance));
    } else if (one.surface.a < other.surface.a) {
      candidates[count] = alone(one, other.surface.a);
      weights[count] = 1.0 / (1.0 + unit * one.distance);
    } else {
      candidates[count] = alone(other, one.surface.a);
      weights[count] = 1.0 / (1.0 + unit * other.distance);
    }
    ++count;
  }
  float farthest = kNone;
  for (int i = 0; i < count; ++i) farthest = min(farthest, candidates[i].a);
  vec4 sum = vec4(0.0);
  float weight = 0.0;
  for (int i = 0; i < count; ++i) {
    if (!is_same(candidates[i].a, farthest)) continue;
    sum += weights[i] * candidates[i];
    weight += weights[i];
  }
  vec4 estimate = weight > 0.0 ? sum / weight : vec4(0.0);
  if (weight > 0.0) estimate.a = max(estimate.a, 1.0 / FARTHEST_M);
  imageStore(estimates, at, estimate);
}
