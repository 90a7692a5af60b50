// Rigid transforms and projections. Frames have x right, y down and z forward; lengths are in metres.

export type Vector = [number, number, number];
// Three rows of four numbers: rotation and translation. `aFromB` maps a point of frame b to frame a.
export type Pose = number[];

export const add = (a: Vector, b: Vector): Vector => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const scaled = (a: Vector, by: number): Vector => [a[0] * by, a[1] * by, a[2] * by];
export const subtract = (a: Vector, b: Vector): Vector => add(a, scaled(b, -1));
export const dot = (a: Vector, b: Vector): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a: Vector, b: Vector): Vector =>
  [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = (a: Vector): number => Math.sqrt(dot(a, a));
export const normalized = (a: Vector): Vector => scaled(a, 1 / length(a));

export const column = (pose: Pose, i: number): Vector => [pose[i]!, pose[4 + i]!, pose[8 + i]!];
export const row = (pose: Pose, i: number): number[] => pose.slice(4 * i, 4 * i + 4);
export function fromColumns(x: Vector, y: Vector, z: Vector, translation: Vector): Pose {
  return [0, 1, 2].flatMap((i) => [x[i]!, y[i]!, z[i]!, translation[i]!]);
}

export function transform(pose: Pose, point: Vector): Vector {
  return [0, 1, 2].map((i) => dot(row(pose, i).slice(0, 3) as Vector, point) + pose[4 * i + 3]!) as Vector;
}

export function product(a: Pose, b: Pose): Pose {
  const rotated = (i: number): Vector => transform([...a], column(b, i)).map((v, k) => v - a[4 * k + 3]!) as Vector;
  return fromColumns(rotated(0), rotated(1), rotated(2), transform(a, column(b, 3)));
}

export function inverse(pose: Pose): Pose {
  const rows = [0, 1, 2].map((i) => row(pose, i).slice(0, 3) as Vector);
  const translation = column(pose, 3);
  const moved = [0, 1, 2].map((i) => -dot(column(pose, i), translation)) as Vector;
  return fromColumns(rows[0]!, rows[1]!, rows[2]!, moved);
}

// Rotates a vector about a unit axis.
export function rotated(v: Vector, axis: Vector, angle: number): Vector {
  const c = Math.cos(angle), s = Math.sin(angle);
  return add(add(scaled(v, c), scaled(cross(axis, v), s)), scaled(axis, dot(axis, v) * (1 - c)));
}

// The pose of an eye that looks at `target`, as viewpoint::look_at().
export function lookAt(eye: Vector, target: Vector, up: Vector): Pose {
  const towards = subtract(target, eye);
  const forward = length(towards) > 1e-9 ? normalized(towards) : ([0, 0, 1] as Vector);
  let right = cross(forward, normalized(up));
  if (length(right) < 1e-9) {
    const least = [0, 1, 2].reduce((a, b) => (Math.abs(forward[b]!) < Math.abs(forward[a]!) ? b : a));
    right = cross(forward, [0, 1, 2].map((i) => (i === least ? 1 : 0)) as Vector);
  }
  right = normalized(right);
  return fromColumns(right, cross(forward, right), forward, eye);
}

// A pinhole without distortion. Pixel centres lie at whole coordinates.
export interface Pinhole {
  width: number;
  height: number;
  fx: number;
  fy: number;
  cx: number;
  cy: number;
}

// As camera_from_field_of_view() with a vertical field of view.
export function pinhole(width: number, height: number, fovDegrees: number): Pinhole {
  const focal = height / (2 * Math.tan((fovDegrees * Math.PI) / 360));
  return { width, height, fx: focal, fy: focal, cx: width / 2, cy: height / 2 };
}

export interface Eye {
  intrinsics: Pinhole;
  worldFromEye: Pose;
}
export const kNearM = 0.1, kFarM = 10;

// The matrix from the eye's frame to clip coordinates, by columns. The first row of the view is at
// the bottom. The depth buffer is linear in 1/z: 0 at the near plane and 1 at the far plane.
export function clipFromEye({ width, height, fx, fy, cx, cy }: Pinhole): Float32Array {
  const perW = 1 / (1 / kNearM - 1 / kFarM);
  // prettier-ignore
  return new Float32Array([
    (2 * fx) / width, 0, 0, 0,
    0, (2 * fy) / height, 0, 0,
    (2 * (cx + 0.5)) / width - 1, (2 * (cy + 0.5)) / height - 1, (2 * perW) / kNearM - 1, 1,
    0, 0, -2 * perW, 0,
  ]);
}

// The product of a 4x4 matrix by columns and a pose.
export function times(matrix: Float32Array, pose: Pose): Float32Array {
  const result = new Float32Array(16);
  for (let c = 0; c < 4; ++c) {
    for (let r = 0; r < 4; ++r) {
      let sum = c === 3 ? matrix[12 + r]! : 0;
      for (let k = 0; k < 3; ++k) sum += matrix[4 * k + r]! * pose[4 * k + c]!;
      result[4 * c + r] = sum;
    }
  }
  return result;
}
