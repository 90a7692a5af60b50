// An eye that is moved by hand: around a pivot, sideways, closer or farther. The rules are those of
// viewpoint::OrbitView. Distances in gestures are fractions of the view's height.

import { add, column, cross, dot, fromColumns, length, lookAt, normalized, Pose, rotated, scaled, subtract,
         Vector } from './geometry';

const kUp: Vector = [0, -1, 0];
const kPivotM = 2; // A typical distance of a person from a Kinect.
const kTurnPerHeight = Math.PI;
const kClosestToPole = (2 * Math.PI) / 180; // Between the view's direction and the vertical.
const kZoomPerNotch = 0.9;
const kNearestM = 0.1, kFarthestM = 30; // Between eye and pivot.
export const kFovDegrees = 50;

export class OrbitView {
  private resetPose: Pose | null = null;
  private isMoved = false;
  private pose: Pose = fromColumns([1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]);
  private distance = kPivotM;
  fovDegrees = kFovDegrees;

  get worldFromEye(): Pose {
    return this.pose;
  }

  // Moves the eye to this pose, unless a gesture has moved it.
  setResetPose(pose: Pose): void {
    this.resetPose = pose;
    if (!this.isMoved) this.reset();
  }

  reset(): void {
    if (this.resetPose) this.pose = this.resetPose;
    this.distance = kPivotM;
    this.fovDegrees = kFovDegrees;
    this.isMoved = false;
  }

  // The eye after an orbit by these angles, in radians. The view itself stays as it is.
  tilted(right: number, down: number): Pose {
    if (right === 0 && down === 0) return this.pose;
    const { pose, isMoved } = this;
    this.orbit(right / kTurnPerHeight, down / kTurnPerHeight);
    const result = this.pose;
    this.pose = pose;
    this.isMoved = isMoved;
    return result;
  }

  setView(eye: Vector, look: Vector, fovDegrees: number): void {
    this.pose = lookAt(eye, look, kUp);
    this.distance = Math.min(Math.max(length(subtract(look, eye)), kNearestM), kFarthestM);
    this.fovDegrees = fovDegrees;
    this.isMoved = true;
  }

  orbit(right: number, down: number): void {
    this.turnAboutPivot(kUp, -right * kTurnPerHeight);
    const fromUp = Math.acos(Math.min(Math.max(dot(column(this.pose, 2), kUp), -1), 1));
    const lowest = Math.min(kClosestToPole, fromUp), highest = Math.max(Math.PI - kClosestToPole, fromUp);
    const wanted = Math.min(Math.max(fromUp + down * kTurnPerHeight, lowest), highest);
    this.turnAboutPivot(column(this.pose, 0), fromUp - wanted);
  }

  pan(right: number, down: number): void {
    const metres = 2 * Math.tan((this.fovDegrees * Math.PI) / 360) * this.distance;
    this.move(add(scaled(column(this.pose, 0), -right * metres), scaled(column(this.pose, 1), -down * metres)));
  }

  zoom(notches: number): void {
    const pivot = this.pivot();
    this.isMoved = true;
    this.distance = Math.min(Math.max(this.distance * kZoomPerNotch ** notches, kNearestM), kFarthestM);
    this.placeBefore(pivot);
  }

  // Turns the eye to a point of the world, which becomes the pivot.
  focus(point: Vector): void {
    const eye = column(this.pose, 3);
    this.distance = Math.min(Math.max(length(subtract(point, eye)), kNearestM), kFarthestM);
    this.pose = lookAt(eye, point, kUp);
    this.isMoved = true;
  }

  private pivot(): Vector {
    return add(column(this.pose, 3), scaled(column(this.pose, 2), this.distance));
  }

  private move(by: Vector): void {
    this.isMoved = true;
    const [x, y, z] = [0, 1, 2].map((i) => column(this.pose, i)) as [Vector, Vector, Vector];
    this.pose = fromColumns(x, y, z, add(column(this.pose, 3), by));
  }

  private placeBefore(pivot: Vector): void {
    this.move(subtract(subtract(pivot, scaled(column(this.pose, 2), this.distance)), column(this.pose, 3)));
  }

  private turnAboutPivot(axis: Vector, angle: number): void {
    const pivot = this.pivot();
    // Rounding errors of many turns would accumulate without normalisation.
    const z = normalized(rotated(column(this.pose, 2), axis, angle));
    const x = normalized(cross(rotated(column(this.pose, 1), axis, angle), z));
    this.pose = fromColumns(x, cross(z, x), z, column(this.pose, 3));
    this.placeBefore(pivot);
  }
}
