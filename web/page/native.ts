// Calls the project's C++ in WebAssembly: web/native/exports.h. One instance belongs to one worker.

interface Exports {
  memory: WebAssembly.Memory;
  _initialize(): void;
  reserve_input(bytes: number): number;
  result_at(): number;
  result_bytes(): number;
  color_pixels(): number;
  abandon_frame(): void;
}

// Address and number of elements of an array in the instance's memory.
export type Memory = [at: number, count: number];

export class Native {
  private constructor(private readonly exports: Exports & Record<string, (...args: number[]) => number>) {}

  static async start(module: WebAssembly.Module): Promise<Native> {
    // The functions of the operating system that the C++ library refers to. Only the clock and the
    // text of a failed assertion matter.
    let memory: WebAssembly.Memory;
    const write = (_file: number, vectors: number, count: number, written: number): number => {
      const view = new DataView(memory.buffer);
      let text = '', total = 0;
      for (let i = 0; i < count; ++i) {
        const at = view.getUint32(vectors + 8 * i, true), bytes = view.getUint32(vectors + 8 * i + 4, true);
        text += new TextDecoder().decode(new Uint8Array(memory.buffer, at, bytes));
        total += bytes;
      }
      console.error(text);
      view.setUint32(written, total, true);
      return 0;
    };
    const clock = (_id: number, _precision: bigint, at: number): number => {
      new DataView(memory.buffer).setBigUint64(at, BigInt(Math.round(now() * 1000)), true);
      return 0;
    };
    const exit = (code: number): never => {
      throw new Error(`the WebAssembly module ended with ${code}`);
    };
    const known: Record<string, Record<string, unknown>> = {
      wasi_snapshot_preview1: { fd_write: write, clock_time_get: clock, proc_exit: exit },
      env: { emscripten_notify_memory_growth: () => undefined },
    };
    const imports: WebAssembly.Imports = {};
    for (const { module: from, name } of WebAssembly.Module.imports(module)) {
      const functions = (imports[from] ??= {});
      functions[name] = (known[from]?.[name] ?? (() => 52 /* ENOSYS */)) as WebAssembly.ImportValue;
    }
    const instance = await WebAssembly.instantiate(module, imports);
    const native = new Native(instance.exports as never);
    memory = native.exports.memory;
    native.exports._initialize();
    return native;
  }

  // Calls a function that returns a JSON object. Throws an Error with its sentence if it fails.
  call<T>(name: string, ...args: number[]): T {
    return JSON.parse(new TextDecoder().decode(this.bytesOf(name, args))) as T;
  }

  // The same for a function that takes the bytes of a message.
  callWith<T>(name: string, bytes: Uint8Array, ...more: number[]): T {
    const at = this.exports.reserve_input(bytes.length);
    new Uint8Array(this.exports.memory.buffer, at, bytes.length).set(bytes);
    return this.call<T>(name, bytes.length, ...more);
  }

  // Calls a function that returns a message.
  message(name: string, ...args: number[]): Uint8Array {
    return this.bytesOf(name, args).slice();
  }

  colorPixels(): number {
    return this.exports.color_pixels();
  }
  abandonFrame(): void {
    this.exports.abandon_frame();
  }

  // Views of the memory, valid until the next call.
  bytes([at, count]: Memory): Uint8Array {
    return new Uint8Array(this.exports.memory.buffer, at, count);
  }
  words([at, count]: Memory): Uint16Array {
    return new Uint16Array(this.exports.memory.buffer, at, count);
  }
  get memoryBytes(): number {
    return this.exports.memory.buffer.byteLength;
  }

  private bytesOf(name: string, args: number[]): Uint8Array {
    const succeeded = this.exports[name]!(...args);
    const result = this.bytes([this.exports.result_at(), this.exports.result_bytes()]);
    if (!succeeded) throw new Error(new TextDecoder().decode(result));
    return result;
  }
}

// The page's clock in microseconds, the same in all workers.
export function now(): number {
  return (performance.timeOrigin + performance.now()) * 1000;
}
