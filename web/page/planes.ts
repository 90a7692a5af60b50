// Copies the planes of decoded pictures into the memory of the WebAssembly module.
//
// Depth must come as planes: converting it to RGB would change it. Browsers may add chroma planes to
// a monochrome picture, and these are ignored.

import { Native } from './native';

export interface NativePicture {
  planes: number[]; // Addresses.
  width: number;
  height: number;
  chromaWidth: number;
  chromaHeight: number;
  bytesPerSample: number;
}

// The browser decodes the stream, but not to planes from which the depth can be read.
export class UnsupportedFormat extends Error {}

interface DecodedPlanes {
  bytes: Uint8Array;
  layout: PlaneLayout[];
}
let scratch = new Uint8Array(0);

async function planesOf(frame: VideoFrame): Promise<DecodedPlanes> {
  const size = frame.allocationSize();
  if (scratch.length < size) scratch = new Uint8Array(size);
  return { bytes: scratch, layout: await frame.copyTo(scratch) };
}

function copyPlane(from: DecodedPlanes, plane: number, to: number, rowBytes: number, rows: number,
                   native: Native): void {
  const { offset, stride } = from.layout[plane]!;
  const target = native.bytes([to, rowBytes * rows]);
  if (stride === rowBytes) {
    target.set(from.bytes.subarray(offset, offset + rowBytes * rows));
    return;
  }
  for (let y = 0; y < rows; ++y)
    target.set(from.bytes.subarray(offset + y * stride, offset + y * stride + rowBytes), y * rowBytes);
}

function checkSize(frame: VideoFrame, picture: NativePicture): void {
  const { width, height } = frame.visibleRect ?? { width: 0, height: 0 };
  if (width === picture.width && height === picture.height) return;
  throw new Error(`a picture of ${width}x${height} came where ${picture.width}x${picture.height} was announced`);
}

// Copies luma, and chroma if the codec uses it. Throws UnsupportedFormat if the browser's planes are
// not those of the stream.
export async function copyDepth(frame: VideoFrame, picture: NativePicture, native: Native): Promise<void> {
  checkSize(frame, picture);
  const { planes, width, height, chromaWidth, bytesPerSample } = picture;
  const format = frame.format ?? 'none';
  const isMonochrome = planes.length === 1;
  const known = bytesPerSample === 2 ? /^I4\d\dP10$/
    : isMonochrome ? /^(I4\d\d|NV12)$/
    : chromaWidth === width ? /^I444$/ : /^(I420|NV12)$/;
  if (!known.test(format))
    throw new UnsupportedFormat(`the browser returns depth in the format ${format}, which is not exact`);
  const decoded = await planesOf(frame);
  copyPlane(decoded, 0, planes[0]!, width * bytesPerSample, height, native);
  if (!isMonochrome) copyChroma(decoded, format, picture, native);
}

// Copies the colours. Returns false if the browser gave RGBA pixels instead of planes.
export async function copyColor(frame: VideoFrame, picture: NativePicture, native: Native): Promise<boolean> {
  checkSize(frame, picture);
  const { planes, width, height } = picture;
  const format = frame.format ?? 'none';
  if (format !== 'I420' && format !== 'NV12') {
    const size = frame.allocationSize({ format: 'RGBA' });
    if (scratch.length < size) scratch = new Uint8Array(size);
    const layout = await frame.copyTo(scratch, { format: 'RGBA', colorSpace: 'srgb' });
    copyPlane({ bytes: scratch, layout }, 0, native.colorPixels(), 4 * width, height, native);
    return false;
  }
  const decoded = await planesOf(frame);
  copyPlane(decoded, 0, planes[0]!, width, height, native);
  copyChroma(decoded, format, picture, native);
  return true;
}

function copyChroma(from: DecodedPlanes, format: string, picture: NativePicture, native: Native): void {
  const { planes, chromaWidth, chromaHeight } = picture;
  if (format !== 'NV12') {
    copyPlane(from, 1, planes[1]!, chromaWidth, chromaHeight, native);
    copyPlane(from, 2, planes[2]!, chromaWidth, chromaHeight, native);
    return;
  }
  const { offset, stride } = from.layout[1]!; // U and V alternate.
  for (const plane of [1, 2]) {
    const to = native.bytes([planes[plane]!, chromaWidth * chromaHeight]);
    for (let y = 0; y < chromaHeight; ++y)
      for (let x = 0; x < chromaWidth; ++x)
        to[y * chromaWidth + x] = from.bytes[offset + y * stride + 2 * x + plane - 1]!;
  }
}
