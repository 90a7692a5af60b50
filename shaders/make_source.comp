#version 450 core
// checked with: -DCELL=8 -DFILLED_WORTH=0.5 -DAMBIENT=0.15
//
// What a camera's fragments look like and what they are worth: matched colour, or the gray of the tilts where there is
// none, and in alpha cos(theta), less for filled pixels; never 0. One invocation per pixel.
layout(local_size_x = 16, local_size_y = 16) in;

layout(binding = 0) uniform sampler2D cosines;  // by cell, filtered
layout(binding = 1) uniform usampler2D state;
layout(binding = 2) uniform sampler2D color;
layout(binding = 0, rgba8) writeonly uniform image2D source;
uniform int has_color;
uniform mat4x3 color_matching;

const uint kFilled = 2u;  // DepthState

void main() {
  const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at, imageSize(source)))) return;
  const vec2 in_cells = (vec2(at) + 0.5) / float(CELL);
  const float cosine = textureLod(cosines, in_cells / vec2(textureSize(cosines, 0)), 0.0).r;
  const vec3 shown = has_color != 0 ? color_matching * vec4(texelFetch(color, at, 0).rgb, 1.0)
                                    : vec3(AMBIENT + (1.0 - AMBIENT) * cosine);
  const float worth = cosine * (texelFetch(state, at, 0).r == kFilled ? FILLED_WORTH : 1.0);
  imageStore(source, at, vec4(clamp(shown, 0.0, 1.0), max(worth, 1.0 / 255.0)));
}
