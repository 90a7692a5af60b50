// Shows the room in a headset by WebXR. One unit of the headset's space is a metre, so the room has
// its real size. The session begins where the eye of the page is, at the same height above the
// floor, and looks in the same direction.

import { add, column, cross, Eye, kFarM, kNearM, length, lookAt, Pose, product, scaled, subtract, Vector, dot }
  from './geometry';
import { Output } from './renderer/renderer';

const kUp: Vector = [0, -1, 0];
// WebXR's frames have y up and z backward.
const kFlip: Pose = [1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0];

export interface HeadsetScene {
  worldFromEye(): Pose; // The eye of the page.
  prepare(): void; // Takes the newest surfaces; called once per frame, before its eyes are drawn.
  draw(eye: Eye, output: Output): void;
  ended(): void;
}

// The best kind of session that browser and device offer, or null.
export async function offeredSession(): Promise<XRSessionMode | null> {
  for (const mode of ['immersive-vr', 'immersive-ar'] as const) {
    if (await navigator.xr?.isSessionSupported(mode).catch(() => false)) return mode;
  }
  return null;
}

// Runs a session until the person ends it. Call it from a click or a key.
export async function showInHeadset(mode: XRSessionMode, gl: WebGL2RenderingContext,
                                    scene: HeadsetScene): Promise<void> {
  const session = await navigator.xr!.requestSession(mode);
  session.addEventListener('end', () => scene.ended());
  await (gl as unknown as { makeXRCompatible(): Promise<void> }).makeXRCompatible();
  const layer = new XRWebGLLayer(session, gl);
  session.updateRenderState({ baseLayer: layer, depthNear: kNearM, depthFar: kFarM });
  const space = await session.requestReferenceSpace('local');
  const worldFromStart = upright(scene.worldFromEye());
  const onFrame = (_time: number, frame: XRFrame) => {
    session.requestAnimationFrame(onFrame);
    const pose = frame.getViewerPose(space);
    if (!pose) return;
    scene.prepare();
    for (const view of pose.views) {
      const viewport = layer.getViewport(view);
      if (!viewport) continue;
      scene.draw(eyeOf(view, viewport, worldFromStart),
                 { framebuffer: layer.framebuffer, ...viewport, isTransparent: mode === 'immersive-ar' });
    }
  };
  session.requestAnimationFrame(onFrame);
}

// The pose with the same position and heading, and with its horizon level.
function upright(pose: Pose): Pose {
  const eye = column(pose, 3), forward = column(pose, 2);
  const level = subtract(forward, scaled(kUp, dot(forward, kUp)));
  const ahead = length(level) > 1e-6 ? level : cross(column(pose, 0), kUp);
  return lookAt(eye, add(eye, ahead), kUp);
}

function eyeOf(view: XRView, { width, height }: { width: number; height: number }, worldFromStart: Pose): Eye {
  const m = view.transform.matrix, p = view.projectionMatrix;
  const rows = [0, 1, 2].flatMap((i) => [m[i]!, m[4 + i]!, m[8 + i]!, m[12 + i]!]);
  const startFromEye = product(product(kFlip, rows), kFlip);
  const intrinsics = {
    width, height,
    fx: (p[0]! * width) / 2, fy: (p[5]! * height) / 2,
    cx: ((1 - p[8]!) * width) / 2 - 0.5, cy: ((1 + p[9]!) * height) / 2 - 0.5,
  };
  return { intrinsics, worldFromEye: product(worldFromStart, startFromEye) };
}
