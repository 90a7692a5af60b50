// The messages between the page, the room's worker and the cameras' workers. Times are in
// microseconds.

export interface CameraEntry {
  index: number;
  name: string;
  address: string;
}
export type CameraState = 'connecting' | 'connected' | 'waiting' | 'failed';

// To and from the room's worker, which owns the WebSocket.
export type ToRoom =
  | { kind: 'open'; url: string; token: string; module: WebAssembly.Module }
  | { kind: 'camera'; index: number; port: MessagePort };
export type FromRoom =
  | { kind: 'connecting' }
  | { kind: 'lost'; text: string }
  | { kind: 'refused'; reason: string; text: string }
  | { kind: 'room'; cameras: CameraEntry[] }
  | { kind: 'state'; camera: number; state: CameraState; text: string }
  | { kind: 'clock'; offset: number; uncertainty: number } // Gateway's clock minus the page's.
  | { kind: 'cameraClock'; camera: number; offset: number } // Capture server's minus the gateway's.
  | { kind: 'received'; camera: number; bytes: number; at: number; frame: FrameHead };

export interface FrameHead {
  type: 'frame';
  sequence: number;
  keyframe: boolean;
  sentAt: number;
  counters: { captured: number; encoder_busy: number; window_full: number };
  stages: { capture: number; fill: number; depth_encode: number; video_encode: number };
}

// Between the room's worker and a camera's worker. `bytes` is a message of the gateway: the camera's
// index and a wire message. `connection` counts the connections: a frame of an earlier one must not
// be acknowledged.
export type ToDecoder = { kind: 'welcome' | 'frame'; bytes: ArrayBuffer; sequence: number; connection: number };
export type FromDecoder = { kind: 'taken'; sequence: number; connection: number } | { kind: 'keyframe' };

// To and from a camera's worker.
export type ToCamera =
  | { kind: 'open'; module: WebAssembly.Module; port: MessagePort }
  | { kind: 'watchDepth' } // Report a checksum of each decoded depth image.
  | { kind: 'drawn'; buffer: ArrayBuffer }
  | { kind: 'step'; step: number } // Make surfaces of every step-th pixel.
  | { kind: 'sendColors' } // Send the next surface's frame for colour matching.
  | { kind: 'correct'; correction: number[] }; // Rows of the 3x4 colour correction.
export type FromCamera =
  | { kind: 'stream'; stream: Stream; welcome: ArrayBuffer }
  | { kind: 'colors'; frame: ColorFrame }
  | { kind: 'decoded'; sequence: number; videoMs: number; depthMs: number }
  | { kind: 'undecodable'; text: string }
  | { kind: 'unsupported'; text: string }
  | { kind: 'depth'; sequence: number; crc: number } // After watchDepth only.
  | { kind: 'surface'; surface: Surface };

// To and from the worker that matches the cameras' colours.
export type ToColors =
  | { kind: 'open'; module: WebAssembly.Module; cameras: number }
  | { kind: 'stream'; camera: number; welcome: ArrayBuffer }
  | { kind: 'compare'; frames: { camera: number; frame: ColorFrame }[] };
export type FromColors = { kind: 'corrections'; corrections: Record<string, number[]> };

// A conditioned frame: depth, states and colours of its pixels.
export interface ColorFrame {
  depth: ArrayBuffer;
  states: ArrayBuffer;
  colors: ArrayBuffer;
  worldFromCamera: number[];
}

export interface Stream {
  camera: string;
  width: number;
  height: number;
  fx: number;
  fy: number;
  cx: number;
  cy: number;
  distortion: number[];
  metresPerUnit: number;
  framesPerSecond: number;
  hasColor: boolean;
  hasPose: boolean;
  worldFromCamera: number[]; // Three rows of four numbers.
  codec: string;
  pictureFormat: 'gray8' | 'gray10' | 'yuv420' | 'yuv444';
  noise: { inverseStep: number; uncertaintyPerSquare: number; precision: number };
}

// The mesh and texture of a frame. All parts lie in one buffer, which goes back to the worker with
// 'drawn'.
export interface Surface {
  buffer: ArrayBuffer;
  sequence: number;
  capturedAt: number; // On the capture server's clock.
  worldFromCamera: number[];
  hasColor: boolean;
  width: number; // Of the pixels that the surface is made of: some or all of the picture's.
  height: number;
  seen: Mesh;
  depth: Part; // 16-bit depth of these pixels.
  // The remembered background: null if there is none, undefined if it is the one before.
  remembered: Mesh | null | undefined;
}
export interface Part {
  offset: number; // Bytes.
  bytes: number;
}
export interface Mesh {
  vertices: number;
  numbers: Part; // x of all vertices, then y, w, u and v, as 32-bit floats.
  triangles: Part; // 32-bit indices.
  texture: Part; // RGBA, one column and one row more than the surface.
}
