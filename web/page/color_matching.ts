// Matches the colours of the room's cameras now and then: collects a frame of each camera, and gives
// the corrections that the worker finds to the cameras.

import { Camera } from './camera';
import { ColorFrame, FromColors, ToColors } from './messages';

const kPeriodMs = 1000;

export class ColorMatching {
  private readonly worker = new Worker('color_worker.js', { type: 'module', name: 'colors' });
  private frames = new Map<number, ColorFrame>();
  private isComparing = false;
  private readonly timer: number;

  constructor(private readonly cameras: Camera[], module: WebAssembly.Module) {
    this.tell({ kind: 'open', module, cameras: cameras.length });
    this.worker.onmessage = (event: MessageEvent<FromColors>) => {
      this.isComparing = false;
      for (const [camera, correction] of Object.entries(event.data.corrections))
        this.cameras[Number(camera)]!.correct(correction);
    };
    cameras.forEach((camera, i) => {
      camera.onStream = (welcome) => this.tell({ kind: 'stream', camera: i, welcome }, [welcome]);
      camera.onColors = (frame) => this.frames.set(i, frame);
    });
    this.timer = window.setInterval(() => this.round(), kPeriodMs);
  }

  close(): void {
    clearInterval(this.timer);
    this.worker.terminate();
  }

  // Compares the frames that the last round asked for, and asks for the next.
  private round(): void {
    if (this.isComparing || document.hidden) return;
    const frames = [...this.frames].map(([camera, frame]) => ({ camera, frame }));
    this.frames.clear();
    if (frames.length > 1) {
      this.isComparing = true;
      this.tell({ kind: 'compare', frames },
                frames.flatMap(({ frame }) => [frame.depth, frame.states, frame.colors]));
    }
    for (const camera of this.cameras) if (camera.drawn && camera.opacity() === 1) camera.sendColors();
  }

  private tell(message: ToColors, transfer: Transferable[] = []): void {
    this.worker.postMessage(message, transfer);
  }
}
