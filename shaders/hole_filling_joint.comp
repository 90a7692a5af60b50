#version 450 core
// checked with: -DSTEPS_TIMES_UNITS=351300.0 -DSAME_SURFACE=3.0 -DGUESS_WEIGHT=0.5 -DCOLOR_SIGMA=24.0
//
// Fills the holes of the listed cells (joint_filling.h). Each invocation handles one pixel.
layout(local_size_x = 256) in;

layout(binding = 0) uniform usampler2D depth;
layout(binding = 1) uniform usampler2D fillable;
layout(binding = 2) uniform sampler2D color;
layout(binding = 0, r16ui) writeonly uniform uimage2D filled;
uniform ivec2 grid;
uniform vec2 range;  // Range of valid depth in depth units, both ends included.
uniform int has_color;

struct Guess {  // As in hole_filling_guess.comp.
  vec4 far, near;
  vec4 far_color, near_color;
};
layout(std430, binding = 0) readonly buffer Commands {
  uint guess_groups, guess_y, guess_z, wanted_count;
  uint fill_groups, fill_y, fill_z, unused;
};
layout(std430, binding = 1) readonly buffer Wanted { uint wanted[]; };
layout(std430, binding = 4) readonly buffer Guesses { Guess guesses[]; };

const float kKernel[5] = float[5](0.37, 0.78, 1.0, 0.78, 0.37);  // Values of exp(-d^2 / 4).

struct Support {
  float weight, rest;
  vec2 place;
};

// Measures how well the measured pixels around a pixel support a plane.
Support support(ivec2 at, vec2 from_middle, vec3 plane) {
  const ivec2 size = textureSize(depth, 0);
  Support sum = Support(0.0, 0.0, vec2(0.0));
  for (int v = -2; v <= 2; ++v) {
    for (int u = -2; u <= 2; ++u) {
      const ivec2 there = at + ivec2(u, v);
      if (any(lessThan(there, ivec2(0))) || any(greaterThanEqual(there, size))) continue;
      const uint units = texelFetch(depth, there, 0).r;
      if (units == 0u) continue;
      const vec2 place = from_middle + vec2(u, v);
      const float above = STEPS_TIMES_UNITS / float(units) - (plane.x + dot(plane.yz, place));
      if (abs(above) > SAME_SURFACE) continue;
      const float weight = kKernel[u + 2] * kKernel[v + 2];
      sum.weight += weight;
      sum.rest += weight * above;
      sum.place += weight * vec2(u, v);
    }
  }
  return sum;
}

float likeness(vec3 a, vec3 b) {
  const vec3 d = a - b;
  const float x = max(0.0, 1.0 - dot(d, d) / (16.0 * COLOR_SIGMA * COLOR_SIGMA));
  const float x2 = x * x, x4 = x2 * x2;
  return x4 * x4;
}

void main() {
  const uint place = gl_GlobalInvocationID.x / 16u;
  if (place >= wanted_count) return;
  const int index = int(wanted[place]), pixel = int(gl_GlobalInvocationID.x % 16u);
  const ivec2 in_cell = ivec2(pixel % 4, pixel / 4);
  const ivec2 at = ivec2(index % grid.x, index / grid.x) * 4 + in_cell;
  if (any(greaterThanEqual(at, textureSize(depth, 0))) || texelFetch(fillable, at, 0).r == 0u) return;
  const Guess guess = guesses[place];
  if (guess.far.x <= 0.0) return;

  const vec2 from_middle = vec2(in_cell) - 1.5;
  Support chosen = support(at, from_middle, guess.far.xyz);
  vec3 plane = guess.far.xyz;
  if (guess.near.x > 0.0) {
    const Support near = support(at, from_middle, guess.near.xyz);
    const bool enclosed =
        near.weight > 2.0 * chosen.weight && dot(near.place, near.place) < 0.25 * near.weight * near.weight;
    bool takes_near = enclosed || (guess.near.w > 0.0 && near.weight >= chosen.weight);
    if (has_color != 0) {
      const vec3 own = 255.0 * texelFetch(color, at, 0).rgb;
      const float like_far = likeness(own, guess.far_color.rgb), like_near = likeness(own, guess.near_color.rgb);
      if (like_near > 4.0 * like_far + 0.2) takes_near = true;
      if (like_far > 4.0 * like_near + 0.2) takes_near = false;
    }
    if (takes_near) {
      chosen = near;
      plane = guess.near.xyz;
    }
  }
  const float s = plane.x + dot(plane.yz, from_middle) + chosen.rest / (chosen.weight + GUESS_WEIGHT);
  if (!(s > 0.0)) return;
  const float units = STEPS_TIMES_UNITS / s + 0.5;
  if (units < range.x || units >= range.y + 1.0) return;
  imageStore(filled, at, uvec4(uint(units)));
}
