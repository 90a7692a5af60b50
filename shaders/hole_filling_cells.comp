#version 450 core
// checked with: -DONE_SURFACE=6.0 -DSTEPS_TIMES_UNITS=351300.0
//
// Computes the depth of cells of 4x4 pixels, and lists the cells that have holes to fill (cells.h).
// Each invocation handles one cell.
layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform usampler2D depth;
layout(binding = 1) uniform usampler2D fillable;
uniform ivec2 grid;  // Columns and rows of cells.

struct Cell {
  float far, near;  // Inverse depth of the cell's surfaces, disparity steps.
  int far_count, near_count;
  vec2 middle;  // Mean position of its measured pixels, pixels from the cell's middle.
  vec2 slope;   // Disparity steps per pixel.
};
layout(std430, binding = 0) buffer Commands {
  uint guess_groups, guess_y, guess_z, wanted_count;
  uint fill_groups, fill_y, fill_z, unused;
};
layout(std430, binding = 1) writeonly buffer Wanted { uint wanted[]; };
layout(std430, binding = 2) writeonly buffer Cells { Cell cells[]; };

void main() {
  const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at, grid))) return;
  const int index = at.y * grid.x + at.x;
  const ivec2 size = textureSize(depth, 0);

  float steps[16];
  float sum = 0.0, nearest = 0.0, farthest = 1e6;
  vec2 places = vec2(0.0);
  int count = 0;
  bool wants = false;
  for (int i = 0; i < 16; ++i) {
    const ivec2 in_cell = ivec2(i % 4, i / 4), pixel = at * 4 + in_cell;
    steps[i] = 0.0;
    if (any(greaterThanEqual(pixel, size))) continue;
    const uint units = texelFetch(depth, pixel, 0).r;
    wants = wants || texelFetch(fillable, pixel, 0).r != 0u;
    if (units == 0u) continue;
    const float s = STEPS_TIMES_UNITS / float(units);
    steps[i] = s;
    sum += s;
    nearest = max(nearest, s);
    farthest = min(farthest, s);
    places += vec2(in_cell);
    ++count;
  }

  Cell cell = Cell(0.0, 0.0, count, 0, vec2(0.0), vec2(0.0));
  if (count > 0) {
    cell.far = sum / float(count);
    cell.middle = places / float(count) - 1.5;
  }
  if (nearest - farthest > ONE_SURFACE) {
    const float halfway = 0.5 * (nearest + farthest);
    float far_sum = 0.0, near_sum = 0.0;
    for (int i = 0; i < 16; ++i) {
      if (steps[i] > halfway) {
        near_sum += steps[i];
        ++cell.near_count;
      } else {
        far_sum += steps[i];
      }
    }
    cell.far_count = count - cell.near_count;
    cell.far = far_sum / float(cell.far_count);
    cell.near = near_sum / float(cell.near_count);
  }
  cells[index] = cell;

  if (!wants) return;
  const uint place = atomicAdd(wanted_count, 1u);
  wanted[place] = uint(index);
  if (place % 64u == 0u) atomicAdd(guess_groups, 1u);
  if (place % 16u == 0u) atomicAdd(fill_groups, 1u);
}
