// Tests the built page without a browser: node tests/web/native_test.mjs web/dist/native.wasm

import assert from 'node:assert';
import { readdirSync, readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { gzipSync } from 'node:zlib';

const module = new WebAssembly.Module(readFileSync(process.argv[2]));
const imports = {};
for (const { module: from, name } of WebAssembly.Module.imports(module))
  (imports[from] ??= {})[name] = () => 0;
const native = new WebAssembly.Instance(module, imports).exports;
native._initialize();

const result = () => Buffer.from(new Uint8Array(native.memory.buffer, native.result_at(), native.result_bytes()));
function call(name, ...args) {
  assert.equal(native[name](...args), 1, result().toString());
  return result();
}
const callForObject = (name, ...args) => JSON.parse(call(name, ...args));
function give(bytes) {
  new Uint8Array(native.memory.buffer, native.reserve_input(bytes.length), bytes.length).set(bytes);
  return bytes.length;
}
function message(type, body) {
  const header = Buffer.alloc(8);
  header.writeUInt32LE(body.length, 0);
  header.writeUInt32LE(type, 4);
  return Buffer.concat([header, body]);
}

// A frame ack, a keyframe request and a ping have the bytes of docs/internals/wire_format.md.
assert.deepEqual(call('write_frame_ack', 258), Buffer.from([8, 0, 0, 0, 3, 0, 0, 0, 2, 1, 0, 0, 0, 0, 0, 0]));
assert.deepEqual(call('write_keyframe_request'), Buffer.from([0, 0, 0, 0, 2, 0, 0, 0]));
const ping = call('write_ping', 1.5e15);
assert.equal(ping.readBigUInt64LE(8), 1500000000000000000n);

// A pong gives both times in microseconds, and the clock's offset lies in the middle of the round trip.
const pongBody = Buffer.alloc(16);
pongBody.writeBigUInt64LE(5000000n, 0);
pongBody.writeBigUInt64LE(9000000n, 8);
assert.deepEqual(callForObject('describe_message', give(message(21, pongBody))),
                 { type: 'pong', clientTime: 5000, serverTime: 9000 });
assert.deepEqual(callForObject('add_pong', 5000, 9000, 5200), { offset: 3900, uncertainty: 100 });

// A camera's sentence arrives with its quotation marks.
const sentence = Buffer.from('the "left" camera is unplugged');
const text = Buffer.concat([Buffer.from([sentence.length, 0]), sentence]);
assert.deepEqual(callForObject('describe_message', give(message(22, text))),
                 { type: 'status', text: sentence.toString() });

// Damaged messages fail with a sentence, and the module works on.
for (const bytes of [Buffer.alloc(3), message(99, Buffer.alloc(4)), message(18, Buffer.alloc(300)),
                     message(21, pongBody).subarray(0, 20)]) {
  assert.equal(native.describe_message(give(bytes)), 0);
  assert.match(result().toString(), /^an? \w+/);
}
assert.equal(native.open_stream(give(message(18, Buffer.alloc(300)))), 0);

// The shaders' constants are those of the C++ headers.
const rules = callForObject('merge_rules');
assert.equal(rules.BLOCK, 8);
assert.ok(Math.abs(rules.TIE_RATIO - 0.3) < 1e-6);
// The whole page is small enough for a slow line.
const folder = dirname(process.argv[2]);
const weight = readdirSync(folder).reduce((sum, file) => sum + gzipSync(readFileSync(join(folder, file))).length, 0);
assert.ok(weight < 600e3, `the page weighs ${weight} bytes compressed`);
console.log('the module writes and reads messages');
