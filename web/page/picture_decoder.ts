// Decodes one H.264 stream by WebCodecs, one access unit at a time: one in, one out.

const kLongestWaitMs = 3000;

export class PictureDecoder {
  private decoder: VideoDecoder | null = null;
  private codec = '';
  private timestamp = 0;
  private waiting: { resolve: (frame: VideoFrame) => void; reject: (error: Error) => void } | null = null;

  // `codec` is given for keyframes only. The caller closes the frame at once.
  decode(bytes: Uint8Array, codec: string | undefined): Promise<VideoFrame> {
    if (codec && (codec !== this.codec || !this.decoder)) this.open(codec);
    const decoder = this.decoder;
    if (!decoder) return Promise.reject(new Error('the video decoder waits for a keyframe'));
    return new Promise<VideoFrame>((resolve, reject) => {
      const timer = setTimeout(() => this.fail(new Error('the video decoder gives no picture')), kLongestWaitMs);
      this.waiting = {
        resolve: (frame) => {
          clearTimeout(timer);
          resolve(frame);
        },
        reject: (error) => {
          clearTimeout(timer);
          reject(error);
        },
      };
      try {
        // Timestamps must rise. Their values do not matter, since pictures come back one by one.
        decoder.decode(
          new EncodedVideoChunk({ type: codec ? 'key' : 'delta', timestamp: (this.timestamp += 1000), data: bytes }));
      } catch (error) {
        this.fail(error as Error);
      }
    });
  }

  close(): void {
    if (this.decoder && this.decoder.state !== 'closed') this.decoder.close();
    this.decoder = null;
  }

  private open(codec: string): void {
    this.close();
    const decoder = new VideoDecoder({
      output: (frame) => {
        const waiting = this.waiting;
        this.waiting = null;
        if (waiting && decoder === this.decoder) waiting.resolve(frame);
        else frame.close();
      },
      error: (error) => {
        if (decoder === this.decoder) this.fail(error);
      },
    });
    // Software decoding takes every profile of the streams and gives exact planes. A hardware
    // decoder refuses monochrome pictures, and its frames must be read back from the graphics card.
    decoder.configure({ codec, optimizeForLatency: true, hardwareAcceleration: 'prefer-software' });
    this.decoder = decoder;
    this.codec = codec;
  }

  private fail(error: Error): void {
    this.close();
    const waiting = this.waiting;
    this.waiting = null;
    waiting?.reject(error);
  }
}
