#version 450 core
// A pixel of a depth image as a point in the eye's view.
layout(binding = 0) uniform usampler2D depth;
layout(binding = 1) uniform sampler2D rays;  // (x, y) at z = 1, without the lens's distortion
uniform float metres_per_unit;
uniform mat4 clip_from_camera;

out vec2 pixel;

void main() {
  const int width = textureSize(depth, 0).x;
  const ivec2 at = ivec2(gl_VertexID % width, gl_VertexID / width);
  const float z = float(texelFetch(depth, at, 0).r) * metres_per_unit;
  pixel = vec2(at);
  gl_Position = clip_from_camera * vec4(texelFetch(rays, at, 0).xy * z, z, 1.0);
}
