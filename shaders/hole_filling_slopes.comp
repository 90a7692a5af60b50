#version 450 core
// checked with: -DCELL_ENOUGH=5 -DSTEEPEST=1.0
//
// Computes the slope of the depth of each cell, and its depth at the cell's middle (cells.h). Each
// invocation handles one cell.
layout(local_size_x = 8, local_size_y = 8) in;

uniform ivec2 grid;

struct Cell {  // As in hole_filling_cells.comp.
  float far, near;
  int far_count, near_count;
  vec2 middle;
  vec2 slope;
};
layout(std430, binding = 2) readonly buffer Measured { Cell measured[]; };
layout(std430, binding = 3) writeonly buffer Cells { Cell cells[]; };

const int kApart = 2;  // Cells.

bool is_smooth(Cell cell) { return cell.near_count == 0 && cell.far_count >= CELL_ENOUGH; }

// Adds change of depth and distance from `cell` to another cell, if both lie on one surface.
void add_side(Cell cell, ivec2 at, ivec2 axis, int direction, inout float rise, inout float run) {
  const ivec2 there = at + axis * (kApart * direction);
  if (any(lessThan(there, ivec2(0))) || any(greaterThanEqual(there, grid))) return;
  const Cell other = measured[there.y * grid.x + there.x];
  const float difference = (other.far - cell.far) * float(direction);
  if (!is_smooth(other) || abs(difference) > STEEPEST * float(kApart * 4)) return;
  rise += difference;
  run += float(kApart * 4) + dot(other.middle - cell.middle, vec2(axis)) * float(direction);
}

float slope(Cell cell, ivec2 at, ivec2 axis) {
  float rise = 0.0, run = 0.0;
  add_side(cell, at, axis, 1, rise, run);
  add_side(cell, at, axis, -1, rise, run);
  return run > 0.0 ? rise / run : 0.0;
}

void main() {
  const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at, grid))) return;
  const int index = at.y * grid.x + at.x;
  Cell cell = measured[index];
  if (is_smooth(cell)) {
    cell.slope = vec2(slope(cell, at, ivec2(1, 0)), slope(cell, at, ivec2(0, 1)));
    cell.far -= dot(cell.slope, cell.middle);
  }
  cells[index] = cell;
}
