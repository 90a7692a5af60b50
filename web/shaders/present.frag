// Copies the view to a part of the output, whose first row is at the bottom.
uniform sampler2D view;       // Alpha is 0 where the background is shown.
uniform ivec2 corner;         // Of the part, in pixels.
uniform bool is_transparent;  // Whether the real world shows through the background.
layout(location = 0) out vec4 shown;

void main() {
  ivec2 size = textureSize(view, 0), at = ivec2(gl_FragCoord.xy) - corner;
  shown = texelFetch(view, ivec2(at.x, size.y - 1 - at.y), 0);
  shown = is_transparent ? vec4(shown.rgb * shown.a, shown.a) : vec4(shown.rgb, 1.0);
}
