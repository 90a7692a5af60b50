// Copies the view to the canvas, whose first row is at the bottom.
uniform sampler2D view;
layout(location = 0) out vec4 shown;

void main() {
  ivec2 size = textureSize(view, 0), at = ivec2(gl_FragCoord.xy);
  shown = vec4(texelFetch(view, ivec2(at.x, size.y - 1 - at.y), 0).rgb, 1.0);
}
