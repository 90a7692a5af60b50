#version 450 core
// Colour between the pixels of the source; its worth from the nearest one (merge_rules.h, Fragment).
layout(binding = 2) uniform sampler2D source;  // filtered

in vec2 pixel;
layout(location = 0) out vec4 fragment;

void main() {
  const ivec2 size = textureSize(source, 0);
  const ivec2 nearest = clamp(ivec2(floor(pixel + 0.5)), ivec2(0), size - 1);
  fragment.rgb = textureLod(source, (pixel + 0.5) / vec2(size), 0.0).rgb;
  fragment.a = texelFetch(source, nearest, 0).a;
}
