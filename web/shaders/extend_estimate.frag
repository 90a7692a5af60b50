// Estimates the surface of each gap from its sources in eight directions (extension_rules.h, Source
// to Estimate). Each fragment is one block.
uniform sampler2D blocks;  // As in extend_blocks.frag.
uniform sampler2D gaps;
layout(location = 0) out vec4 estimate;

const ivec2 kDirections[4] = ivec2[](ivec2(1, 0), ivec2(0, 1), ivec2(1, 1), ivec2(1, -1));
const float kNone = 1e9;

struct Source {
  vec4 surface;    // As in `blocks`; its inverse depth is 0 if there is no source.
  float distance;  // Distance in blocks along the direction.
  float slope;     // Change of the inverse depth per block towards the gap.
};

bool is_same(float w, float other) { return abs(w - other) <= SAME_SURFACE; }

bool is_gap(ivec2 at) { return texelFetch(gaps, at, 0).r > 0.5; }

bool is_inside(ivec2 at) {
  return all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, textureSize(blocks, 0)));
}

bool is_surface(ivec2 at) { return is_inside(at) && !is_gap(at); }

// Returns the source that a search from `at` in the direction -`direction` finds.
Source find_source(ivec2 at, ivec2 direction) {
  ivec2 edge = at;
  float distance = 0.0;
  while (is_inside(edge)) {
    if (!is_gap(edge)) {
      Source source = Source(texelFetch(blocks, edge, 0), distance, 0.0);
      ivec2 second = edge - direction, third = second - direction, fourth = third - direction;
      if (!is_surface(second)) return source;
      vec4 behind = texelFetch(blocks, second, 0);
      if (!is_same(behind.a, source.surface.a)) return source;
      source = Source(behind, distance + 1.0, 0.0);
      if (!is_surface(third) || !is_surface(fourth)) return source;
      float w4 = texelFetch(blocks, fourth, 0).a;
      float slope = (behind.a - w4) / 2.0;
      bool is_straight = abs(texelFetch(blocks, third, 0).a - (behind.a + w4) / 2.0) <= OWN_SURFACE / 4.0;
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
  float w = source.surface.a;
  return vec4(source.surface.rgb,
              min(clamp(continued(source), (1.0 - MOST_CHANGE) * w, (1.0 + MOST_CHANGE) * w), most_w));
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 own = texelFetch(blocks, at, 0);
  if (!is_gap(at)) {
    estimate = own;
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
    float unit = pair < 2 ? 1.0 : 1.41421356;
    Source one = find_source(at, kDirections[pair]), other = find_source(at, -kDirections[pair]);
    if (one.surface.a == 0.0 && other.surface.a == 0.0) continue;
    if (one.surface.a == 0.0 || other.surface.a == 0.0) {
      bool has_one = one.surface.a > 0.0;
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
  estimate = weight > 0.0 ? sum / weight : vec4(0.0);
  if (weight > 0.0) estimate.a = max(estimate.a, 1.0 / FARTHEST_M);
}
