#version 450 core
// checked with: -DCELL_ENOUGH=5 -DREACH_CELLS=12 -DLINKED=5.0 -DWORTH_PIXELS=8 -DSHADOW_PX_PER_STEP=0.16 -DSHADOW_SLACK_PX=2.0
//
// Finds the surfaces on which the holes of a cell may lie (surface_candidates.h). Each invocation
// handles one cell of the list.
layout(local_size_x = 64) in;

layout(binding = 2) uniform sampler2D color;
uniform ivec2 grid;

struct Cell {  // As in hole_filling_cells.comp.
  float far, near;
  int far_count, near_count;
  vec2 middle;
  vec2 slope;
};
struct Guess {
  // x is the inverse depth at the cell's middle in disparity steps, 0 without a surface. The slopes
  // in steps per pixel are y and z. The value near.w is 1 if the near surface is preferred.
  vec4 far, near;
  vec4 far_color, near_color;
};
layout(std430, binding = 0) readonly buffer Commands {
  uint guess_groups, guess_y, guess_z, wanted_count;
  uint fill_groups, fill_y, fill_z, unused;
};
layout(std430, binding = 1) readonly buffer Wanted { uint wanted[]; };
layout(std430, binding = 3) readonly buffer Cells { Cell cells[]; };
layout(std430, binding = 4) writeonly buffer Guesses { Guess guesses[]; };

const ivec2 kDirections[8] = ivec2[8](ivec2(1, 0), ivec2(-1, 0), ivec2(0, 1), ivec2(0, -1), ivec2(1, 1), ivec2(-1, -1),
                                      ivec2(1, -1), ivec2(-1, 1));

// The observations: two surfaces of the cell itself, then two in each direction.
const int kObservations = 18;
vec4 seen[kObservations];  // Steps, two slopes and weight; a weight of 0 means no observation.
int reaches[9];  // Distances of the observations in cells.

// A surface: all observations with steps from `farthest` to `nearest`.
struct Group {
  float farthest, nearest;
  float weight;
};

bool is_in(Group group, int i) {
  return seen[i].w > 0.0 && seen[i].x >= group.farthest && seen[i].x <= group.nearest;
}

// Returns the distance in cells to the next cell with depth, or 0 if there is none.
int reach_of(ivec2 at, ivec2 direction) {
  for (int reach = 1; reach <= REACH_CELLS; ++reach) {
    const ivec2 there = at + reach * direction;
    if (any(lessThan(there, ivec2(0))) || any(greaterThanEqual(there, grid))) return 0;
    const int index = there.y * grid.x + there.x;
    if (cells[index].far_count + cells[index].near_count >= CELL_ENOUGH) return reach;
  }
  return 0;
}

ivec2 place_of(ivec2 at, int observation) {
  const int d = observation / 2;
  return d == 0 ? at : at + reaches[d] * kDirections[d - 1];
}

void look_around(ivec2 at) {
  for (int d = 0; d <= 8; ++d) {
    reaches[d] = d == 0 ? 0 : reach_of(at, kDirections[d - 1]);
    seen[2 * d] = vec4(0.0);
    seen[2 * d + 1] = vec4(0.0);
    if (d == 0 || reaches[d] > 0) {
      const ivec2 from = place_of(at, 2 * d);
      const Cell cell = cells[from.y * grid.x + from.x];
      const vec2 way = vec2((at - from) * 4);
      const float rise = cell.slope.x * way.x + cell.slope.y * way.y;
      const float distance = d == 0 ? 0.6 : float(reaches[d]) * (d > 4 ? 1.41421356 : 1.0);
      const float share = 1.0 / (16.0 * distance * distance);
      seen[2 * d] = vec4(cell.far + rise, cell.slope, share * float(cell.far_count));
      seen[2 * d + 1] = vec4(cell.near + rise, cell.slope, share * float(cell.near_count));
    }
  }
}

// Returns the number of measured pixels in a group.
int pixels_of(ivec2 at, Group group) {
  int sum = 0;
  for (int i = 0; i < kObservations; ++i) {
    if (is_in(group, i)) {
      const ivec2 from = place_of(at, i);
      const int index = from.y * grid.x + from.x;
      sum += i % 2 == 0 ? cells[index].far_count : cells[index].near_count;
    }
  }
  return sum;
}

float weight_of(Group group) {
  float sum = 0.0;
  for (int i = 0; i < kObservations; ++i) sum += is_in(group, i) ? seen[i].w : 0.0;
  return sum;
}

vec3 mean_plane(Group group) {
  vec3 sum = vec3(0.0);
  for (int i = 0; i < kObservations; ++i) sum += is_in(group, i) ? seen[i].w * seen[i].xyz : vec3(0.0);
  return sum / group.weight;
}

vec3 mean_color(ivec2 at, Group group) {
  const ivec2 last = textureSize(color, 0) - 1;
  vec3 sum = vec3(0.0);
  for (int i = 0; i < kObservations; ++i) {
    if (is_in(group, i)) {
      const ivec2 a = min(place_of(at, i) * 4 + 1, last), b = min(a + 1, last);
      sum += 127.5 * seen[i].w / group.weight * (texelFetch(color, a, 0).rgb + texelFetch(color, b, 0).rgb);
    }
  }
  return sum;
}

int opposite_sides(Group group) {
  int axes = 0;
  for (int axis = 0; axis < 4; ++axis) {
    const int one = 2 + 4 * axis, other = one + 2;
    axes += (is_in(group, one) || is_in(group, one + 1)) && (is_in(group, other) || is_in(group, other + 1)) ? 1 : 0;
  }
  return axes;
}

bool in_shadow(Group near, float steps) {
  const float reach = SHADOW_PX_PER_STEP * steps + SHADOW_SLACK_PX;
  bool found = false;
  for (int i = 0; i < 6; ++i) {  // Observations in the row of the cell.
    found = found || (is_in(near, i) && float((reaches[i / 2] - 1) * 4) <= reach);
  }
  return found;
}

void main() {
  if (gl_GlobalInvocationID.x >= wanted_count) return;
  const int index = int(wanted[gl_GlobalInvocationID.x]);
  const ivec2 at = ivec2(index % grid.x, index / grid.x);
  look_around(at);

  // From far to near, a group ends where the next observation is more than LINKED steps nearer.
  const float none = 1e9;
  const Group nothing = Group(none, none, 0.0);
  Group far = nothing, near = nothing, group = nothing;
  float last = 0.0;
  bool done = false;
  while (!done) {
    float next = none;
    for (int i = 0; i < kObservations; ++i) next = seen[i].w > 0.0 && seen[i].x > last ? min(next, seen[i].x) : next;
    if (group.farthest < none && next - last > LINKED) {
      group.nearest = last;
      group.weight = weight_of(group);
      if (pixels_of(at, group) >= WORTH_PIXELS) {
        if (far.weight == 0.0) {
          far = group;
        } else if (group.weight > near.weight) {
          near = group;
        }
      }
      group = nothing;
    }
    if (group.farthest == none) group.farthest = next;
    last = next;
    done = next == none;
  }

  Guess guess = Guess(vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
  if (far.weight > 0.0) guess.far.xyz = mean_plane(far);
  if (near.weight > 0.0) {
    guess.near.xyz = mean_plane(near);
    const bool surrounded = opposite_sides(near) >= 2 && opposite_sides(far) == 0;
    const bool shadowed = in_shadow(near, guess.near.x - guess.far.x);
    guess.near.w = surrounded || (!shadowed && near.weight > far.weight) ? 1.0 : 0.0;
    guess.far_color.rgb = mean_color(at, far);
    guess.near_color.rgb = mean_color(at, near);
  }
  guesses[gl_GlobalInvocationID.x] = guess;
}
