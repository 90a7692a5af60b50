// Keeps the latency of views bounded on slow graphics. A view is begun only after the graphics card
// has finished the one before; else the browser would queue views. If views take long, they get
// fewer pixels, and the browser enlarges them. Surfaces get fewer triangles, too.

import { Gl } from './renderer/gl';

const kScales = [1, 0.71, 0.5, 0.35]; // Of the canvas's width and height.
const kSoftware = /swiftshader|llvmpipe|software/i;
const kSlowMs = 60, kFastMs = 15; // Limits for one view.
const kViewsBetweenChanges = 5; // Less if views are very slow.
const kLongestWaitMs = 300;
const kLongestMs = 5000; // A lost fence would stop the page for ever.

export class DrawPace {
  private fence: WebGLSync | null = null;
  private begunAt = 0;
  private level = 0;
  private lastMs = 0;
  private times: number[] = [];

  constructor(private readonly gl: Gl) {
    if (isSoftware(gl)) this.level = 2; // A first view in all pixels could take seconds.
  }

  // How long a view may wait for the surfaces of the other cameras, so that slow graphics show all
  // cameras at the same instant. Fast graphics do not wait.
  get patienceMs(): number {
    return this.lastMs > kSlowMs ? Math.min(this.lastMs, kLongestWaitMs) : 0;
  }

  get scale(): number {
    return kScales[this.level]!;
  }

  // Surfaces should be made of every step-th pixel of the cameras.
  get step(): number {
    return this.scale > 0.5 ? 1 : 2;
  }

  // True until the last view is finished. Call it once per animation frame.
  isBusy(): boolean {
    if (!this.fence) return false;
    const took = performance.now() - this.begunAt;
    const isDone = this.gl.getSyncParameter(this.fence, this.gl.SYNC_STATUS) === this.gl.SIGNALED;
    if (!isDone && took < kLongestMs) return true;
    this.gl.deleteSync(this.fence);
    this.fence = null;
    this.lastMs = took;
    this.times.push(took);
    this.adapt();
    return false;
  }

  // Call it after a view was drawn that was begun at this time of performance.now().
  drawn(begunAt: number): void {
    this.begunAt = begunAt;
    this.fence = this.gl.fenceSync(this.gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    this.gl.flush();
  }

  private adapt(): void {
    const isVerySlow = this.times.length > 0 && Math.min(...this.times) > 4 * kSlowMs;
    if (this.times.length < kViewsBetweenChanges && !isVerySlow) return;
    const median = [...this.times].sort((a, b) => a - b)[this.times.length >> 1]!;
    this.times = [];
    if (median > kSlowMs) this.level = Math.min(this.level + (isVerySlow ? 2 : 1), kScales.length - 1);
    else if (median < kFastMs) this.level = Math.max(this.level - 1, 0);
  }
}

// Whether the processor does the work of a graphics card.
function isSoftware(gl: Gl): boolean {
  const info = gl.getExtension('WEBGL_debug_renderer_info');
  return info !== null && kSoftware.test(String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)));
}
