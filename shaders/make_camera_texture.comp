#version 450 core
// checked with: -DCELL=8 -DFILLED_WEIGHT=0.5 -DBORDER_SHARE=0.06 -DAMBIENT=0.15
//
// Computes the colours and weights of a camera's fragments. Red, green and blue are the corrected
// colour, or a gray from the surface normals if the camera has no colour. Alpha is the weight. It
// is cos(theta), reduced for filled pixels and near the border. It is 0 only for pixels that are
// left out (merge_rules.h). Each invocation handles one pixel.
layout(local_size_x = 16, local_size_y = 16) in;

layout(binding = 0) uniform sampler2D incidences;  // One texel per cell, with a linear filter.
layout(binding = 1) uniform usampler2D state;
layout(binding = 2) uniform sampler2D color;
layout(binding = 3) uniform usampler2D depth;
layout(binding = 0, rgba8) writeonly uniform image2D camera_texture;
uniform int has_color;
uniform mat4x3 color_correction;

const uint kHole = 0u, kFilled = 2u;  // DepthStates.

void main() {
  const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at, imageSize(camera_texture)))) return;
  const vec2 in_cells = (vec2(at) + 0.5) / float(CELL);
  const float incidence = textureLod(incidences, in_cells / vec2(textureSize(incidences, 0)), 0.0).r;
  const vec3 shown = has_color != 0 ? color_correction * vec4(texelFetch(color, at, 0).rgb, 1.0)
                                    : vec3(AMBIENT + (1.0 - AMBIENT) * incidence);
  const ivec2 size = imageSize(camera_texture);
  const ivec2 inside = min(at, size - 1 - at);
  const float fade = min(1.0, (float(min(inside.x, inside.y)) + 0.5) / (BORDER_SHARE * float(size.x)));
  const uint state_here = texelFetch(state, at, 0).r;
  const bool is_left_out = state_here != kHole && texelFetch(depth, at, 0).r == 0u;
  const float weight = fade * incidence * (state_here == kFilled ? FILLED_WEIGHT : 1.0);
  imageStore(camera_texture, at, vec4(clamp(shown, 0.0, 1.0), is_left_out ? 0.0 : max(weight, 1.0 / 255.0)));
}
