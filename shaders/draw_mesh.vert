#version 450 core
// Projects a vertex of a camera's mesh into the view. With w = 1/z the point is (x, y, 1) / w. So
// (x, y, 1, w) are its homogeneous coordinates.
layout(binding = 0) uniform sampler2D inverse;  // w, 1/m
layout(binding = 1) uniform sampler2D rays;  // (x, y) at z = 1, without lens distortion
uniform mat4 clip_from_camera;

out vec2 pixel;

void main() {
  const int width = textureSize(inverse, 0).x;
  const ivec2 at = ivec2(gl_VertexID % width, gl_VertexID / width);
  pixel = vec2(at);
  gl_Position = clip_from_camera * vec4(texelFetch(rays, at, 0).xy, 1.0, texelFetch(inverse, at, 0).r);
}
