// The part of WebXR that the page uses. TypeScript 4.8 does not declare it. Source: W3C WebXR Device
// API, sections 4 to 10.

type XRSessionMode = 'immersive-vr' | 'immersive-ar';
interface XRSystem {
  isSessionSupported(mode: XRSessionMode): Promise<boolean>;
  requestSession(mode: XRSessionMode, options?: { optionalFeatures?: string[] }): Promise<XRSession>;
}
interface XRSession extends EventTarget {
  requestReferenceSpace(type: 'local'): Promise<XRReferenceSpace>;
  updateRenderState(state: { baseLayer: XRWebGLLayer; depthNear: number; depthFar: number }): void;
  requestAnimationFrame(callback: (time: number, frame: XRFrame) => void): number;
  end(): Promise<void>;
}
type XRReferenceSpace = object;
interface XRView {
  projectionMatrix: Float32Array; // By columns.
  transform: { matrix: Float32Array };
}
interface XRFrame {
  getViewerPose(space: XRReferenceSpace): { views: XRView[] } | null;
}
declare class XRWebGLLayer {
  constructor(session: XRSession, gl: WebGL2RenderingContext);
  readonly framebuffer: WebGLFramebuffer | null;
  getViewport(view: XRView): { x: number; y: number; width: number; height: number } | null;
}
interface Navigator {
  readonly xr?: XRSystem;
}
