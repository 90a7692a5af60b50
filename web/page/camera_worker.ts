// Decodes one camera's frames and makes their surfaces.
//
// Every frame is decoded, since later frames depend on it. A surface is made of the newest frame
// only, once the page has drawn the surface before. So a slow page skips surfaces, and nothing waits
// in a queue. While the decoder is behind, acknowledgements are late, and the gateway sends less.

import { FromCamera, FromDecoder, Mesh, Part, Stream, ToCamera, ToDecoder } from './messages';
import { Memory, Native } from './native';
import { copyColor, copyDepth, NativePicture, UnsupportedFormat } from './planes';
import { PictureDecoder } from './picture_decoder';

interface CodedPicture {
  bytes: Memory;
  picture: NativePicture;
  codec?: string; // Of a keyframe.
}
interface BegunFrame {
  sequence: number;
  capturedAt: number;
  keyframe: boolean;
  depth?: CodedPicture;
  color?: CodedPicture;
}
interface NativeMesh {
  x: Memory;
  y: Memory;
  w: Memory;
  u: Memory;
  v: Memory;
  triangles: Memory;
  texture: Memory;
}
interface NativeSurface {
  surface: NativeMesh;
  remembered?: NativeMesh;
  rememberedVersion: number;
  width: number;
  height: number;
  surfaceDepth: Memory;
  depth: Memory;
  states: Memory;
  colors?: Memory;
  hasColor: boolean;
  worldFromCamera: number[];
}

const kNoColor = 0, kPlanes = 1, kPixels = 2; // As CameraStream::Color.

const post = (message: FromCamera, transfer: Transferable[] = []) => self.postMessage(message, { transfer });

class CameraDecoder {
  private readonly queue: ToDecoder[] = [];
  private readonly depthDecoder = new PictureDecoder();
  private readonly colorDecoder = new PictureDecoder();
  private isBusy = false;
  private isOpen = false;
  private needsKeyframe = true;
  private newest: BegunFrame | null = null; // Decoded, and without a surface.
  private pageIsReady = true; // Whether the page has drawn the last surface.
  private spare: ArrayBuffer | null = null;
  private rememberedVersion = 0;

  private step = 1;
  private watchesDepth = false;
  private sendsColors = false; // Whether colour matching waits for the next frame.

  constructor(private readonly native: Native, private readonly port: MessagePort) {
    port.onmessage = (event: MessageEvent<ToDecoder>) => {
      this.queue.push(event.data);
      void this.work();
    };
  }

  sendColors(): void {
    this.sendsColors = true;
  }

  setStep(step: number): void {
    if (this.isOpen) this.native.call('set_step', step);
    this.step = step;
  }

  correct(correction: number[]): void {
    if (this.isOpen) this.native.call('set_color_correction', ...correction);
  }

  watchDepth(): void {
    this.watchesDepth = true;
  }

  drawn(buffer: ArrayBuffer): void {
    this.spare = buffer;
    this.pageIsReady = true;
    if (!this.isBusy) this.showNewest();
  }

  private async work(): Promise<void> {
    if (this.isBusy) return;
    this.isBusy = true;
    for (let message = this.queue.shift(); message; message = this.queue.shift()) {
      const bytes = new Uint8Array(message.bytes, 1);
      if (message.kind === 'welcome') {
        this.open(bytes);
      } else {
        const { sequence, connection } = message;
        this.tellRoom({ kind: 'taken', sequence, connection });
        await this.decode(bytes);
      }
      if (this.queue.length === 0) this.showNewest();
    }
    this.isBusy = false;
  }

  private tellRoom(message: FromDecoder): void {
    this.port.postMessage(message);
  }

  private open(welcome: Uint8Array): void {
    this.newest = null;
    this.rememberedVersion = 0;
    this.needsKeyframe = true;
    this.depthDecoder.close();
    this.colorDecoder.close();
    this.isOpen = false;
    try {
      const stream = this.native.callWith<Stream>('open_stream', welcome);
      post({ kind: 'stream', stream, welcome: welcome.slice().buffer });
      this.isOpen = true;
      this.native.call('set_step', this.step);
    } catch (error) {
      post({ kind: 'unsupported', text: (error as Error).message });
    }
  }

  private async decode(message: Uint8Array): Promise<void> {
    if (!this.isOpen) return;
    try {
      const begin = performance.now();
      const frame = this.native.callWith<BegunFrame>('begin_frame', message);
      const color = await this.decodePictures(frame);
      const decoded = performance.now();
      const pixels = this.native.call<{ depth: Memory; states: Memory }>('finish_frame', color);
      this.needsKeyframe = false;
      this.newest = frame;
      const videoMs = decoded - begin, depthMs = performance.now() - decoded;
      post({ kind: 'decoded', sequence: frame.sequence, videoMs, depthMs });
      if (this.watchesDepth) {
        const [at, count] = pixels.depth;
        post({ kind: 'depth', sequence: frame.sequence, crc: crc32(this.native.bytes([at, 2 * count])) });
      }
    } catch (error) {
      this.native.abandonFrame();
      if (error instanceof UnsupportedFormat) post({ kind: 'unsupported', text: error.message });
      else post({ kind: 'undecodable', text: (error as Error).message });
      // One request is enough until a keyframe has come.
      if (!this.needsKeyframe) this.tellRoom({ kind: 'keyframe' });
      this.needsKeyframe = true;
    }
  }

  // Returns in which form the colours are there.
  private async decodePictures(frame: BegunFrame): Promise<number> {
    const decode = (picture: CodedPicture | undefined, decoder: PictureDecoder) =>
      picture ? decoder.decode(this.native.bytes(picture.bytes), picture.codec) : Promise.resolve(null);
    // Both are awaited even if one fails, so that every picture is closed.
    const results = await Promise.allSettled([
      decode(frame.depth, this.depthDecoder),
      decode(frame.color, this.colorDecoder),
    ]);
    const [depth, color] = results.map((result) => (result.status === 'fulfilled' ? result.value : null));
    try {
      for (const result of results) if (result.status === 'rejected') throw result.reason;
      if (depth) await copyDepth(depth, frame.depth!.picture, this.native);
      if (!color) return kNoColor;
      return (await copyColor(color, frame.color!.picture, this.native)) ? kPlanes : kPixels;
    } finally {
      depth?.close();
      color?.close();
    }
  }

  private postColors(made: NativeSurface, [at, count]: Memory): void {
    this.sendsColors = false;
    const copy = (memory: Memory) => this.native.bytes(memory).slice().buffer;
    const frame = {
      depth: copy([made.depth[0], 2 * made.depth[1]]),
      states: copy(made.states),
      colors: copy([at, 3 * count]),
      worldFromCamera: made.worldFromCamera,
    };
    post({ kind: 'colors', frame }, [frame.depth, frame.states, frame.colors]);
  }

  private showNewest(): void {
    const frame = this.newest;
    if (!frame || !this.pageIsReady) return;
    this.newest = null;
    const made = this.native.call<NativeSurface>('make_surface');
    if (this.sendsColors && made.colors) this.postColors(made, made.colors);
    const packer = new Packer(this.native);
    const seen = packer.addMesh(made.surface);
    const depth = packer.add([made.surfaceDepth[0], 2 * made.surfaceDepth[1]]);
    let remembered: Mesh | null | undefined = undefined;
    if (made.rememberedVersion !== this.rememberedVersion) {
      this.rememberedVersion = made.rememberedVersion;
      remembered = made.remembered ? packer.addMesh(made.remembered) : null;
    }
    const buffer = packer.pack(this.spare);
    this.spare = null;
    this.pageIsReady = false;
    const { sequence, capturedAt } = frame;
    const { worldFromCamera, hasColor, width, height } = made;
    const surface = {
      buffer, sequence, capturedAt, worldFromCamera, hasColor, width, height, seen, depth, remembered,
    };
    post({ kind: 'surface', surface }, [buffer]);
  }
}

// Collects parts of the native memory, and copies them into one buffer.
class Packer {
  private readonly parts: Memory[] = [];
  private bytes = 0;

  constructor(private readonly native: Native) {}

  add(...memories: Memory[]): Part {
    const offset = this.bytes;
    for (const memory of memories) {
      this.parts.push(memory);
      this.bytes += memory[1];
    }
    const part = { offset, bytes: this.bytes - offset };
    this.bytes = (this.bytes + 3) & ~3;
    if (this.bytes > part.offset + part.bytes) this.parts.push([0, this.bytes - part.offset - part.bytes]);
    return part;
  }

  addMesh(mesh: NativeMesh): Mesh {
    const inBytes = ([at, count]: Memory): Memory => [at, 4 * count];
    return {
      vertices: mesh.x[1],
      numbers: this.add(...[mesh.x, mesh.y, mesh.w, mesh.u, mesh.v].map(inBytes)),
      triangles: this.add(inBytes(mesh.triangles)),
      texture: this.add(inBytes(mesh.texture)),
    };
  }

  // Reuses `spare` if it is large enough and not far too large.
  pack(spare: ArrayBuffer | null): ArrayBuffer {
    const fits = spare !== null && spare.byteLength >= this.bytes && spare.byteLength < 4 * this.bytes;
    const buffer = fits ? spare : new ArrayBuffer(Math.ceil(1.25 * this.bytes / 4) * 4);
    const to = new Uint8Array(buffer);
    let at = 0;
    for (const part of this.parts) {
      to.set(this.native.bytes(part), at);
      at += part[1];
    }
    return buffer;
  }
}

// As zlib.crc32() of the little-endian image.
const kCrcTable = Uint32Array.from({ length: 256 }, (_, byte) => {
  let crc = byte;
  for (let bit = 0; bit < 8; ++bit) crc = (crc >>> 1) ^ (crc & 1 ? 0xedb88320 : 0);
  return crc >>> 0;
});
function crc32(bytes: Uint8Array): number {
  let crc = 0xffffffff;
  for (const byte of bytes) crc = (crc >>> 8) ^ kCrcTable[(crc ^ byte) & 255]!;
  return ~crc >>> 0;
}

let camera: CameraDecoder | null = null;
self.onmessage = async (event: MessageEvent<ToCamera>) => {
  const message = event.data;
  if (message.kind === 'open') {
    camera = new CameraDecoder(await Native.start(message.module), message.port);
    return;
  }
  switch (message.kind) {
    case 'drawn': camera?.drawn(message.buffer); break;
    case 'step': camera?.setStep(message.step); break;
    case 'sendColors': camera?.sendColors(); break;
    case 'correct': camera?.correct(message.correction); break;
    case 'watchDepth': camera?.watchDepth(); break;
  }
};
