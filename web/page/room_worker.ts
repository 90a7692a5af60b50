// Owns the connection to the gateway: one WebSocket for all cameras (docs/internals/web_protocol.md).
// It runs in a worker, so that a slow view delays no acknowledgement.

import { FromDecoder, FromRoom, FrameHead, ToDecoder, ToRoom } from './messages';
import { Native, now } from './native';

const kPingEveryMs = 1000;
const kFirstPauseMs = 250, kLongestPauseMs = 3000; // Between two attempts to connect.
const kSilenceMs = 10000; // Without any message, not even the answer to a ping.
const kLongestHead = 8192; // Bytes of a message that are enough to describe it.

type Described =
  | FrameHead
  | { type: 'welcome' }
  | { type: 'status'; text: string }
  | { type: 'end'; text: string; final: boolean }
  | { type: 'pong'; clientTime: number; serverTime: number };

const post = (message: FromRoom) => self.postMessage(message);

class Room {
  private socket: WebSocket | null = null;
  private connection = 0;
  private readonly decoders = new Map<number, MessagePort>();
  // Messages of cameras whose worker does not exist yet: the welcome and what follows.
  private readonly early = new Map<number, ToDecoder[]>();
  private pauseMs = kFirstPauseMs;
  private newestMessageAt = 0;
  private refusal: 'none' | 'for now' | 'for good' = 'none';

  constructor(private readonly native: Native, private readonly url: string, private readonly token: string) {
    setInterval(() => this.watch(), kPingEveryMs);
    this.connect();
  }

  addCamera(index: number, port: MessagePort): void {
    this.decoders.set(index, port);
    port.onmessage = (event: MessageEvent<FromDecoder>) => {
      if (event.data.kind === 'taken') {
        if (event.data.connection !== this.connection) return;
        this.send(index, this.native.message('write_frame_ack', event.data.sequence));
      } else {
        this.send(index, this.native.message('write_keyframe_request'));
      }
    };
    for (const message of this.early.get(index) ?? []) port.postMessage(message, [message.bytes]);
    this.early.delete(index);
  }

  private connect(): void {
    post({ kind: 'connecting' });
    this.early.clear();
    ++this.connection;
    const socket = new WebSocket(this.url);
    this.socket = socket;
    this.newestMessageAt = performance.now();
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => socket.send(JSON.stringify({ type: 'join', token: this.token }));
    socket.onmessage = (event: MessageEvent<string | ArrayBuffer>) => {
      this.newestMessageAt = performance.now();
      if (typeof event.data === 'string') {
        this.takeText(event.data);
      } else {
        this.takeBytes(event.data);
      }
    };
    socket.onclose = () => {
      if (this.socket !== socket) return;
      this.socket = null;
      if (this.refusal === 'for good') return;
      if (this.refusal === 'none') post({ kind: 'lost', text: 'The connection to the room is lost. Trying again ...' });
      setTimeout(() => this.connect(), this.pauseMs);
      this.pauseMs = Math.min(2 * this.pauseMs, kLongestPauseMs);
    };
  }

  private watch(): void {
    if (this.socket?.readyState !== WebSocket.OPEN) return;
    if (performance.now() - this.newestMessageAt > kSilenceMs) {
      this.socket.close();
      return;
    }
    this.send(0, this.native.message('write_ping', now()));
  }

  private send(camera: number, message: Uint8Array): void {
    if (this.socket?.readyState !== WebSocket.OPEN) return;
    const bytes = new Uint8Array(1 + message.length);
    bytes[0] = camera;
    bytes.set(message, 1);
    this.socket.send(bytes);
  }

  private takeText(text: string): void {
    const message = JSON.parse(text);
    switch (message.type) {
      case 'room':
        this.pauseMs = kFirstPauseMs;
        this.refusal = 'none';
        post({ kind: 'room', cameras: message.cameras });
        break;
      case 'state':
        post({ kind: 'state', camera: message.camera, state: message.state, text: message.text });
        break;
      case 'clock':
        post({ kind: 'cameraClock', camera: message.camera, offset: message.offset_us });
        break;
      case 'refused':
        // A full room may have a place later. A wrong token stays wrong.
        this.refusal = message.reason === 'full' ? 'for now' : 'for good';
        this.pauseMs = kLongestPauseMs;
        post({ kind: 'refused', reason: message.reason, text: message.text });
        break;
    }
  }

  private takeBytes(buffer: ArrayBuffer): void {
    const at = now();
    const camera = new Uint8Array(buffer)[0]!;
    const head = new Uint8Array(buffer, 1, Math.min(buffer.byteLength - 1, kLongestHead));
    let message: Described;
    try {
      message = this.native.callWith<Described>('describe_message', head);
    } catch (error) {
      console.warn('the gateway sent', (error as Error).message);
      this.socket?.close();
      return;
    }
    switch (message.type) {
      case 'welcome':
        this.pass(camera, { kind: 'welcome', bytes: buffer, sequence: 0, connection: this.connection });
        break;
      case 'frame':
        post({ kind: 'received', camera, bytes: buffer.byteLength, at, frame: message });
        this.pass(camera, { kind: 'frame', bytes: buffer, sequence: message.sequence, connection: this.connection });
        break;
      case 'status':
        post({ kind: 'state', camera, state: message.text ? 'waiting' : 'connected', text: message.text });
        break;
      case 'end':
        post({ kind: 'state', camera, state: message.final ? 'failed' : 'waiting', text: message.text });
        break;
      case 'pong': {
        const clock = this.native.call<{ offset: number; uncertainty: number }>(
          'add_pong', message.clientTime, message.serverTime, at);
        post({ kind: 'clock', ...clock });
        break;
      }
    }
  }

  private pass(camera: number, message: ToDecoder): void {
    const decoder = this.decoders.get(camera);
    if (decoder) {
      decoder.postMessage(message, [message.bytes]);
    } else {
      this.early.set(camera, [...(this.early.get(camera) ?? []), message]);
    }
  }
}

let room: Room | null = null;
const waiting: { index: number; port: MessagePort }[] = [];
self.onmessage = async (event: MessageEvent<ToRoom>) => {
  const message = event.data;
  if (message.kind === 'camera') {
    if (room) room.addCamera(message.index, message.port);
    else waiting.push(message);
    return;
  }
  room = new Room(await Native.start(message.module), message.url, message.token);
  for (const camera of waiting) room.addCamera(camera.index, camera.port);
};
