// Computes the opacity of one block per fragment (extension_rules.h, Fading): 1 inside a camera's
// picture, falling to 0 outside.
uniform sampler2D estimates;  // As `blocks` in extend_blocks.frag.
uniform sampler2D gaps;
uniform vec4 ray_from_pixel;  // As in merge_layers.frag.
uniform float near_m;
uniform vec4 camera_from_eye[3 * LAYERS];  // The rows of each matrix.
uniform vec4 intrinsics[LAYERS];           // fx, fy, cx, cy.
uniform vec2 picture[LAYERS];  // Width and height; 0 for layers that are not a live camera's.
layout(location = 0) out vec4 opacity;

void main() {
  ivec2 block = ivec2(gl_FragCoord.xy);
  opacity = vec4(1.0);
  float w = texelFetch(estimates, block, 0).a;
  if (w <= 0.0 || texelFetch(gaps, block, 0).r < 0.5) return;
  vec2 pixel = vec2(block * BLOCK) + 0.5 * float(BLOCK - 1);
  vec4 point = vec4(vec3(pixel * ray_from_pixel.xy + ray_from_pixel.zw, 1.0) / w, 1.0);
  float most = 0.0;
  for (int i = 0; i < LAYERS; ++i) {
    if (picture[i].x == 0.0) continue;
    vec3 in_camera = vec3(dot(camera_from_eye[3 * i], point), dot(camera_from_eye[3 * i + 1], point),
                          dot(camera_from_eye[3 * i + 2], point));
    if (in_camera.z < near_m) continue;
    vec2 uv = in_camera.xy / in_camera.z * intrinsics[i].xy + intrinsics[i].zw;
    vec2 outside = max(max(-uv, uv - (picture[i] - 1.0)), vec2(0.0));
    most = max(most, 1.0 - max(outside.x, outside.y) / (FADE_SHARE * picture[i].x));
  }
  opacity = vec4(most);
}
