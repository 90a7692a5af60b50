// Says what the browser lacks, as a sentence for a person, or nothing.

// A module with one SIMD instruction.
const kSimdModule = new Uint8Array([
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11,
]);
const kWorking = 'Chrome, Edge and other browsers with Chromium 110 or later show every room.';

export function missingInBrowser(): string {
  if (!window.isSecureContext)
    return 'This page needs a secure connection. Open it with https://, ' +
           'or on the machine of the gateway with http://127.0.0.1.';
  if (typeof VideoDecoder === 'undefined') return `This browser cannot decode live video (WebCodecs). ${kWorking}`;
  if (typeof WebAssembly === 'undefined' || !WebAssembly.validate(kSimdModule))
    return `This browser is too old: it lacks WebAssembly with SIMD. ${kWorking}`;
  if (!document.createElement('canvas').getContext('webgl2'))
    return 'This browser has no WebGL2, or it is switched off. ' +
           'Switch hardware acceleration on in its settings, or try another browser.';
  return '';
}
