// One camera of the room as the page knows it: its worker, its state and the surface to draw.

import { CameraEntry, CameraState, ColorFrame, FromCamera, FromRoom, Stream, Surface, ToCamera } from './messages';
import { now } from './native';
import { DrawnCamera, Renderer } from './renderer/renderer';
import { CameraStatistics } from './statistics';

const kFadesAfterS = 1, kGoneAfterS = 3; // As --stale of render_client.

export class Camera {
  readonly statistics = new CameraStatistics();
  readonly depthChecksums = new Map<number, number>();
  state: CameraState = 'connecting';
  text = '';
  problem = ''; // Why this browser cannot show the stream.
  drawn: DrawnCamera | null = null;
  shown: Surface | null = null; // Its buffer may have gone back to the worker.
  onStream: (welcome: ArrayBuffer) => void = () => undefined;
  onColors: (frame: ColorFrame) => void = () => undefined;
  private pending: Surface | null = null;
  private step = 1;
  private used: ArrayBuffer | null = null; // The buffer of `shown`.
  private stream: Stream | null = null;
  private newestAt = 0; // Microseconds.
  private clockOffset: number | null = null;
  private readonly worker: Worker;

  constructor(readonly entry: CameraEntry, module: WebAssembly.Module, port: MessagePort,
              private renderer: Renderer, private readonly changed: () => void) {
    this.worker = new Worker('camera_worker.js', { type: 'module', name: entry.name });
    this.worker.onmessage = (event: MessageEvent<FromCamera>) => this.take(event.data);
    this.tell({ kind: 'open', module, port }, [port]);
  }

  get name(): string {
    return this.stream?.camera ?? this.entry.name;
  }

  setClock(offset: number): void {
    this.clockOffset = offset;
  }

  // Converts a time of the capture server to the page's clock; `gateway` is that clock minus ours.
  toLocal(serverTime: number, gateway: number | null): number | null {
    return this.clockOffset === null || gateway === null ? null : serverTime - this.clockOffset - gateway;
  }

  received({ frame, bytes, at }: Extract<FromRoom, { kind: 'received' }>, gateway: number | null): void {
    const sentAt = this.toLocal(frame.sentAt, gateway);
    this.statistics.frameReceived(frame, bytes, at, sentAt === null ? null : (at - sentAt) / 1000);
  }

  // Asks for a frame for colour matching, which onColors gets.
  sendColors(): void {
    this.tell({ kind: 'sendColors' });
  }

  // Asks for surfaces of every step-th pixel.
  setStep(step: number): void {
    if (step === this.step) return;
    this.step = step;
    this.tell({ kind: 'step', step });
  }

  correct(correction: number[]): void {
    this.tell({ kind: 'correct', correction });
  }

  watchDepth(): void {
    this.tell({ kind: 'watchDepth' });
  }

  // Whether a new surface waits for the next view.
  get hasNext(): boolean {
    return this.pending !== null;
  }

  // Puts the newest surface on the graphics card. Returns false if there is no new one.
  takeNewest(): boolean {
    const surface = this.pending;
    if (!surface || !this.stream) return false;
    this.pending = null;
    const { width, height } = surface;
    if (this.drawn && (this.drawn.model.width !== width || this.drawn.model.height !== height)) {
      this.renderer.dispose(this.drawn);
      this.drawn = null;
    }
    this.drawn ??= this.renderer.makeCamera(this.stream, width, height);
    this.renderer.upload(this.drawn, surface);
    this.shown = surface;
    this.used = surface.buffer;
    return true;
  }

  // Asks for the newest surface, once the view of the last one is finished. An earlier request would
  // only make that surface wait.
  askForNext(): void {
    if (this.used) this.tell({ kind: 'drawn', buffer: this.used }, [this.used]);
    this.used = null;
  }

  // The opacity of the camera now (merge_rules.h, Stale).
  opacity(): number {
    const period = 1 / (this.stream?.framesPerSecond ?? 30), age = (now() - this.newestAt) * 1e-6;
    const from = Math.max(kFadesAfterS, 2 * period), until = Math.max(kGoneAfterS, 3 * period);
    return Math.min(Math.max((until - age) / (until - from), 0), 1);
  }

  // The graphics card has lost everything, and this is its new renderer.
  graphicsLost(renderer: Renderer): void {
    this.renderer = renderer;
    this.drawn = null;
  }

  close(): void {
    this.worker.terminate();
    if (this.drawn) this.renderer.dispose(this.drawn);
  }

  private tell(message: ToCamera, transfer: Transferable[] = []): void {
    this.worker.postMessage(message, transfer);
  }

  private take(message: FromCamera): void {
    switch (message.kind) {
      case 'stream':
        this.statistics.connected();
        this.problem = '';
        this.stream = message.stream;
        this.onStream(message.welcome);
        if (this.pending) this.tell({ kind: 'drawn', buffer: this.pending.buffer }, [this.pending.buffer]);
        this.pending = null;
        if (this.drawn) this.renderer.dispose(this.drawn);
        this.drawn = null;
        this.shown = null;
        break;
      case 'decoded':
        this.newestAt = now();
        this.statistics.frameDecoded(message.sequence, message.videoMs, message.depthMs);
        return;
      case 'undecodable':
        console.info(`${this.name}: ${message.text}`);
        this.statistics.frameUndecodable();
        return;
      case 'unsupported':
        this.problem = message.text;
        break;
      case 'colors':
        this.onColors(message.frame);
        return;
      case 'depth':
        this.depthChecksums.set(message.sequence, message.crc);
        return;
      case 'surface':
        this.pending = message.surface;
        break;
    }
    this.changed();
  }
}
