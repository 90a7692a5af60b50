// Gives extended surfaces the colours of one camera (extension_rules.h, Colour). Runs once per
// camera, the last camera of the list first. Other pixels stay as they are.
uniform sampler2D surfaces;         // As `surface` in extend_view.frag.
uniform highp usampler2D depth;     // The camera's depth in its unit, 0 without depth.
uniform sampler2D camera_texture;   // The camera's corrected colours.
uniform float metres_per_unit;
uniform vec4 ray_from_pixel;        // As in merge_layers.frag.
uniform vec4 camera_from_eye[3];    // The rows of the matrix.
uniform vec4 intrinsics;            // fx, fy, cx, cy.
uniform vec4 radial_tangential;     // k1, k2, p1, p2 of CameraModel::distortion.
uniform vec4 rational;              // k3, k4, k5, k6.
uniform float brightness;           // Factor of the colours.
layout(location = 0) out vec4 color;

vec2 distorted(vec2 ray) {
  float r2 = dot(ray, ray);
  float radial = (1.0 + r2 * (radial_tangential.x + r2 * (radial_tangential.y + r2 * rational.x))) /
                 (1.0 + r2 * (rational.y + r2 * (rational.z + r2 * rational.w)));
  vec2 tangential = radial_tangential.zw;
  return ray * radial + 2.0 * ray.x * ray.y * tangential + tangential.yx * (r2 + 2.0 * ray * ray);
}

bool is_hidden(ivec2 at, float nearest_visible) {
  float z = metres_per_unit * float(texelFetch(depth, clamp(at, ivec2(0), textureSize(depth, 0) - 1), 0).r);
  return z > 0.0 && 1.0 / z > nearest_visible;
}

// Moves `at` away from nearer pixels. The pixels beside them may have some of their colour. Returns
// false if all pixels around are nearer.
bool move_from_edges(inout vec2 at, float nearest_visible) {
  ivec2 nearest = ivec2(at + 0.5), across = ivec2(MIXED_COLORS, 0), along = across.yx;
  bvec4 hidden = bvec4(is_hidden(nearest - across, nearest_visible), is_hidden(nearest + across, nearest_visible),
                       is_hidden(nearest - along, nearest_visible), is_hidden(nearest + along, nearest_visible));
  ivec4 i = ivec4(hidden);
  at = clamp(at + float(MIXED_COLORS) * vec2(i.x - i.y, i.z - i.w), vec2(0.0), vec2(textureSize(depth, 0) - 1));
  return !all(hidden);
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 surface = texelFetch(surfaces, at, 0);
  if (surface.b != ORIGIN_EXTENDED) discard;
  vec4 in_eye = vec4(vec3(vec2(at) * ray_from_pixel.xy + ray_from_pixel.zw, 1.0) * surface.r, 1.0);
  vec3 point = vec3(dot(camera_from_eye[0], in_eye), dot(camera_from_eye[1], in_eye), dot(camera_from_eye[2], in_eye));
  if (point.z <= 0.0) discard;
  vec2 pixel = distorted(point.xy / point.z) * intrinsics.xy + intrinsics.zw;
  ivec2 last = textureSize(depth, 0) - 1;
  if (any(lessThan(pixel, vec2(0.0))) || any(greaterThan(pixel, vec2(last)))) discard;
  float nearest_visible = 1.0 / point.z + OWN_SURFACE;
  if (!move_from_edges(pixel, nearest_visible)) discard;
  ivec2 first = ivec2(pixel);
  vec2 share = pixel - vec2(first);
  vec3 sum = vec3(0.0);
  float shares = 0.0;
  for (int i = 0; i < 4; ++i) {
    ivec2 corner = ivec2(i & 1, i >> 1), from = min(first + corner, last);
    if (is_hidden(from, nearest_visible)) continue;
    vec2 part = mix(1.0 - share, share, vec2(corner));
    sum += part.x * part.y * texelFetch(camera_texture, from, 0).rgb;
    shares += part.x * part.y;
  }
  if (shares < LEAST_VISIBLE_SHARE) discard;
  color = vec4(brightness * sum / shares, 1.0);
}
