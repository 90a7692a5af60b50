// Makes a fragment (merge_rules.h, Fragment). Its colour is interpolated between pixels of the
// camera. Its weight is that of the nearest pixel. The texture has a column and a row more than the
// camera's picture.
uniform sampler2D camera_texture;  // With a linear filter.
in vec2 pixel;
layout(location = 0) out vec4 fragment;

void main() {
  ivec2 size = textureSize(camera_texture, 0);
  ivec2 nearest = clamp(ivec2(floor(pixel + 0.5)), ivec2(0), size - 2);
  fragment.rgb = textureLod(camera_texture, (pixel + 0.5) / vec2(size), 0.0).rgb;
  fragment.a = texelFetch(camera_texture, nearest, 0).a;
}
