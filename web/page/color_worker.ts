// Matches the cameras' colours to those of the first, in a worker of its own: a comparison takes
// tens of milliseconds.

import { ColorFrame, FromColors, ToColors } from './messages';
import { Memory, Native, now } from './native';

interface FrameMemory {
  depth: Memory;
  states: Memory;
  colors: Memory;
}

class Matcher {
  private readonly memories = new Map<number, FrameMemory>();
  private comparedAt = now();

  constructor(private readonly native: Native) {}

  setStream(camera: number, welcome: ArrayBuffer): void {
    this.memories.set(camera, this.native.callWith<FrameMemory>('set_matched_stream', new Uint8Array(welcome), camera));
  }

  compare(frames: { camera: number; frame: ColorFrame }[]): Record<string, number[]> {
    for (const { camera, frame } of frames) {
      const memory = this.memories.get(camera);
      if (!memory || frame.states.byteLength !== memory.states[1]) continue;
      const copy = (at: number, from: ArrayBuffer) =>
        this.native.bytes([at, from.byteLength]).set(new Uint8Array(from));
      copy(memory.depth[0], frame.depth);
      copy(memory.states[0], frame.states);
      copy(memory.colors[0], frame.colors);
      this.native.call('add_matched_frame', camera, ...frame.worldFromCamera);
    }
    const at = now(), elapsed = at - this.comparedAt;
    this.comparedAt = at;
    return this.native.call<Record<string, number[]>>('match_colors', elapsed);
  }
}

let matcher: Promise<Matcher> | null = null;
self.onmessage = async (event: MessageEvent<ToColors>) => {
  const message = event.data;
  if (message.kind === 'open') {
    matcher = Native.start(message.module).then((native) => {
      native.call('begin_matching', message.cameras);
      return new Matcher(native);
    });
    return;
  }
  const ready = await matcher!;
  if (message.kind === 'stream') {
    ready.setStream(message.camera, message.welcome);
  } else {
    const answer: FromColors = { kind: 'corrections', corrections: ready.compare(message.frames) };
    self.postMessage(answer);
  }
};
