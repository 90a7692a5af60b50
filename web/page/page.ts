// The viewer page: connects the room's worker, the cameras' workers, the renderer and the panel.

import { missingInBrowser } from './browser_check';
import { Camera } from './camera';
import { ColorMatching } from './color_matching';
import { DrawPace } from './draw_pace';
import { add, column, Eye, pinhole, scaled, Vector } from './geometry';
import { followGestures } from './gestures';
import { offeredSession, showInHeadset } from './headset';
import { FromRoom, ToRoom } from './messages';
import { Native, now } from './native';
import { kFovDegrees, OrbitView } from './orbit_view';
import { noteOf, Panel } from './panel';
import { DrawnCamera, Renderer, Rules } from './renderer/renderer';
import { ViewStatistics } from './statistics';
import { Tilt } from './tilt';

const kBackground = [0, 0, 0];
const kMostPixels = 1.5e6; // Of a view. Larger canvases are drawn with fewer pixels and enlarged.

class Page {
  readonly ready: Promise<void>;
  private resolveReady!: () => void;
  private readonly canvas = document.getElementById('view') as HTMLCanvasElement;
  private readonly view = new OrbitView();
  private readonly statistics = new ViewStatistics();
  private readonly tilt = new Tilt(() => (this.isDirty = true));
  private readonly panel: Panel;
  private headset: XRSessionMode | null = null; // What the browser offers.
  private isInHeadset = false;
  private renderer!: Renderer;
  private pace!: DrawPace;
  private module!: WebAssembly.Module;
  private rules!: Rules;
  private room!: Worker;
  private cameras: Camera[] = [];
  private colors: ColorMatching | null = null;
  private connection: { text: string; isFinal: boolean } = { text: 'Connecting to the room ...', isFinal: false };
  private gatewayClock: { offset: number; uncertainty: number } | null = null;
  private isDirty = true;
  private drawnPending: { camera: Camera; sequence: number; capturedAt: number }[] = [];
  private numbersAt = 0;
  private partialSince = 0; // When the first of several surfaces has come; 0 if none waits.
  private pictureWanted: ((url: string) => void)[] = [];

  constructor() {
    this.ready = new Promise((resolve) => (this.resolveReady = resolve));
    this.panel = new Panel({
      reset: () => {
        this.view.reset();
        this.isDirty = true;
      },
      redraw: () => (this.isDirty = true),
      setTilt: async (isOn) => {
        if (isOn) return this.tilt.start();
        this.tilt.stop();
        return false;
      },
      enterHeadset: () => void this.enterHeadset(),
    });
    if (Tilt.isOffered) this.panel.offer('tilt');
    void offeredSession().then((mode) => {
      this.headset = mode;
      if (mode) this.panel.offer('headset');
    });
  }

  async start(): Promise<void> {
    const missing = missingInBrowser();
    if (missing) return this.panel.say(missing, false);
    this.panel.say(this.connection.text, false);
    this.module = await WebAssembly.compileStreaming(fetch('native.wasm'));
    this.rules = (await Native.start(this.module)).call<Rules>('merge_rules');
    this.startGraphics();
    this.canvas.addEventListener('webglcontextlost', (event) => event.preventDefault());
    this.canvas.addEventListener('webglcontextrestored', () => {
      this.startGraphics();
      for (const camera of this.cameras) camera.graphicsLost(this.renderer);
    });
    new ResizeObserver(() => (this.isDirty = true)).observe(this.canvas);
    followGestures(this.canvas, this.view, {
      moved: () => (this.isDirty = true),
      focusAt: (x, y) => this.focusAt(x, y),
    });

    this.room = new Worker('room_worker.js', { type: 'module', name: 'room' });
    this.room.onmessage = (event: MessageEvent<FromRoom>) => this.takeFromRoom(event.data);
    const url = new URL('room', location.href);
    url.protocol = url.protocol.replace('http', 'ws');
    url.hash = '';
    const token = new URLSearchParams(location.hash.slice(1)).get('token') ?? '';
    this.tellRoom({ kind: 'open', url: url.href, token, module: this.module });
    requestAnimationFrame(() => this.onFrame());
  }

  stats(): object {
    const { width, height } = this.canvas;
    return {
      cameras: this.cameras.map((camera) => ({
        ...camera.statistics.report(camera.name),
        state: camera.state,
      })),
      view: this.statistics.report(width, height, this.renderer?.shares() ?? null),
      clock: { offset_us: this.gatewayClock?.offset ?? 0, uncertainty_us: this.gatewayClock?.uncertainty ?? 0 },
    };
  }

  setView({ eye, look, fovDegrees = kFovDegrees }: { eye: Vector; look: Vector; fovDegrees?: number }): void {
    this.view.setView(eye, look, fovDegrees);
    this.isDirty = true;
  }

  // The next view as a PNG in a data URL.
  picture(): Promise<string> {
    this.isDirty = true;
    return new Promise((resolve) => this.pictureWanted.push(resolve));
  }

  watchDepth(): void {
    for (const camera of this.cameras) camera.watchDepth();
  }
  depthChecksums(): Record<string, [number, number][]> {
    return Object.fromEntries(this.cameras.map((camera) => [camera.name, [...camera.depthChecksums]]));
  }

  private startGraphics(): void {
    this.renderer = new Renderer(this.canvas, this.rules);
    this.pace = new DrawPace(this.renderer.gl);
    this.isDirty = true;
  }

  private tellRoom(message: ToRoom, transfer: Transferable[] = []): void {
    this.room.postMessage(message, transfer);
  }

  private takeFromRoom(message: FromRoom): void {
    switch (message.kind) {
      case 'connecting':
        break;
      case 'lost':
        if (!this.connection.isFinal) this.connection.text = message.text;
        break;
      case 'refused':
        this.connection = {
          text: message.reason === 'token'
            ? 'This link does not open the room: its token is wrong or has been changed. Ask for a new link.'
            : message.text,
          isFinal: message.reason !== 'full',
        };
        break;
      case 'room':
        this.connection.text = '';
        this.enterRoom(message.cameras);
        break;
      case 'state': {
        const camera = this.cameras[message.camera];
        if (!camera) break;
        camera.state = message.state;
        camera.text = message.text;
        break;
      }
      case 'clock':
        this.gatewayClock = message;
        return;
      case 'cameraClock':
        this.cameras[message.camera]?.setClock(message.offset);
        return;
      case 'received':
        this.cameras[message.camera]?.received(message, this.gatewayClock?.offset ?? null);
        return;
    }
    this.updateWords();
  }

  // Called again after each reconnection, mostly with the same cameras.
  private enterRoom(entries: Extract<FromRoom, { kind: 'room' }>['cameras']): void {
    const isSame = entries.length === this.cameras.length &&
                   entries.every((entry, i) => entry.address === this.cameras[i]!.entry.address);
    if (isSame) return;
    for (const camera of this.cameras) camera.close();
    this.colors?.close();
    this.cameras = entries.map((entry) => {
      const { port1, port2 } = new MessageChannel();
      this.tellRoom({ kind: 'camera', index: entry.index, port: port1 }, [port1]);
      return new Camera(entry, this.module, port2, this.renderer, () => this.updateWords());
    });
    this.colors = this.cameras.length > 1 ? new ColorMatching(this.cameras, this.module) : null;
    this.isDirty = true;
  }

  private updateWords(): void {
    const notes = this.cameras.map(noteOf).filter((note) => note !== '');
    const hasView = this.cameras.some((camera) => camera.drawn);
    const text = this.connection.text || (hasView ? '' : ['Waiting for the cameras', ...notes].join('\n'));
    this.panel.say(text, hasView);
    this.panel.showNotes(hasView ? notes : []);
  }

  private onFrame(): void {
    requestAnimationFrame(() => this.onFrame());
    if (this.isInHeadset) return;
    const begin = now();
    if (begin - this.numbersAt > 5e5) {
      this.numbersAt = begin;
      this.updateWords();
      if (this.panel.showsNumbers) this.panel.showNumbers(this.numbers());
    }
    if (this.pace.isBusy()) return;
    for (const camera of this.cameras) camera.setStep(this.pictureWanted.length > 0 ? 1 : this.pace.step);
    for (const camera of this.cameras) camera.askForNext();
    if (this.waitsForOthers()) return;
    this.takeSurfaces(begin);
    if (this.isDirty || this.pictureWanted.length > 0) this.draw(begin);
  }

  // Takes the newest surfaces. Views that were drawn before are finished at `begin`.
  private takeSurfaces(begin: number): void {
    for (const { camera, sequence, capturedAt } of this.drawnPending) {
      const at = camera.toLocal(capturedAt, this.gatewayClock?.offset ?? null);
      camera.statistics.frameShown(sequence, at === null ? null : (begin - at) / 1000);
    }
    this.drawnPending = [];
    for (const camera of this.cameras) {
      if (!camera.takeNewest()) continue;
      this.isDirty = true;
      const { sequence, capturedAt } = camera.shown!;
      this.drawnPending.push({ camera, sequence, capturedAt });
    }
    for (const camera of this.cameras) {
      if (!camera.drawn) continue;
      const opacity = camera.opacity();
      if (opacity !== camera.drawn.opacity) this.isDirty = true;
      camera.drawn.opacity = opacity;
    }
    this.updateResetPose();
  }

  private async enterHeadset(): Promise<void> {
    if (!this.headset || this.isInHeadset) return;
    this.isInHeadset = true;
    let begin = now();
    const leave = () => {
      this.isInHeadset = false;
      this.isDirty = true;
    };
    await showInHeadset(this.headset, this.renderer.gl, {
      worldFromEye: () => this.view.worldFromEye,
      prepare: () => {
        begin = now();
        for (const camera of this.cameras) {
          camera.setStep(1);
          camera.askForNext();
        }
        this.takeSurfaces(begin);
      },
      draw: (eye, output) => {
        this.renderer.draw(this.drawnCameras(), eye, output.isTransparent ? 'black' : this.panel.unseen, kBackground,
                           output);
        this.statistics.drawn(begin, now(), this.isComplete(), this.skewMs());
      },
      ended: leave,
    }).catch((error: Error) => {
      leave();
      this.panel.say(`The headset does not start: ${error.message}`, true);
    });
  }

  private drawnCameras(): DrawnCamera[] {
    return this.cameras.flatMap((camera) => (camera.drawn ? [camera.drawn] : []));
  }

  // Whether the live cameras' surfaces are made of all their pixels.
  private areSurfacesWhole(): boolean {
    return this.drawnCameras().every(({ model, stream, opacity }) => opacity < 1 || model.width === stream.width);
  }

  private isComplete(): boolean {
    return this.cameras.length > 0 && this.cameras.every((camera) => camera.drawn);
  }

  private waitsForOthers(): boolean {
    const sending = this.cameras.filter((camera) => camera.drawn && camera.opacity() === 1);
    const isPartial = sending.some((camera) => camera.hasNext) && !sending.every((camera) => camera.hasNext);
    if (!isPartial) {
      this.partialSince = 0;
      return false;
    }
    this.partialSince ||= performance.now();
    if (performance.now() - this.partialSince < this.pace.patienceMs) return true;
    this.partialSince = 0;
    return false;
  }

  private draw(begin: number): void {
    this.isDirty = false;
    const begunAt = performance.now();
    const takesPicture = this.pictureWanted.length > 0 && this.areSurfacesWhole();
    this.resizeCanvas(takesPicture ? 1 : this.pace.scale);
    this.renderer.isThrifty = !takesPicture && this.pace.step > 1;
    this.renderer.draw(this.drawnCameras(), this.eye(), this.panel.unseen, kBackground);
    const isComplete = this.isComplete();
    this.pace.drawn(begunAt);
    this.statistics.drawn(begin, now(), isComplete, this.skewMs());
    if (isComplete) this.resolveReady();
    if (!takesPicture) return;
    for (const resolve of this.pictureWanted) resolve(this.canvas.toDataURL());
    this.pictureWanted = [];
  }

  private resizeCanvas(share: number): void {
    const { clientWidth, clientHeight } = this.canvas;
    const most = Math.sqrt(kMostPixels / Math.max(1, clientWidth * clientHeight));
    const scale = share * Math.min(devicePixelRatio, most);
    const width = Math.max(2, Math.round(clientWidth * scale)), height = Math.max(2, Math.round(clientHeight * scale));
    if (this.canvas.width !== width) this.canvas.width = width;
    if (this.canvas.height !== height) this.canvas.height = height;
  }

  eye(): Eye {
    const { width, height } = this.canvas;
    const worldFromEye = this.view.tilted(this.tilt.right, this.tilt.down);
    return { intrinsics: pinhole(width, height, this.view.fovDegrees), worldFromEye };
  }

  // The view begins at the first camera of the list that has a picture.
  private updateResetPose(): void {
    const first = this.cameras.find((camera) => camera.drawn);
    if (first) this.view.setResetPose(first.drawn!.worldFromCamera);
  }

  private focusAt(x: number, y: number): void {
    const { intrinsics, worldFromEye } = this.eye();
    const scale = this.canvas.width / this.canvas.clientWidth;
    const column_ = Math.round(x * scale), row_ = Math.round(y * scale);
    const z = this.renderer.depthAt(column_, row_);
    if (z <= 0) return;
    const { fx, fy, cx, cy } = intrinsics;
    const inEye: Vector = [((column_ - cx) / fx) * z, ((row_ - cy) / fy) * z, z];
    const point = [0, 1, 2].reduce<Vector>((sum, i) => add(sum, scaled(column(worldFromEye, i), inEye[i]!)),
                                           column(worldFromEye, 3));
    this.view.focus(point);
    this.isDirty = true;
  }

  // Milliseconds between the earliest and the latest frame of the view.
  private skewMs(): number | null {
    const times = this.cameras.flatMap((camera) => {
      const at = camera.shown && camera.toLocal(camera.shown.capturedAt, 0);
      return at === null || camera.opacity() < 1 ? [] : [at];
    });
    return times.length < 2 ? null : (Math.max(...times) - Math.min(...times)) / 1000;
  }

  private numbers(): [string, string][] {
    const at = now();
    const rows: [string, string][] = [
      ['View', `${this.statistics.fps(at).toFixed(1)} views/s, ${this.canvas.width} x ${this.canvas.height}`],
    ];
    for (const camera of this.cameras) {
      const { mbps, fps, latencyMs } = camera.statistics.rates(at);
      const words = `${fps.toFixed(1)} frames/s, ${mbps.toFixed(2)} Mbit/s, latency ${latencyMs.toFixed(0)} ms`;
      rows.push([camera.name, words]);
    }
    if (this.cameras.length > 1) rows.push(['Between cameras', `${this.statistics.skewMs.toFixed(0)} ms`]);
    return rows;
  }
}

const page = new Page();
// For checks from outside: docs/guide/browser.md.
Object.assign(globalThis, {
  copresence: {
    ready: page.ready,
    stats: () => page.stats(),
    eye: () => page.eye().worldFromEye,
    setView: (view: Parameters<Page['setView']>[0]) => page.setView(view),
    picture: () => page.picture(),
    watchDepth: () => page.watchDepth(),
    depthChecksums: () => page.depthChecksums(),
  },
});
page.start().catch((error: Error) => {
  console.error(error);
  document.getElementById('message')!.textContent = `The page cannot start: ${error.message}`;
});
