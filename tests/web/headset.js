// A scripted headset for the tests of the page: a WebXR device with two eyes, which are drawn side by side on the
// canvas. It stands still where its session began. `scriptedHeadset.pixels` has the left eye's last picture.
globalThis.scriptedHeadset = { fovDegrees: 60, eyeX: 0.032, frames: 0, pixels: null, size: null };

class ScriptedSession extends EventTarget {
  updateRenderState({ baseLayer }) { this.layer = baseLayer; }
  async requestReferenceSpace() { return {}; }
  async end() { this.hasEnded = true; this.dispatchEvent(new Event('end')); }
  requestAnimationFrame(callback) {
    return requestAnimationFrame((time) => {
      if (this.hasEnded) return;
      const views = [-1, 1].map((side) => this.layer.view(side));
      callback(time, { getViewerPose: () => ({ views }) });
      this.layer.read();
    });
  }
}

globalThis.XRWebGLLayer = class {
  constructor(_session, gl) { this.gl = gl; this.framebuffer = null; }
  get size() { return [this.gl.drawingBufferWidth >> 1, this.gl.drawingBufferHeight]; }
  getViewport({ side }) {
    const [width, height] = this.size;
    return { x: side < 0 ? 0 : width, y: 0, width, height };
  }
  view(side) {
    const [width, height] = this.size;
    const focal = 1 / Math.tan((scriptedHeadset.fovDegrees * Math.PI) / 360);
    // The principal point is at (width / 2, height / 2), as in views of render_client.
    const projectionMatrix = new Float32Array(
      [(focal * height) / width, 0, 0, 0, 0, focal, 0, 0, -1 / width, 1 / height, -1, -1, 0, 0, -0.2, 0]);
    const matrix = new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, side * scriptedHeadset.eyeX, 0, 0, 1]);
    return { side, projectionMatrix, transform: { matrix } };
  }
  read() {
    const [width, height] = this.size, pixels = new Uint8Array(4 * width * height);
    this.gl.readPixels(0, 0, width, height, this.gl.RGBA, this.gl.UNSIGNED_BYTE, pixels);
    Object.assign(scriptedHeadset, { pixels: [...pixels], size: [width, height] });
    ++scriptedHeadset.frames;
  }
};
WebGL2RenderingContext.prototype.makeXRCompatible = async () => undefined;
Object.defineProperty(navigator, 'xr', { value: {
  isSessionSupported: async (mode) => mode === 'immersive-vr',
  requestSession: async () => (scriptedHeadset.session = new ScriptedSession()),
} });
