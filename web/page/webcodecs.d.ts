// The part of WebCodecs that the page uses. TypeScript 4.8 does not declare it yet. Source: W3C
// WebCodecs, sections 4 to 9.

interface EncodedVideoChunkInit {
  type: 'key' | 'delta';
  timestamp: number; // Microseconds.
  data: BufferSource;
}
declare class EncodedVideoChunk {
  constructor(init: EncodedVideoChunkInit);
}

interface PlaneLayout {
  offset: number;
  stride: number;
}
interface VideoFrameCopyToOptions {
  format?: 'RGBA';
  colorSpace?: 'srgb';
}
declare class VideoFrame {
  readonly format: string | null;
  readonly visibleRect: DOMRectReadOnly | null;
  readonly timestamp: number;
  allocationSize(options?: VideoFrameCopyToOptions): number;
  copyTo(destination: BufferSource, options?: VideoFrameCopyToOptions): Promise<PlaneLayout[]>;
  close(): void;
}

interface VideoDecoderConfig {
  codec: string;
  optimizeForLatency?: boolean;
  hardwareAcceleration?: 'no-preference' | 'prefer-hardware' | 'prefer-software';
}
declare class VideoDecoder {
  constructor(init: { output: (frame: VideoFrame) => void; error: (error: DOMException) => void });
  readonly state: 'unconfigured' | 'configured' | 'closed';
  configure(config: VideoDecoderConfig): void;
  decode(chunk: EncodedVideoChunk): void;
  close(): void;
}
