#version 450 core
// Projects a vertex of a camera's mesh into the view. The vertex is the point (x, y, 1) / w, where
// w is its inverse depth. So its homogeneous coordinates are (x, y, 1, w).
layout(binding = 0) uniform sampler2D inverse;  // Inverse depth w, 1/m.
layout(binding = 1) uniform sampler2D rays;  // The ray (x, y) at z = 1 of each pixel.
uniform mat4 clip_from_camera;

out vec2 pixel;

void main() {
  const int width = textureSize(inverse, 0).x;
  const ivec2 at = ivec2(gl_VertexID % width, gl_VertexID / width);
  pixel = vec2(at);
  gl_Position = clip_from_camera * vec4(texelFetch(rays, at, 0).xy, 1.0, texelFetch(inverse, at, 0).r);
}
