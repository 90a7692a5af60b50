#version 450 core
// A corner of a camera's triangles in the eye's view. With w = 1/z the point is (x, y, 1) / w, so (x, y, 1, w) is the
// point itself in homogeneous coordinates.
layout(binding = 0) uniform sampler2D inverse;  // w, 1/m
layout(binding = 1) uniform sampler2D rays;     // (x, y) at z = 1, without the lens's distortion
uniform mat4 clip_from_camera;

out vec2 pixel;

void main() {
  const int width = textureSize(inverse, 0).x;
  const ivec2 at = ivec2(gl_VertexID % width, gl_VertexID / width);
  pixel = vec2(at);
  gl_Position = clip_from_camera * vec4(texelFetch(rays, at, 0).xy, 1.0, texelFetch(inverse, at, 0).r);
}
