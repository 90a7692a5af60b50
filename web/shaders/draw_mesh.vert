// Projects a vertex of a camera's mesh into the view. The vertex is the point (x, y, 1) / w, so its
// homogeneous coordinates are (x, y, 1, w).
layout(location = 0) in float x;
layout(location = 1) in float y;
layout(location = 2) in float w;  // Inverse depth, 1/m.
layout(location = 3) in float u;  // The camera's pixel.
layout(location = 4) in float v;
uniform mat4 clip_from_camera;
out vec2 pixel;

void main() {
  pixel = vec2(u, v);
  gl_Position = clip_from_camera * vec4(x, y, 1.0, w);
}
