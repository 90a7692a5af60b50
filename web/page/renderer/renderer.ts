// Merges the newest surfaces of all cameras into a view by WebGL2, with the rules of
// render_client/renderer/merge_rules.h and extension_rules.h. Their constants come from the C++.
//
// Each mesh is drawn into a layer of its own. Then the layers are merged pixel by pixel, silhouettes
// are softened, and pixels that no camera sees are extended. All pictures have their first row at
// the bottom of the texture, where WebGL begins; the last step turns the view over.

import { clipFromEye, Eye, inverse, kFarM, kNearM, Pinhole, Pose, product, row, times } from '../geometry';
import { Stream, Surface } from '../messages';
import drawFragment from '../../shaders/draw_mesh.frag';
import drawVertex from '../../shaders/draw_mesh.vert';
import mergeText from '../../shaders/merge_layers.frag';
import presentText from '../../shaders/present.frag';
import quad from '../../shaders/quad.vert';
import softenText from '../../shaders/soften_silhouettes.frag';
import { CameraMesh } from './camera_mesh';
import { Extension } from './extension';
import { bindTarget, Gl, makeLayers, makeLayerTarget, makeTarget, makeTexture, Program, Target, Texture } from './gl';

export type Rules = Record<string, number>;
export type Unseen = 'extend' | 'dim' | 'black';

// As Origin in renderer.h.
export const kOrigins = ['seen', 'remembered', 'extended', 'empty'] as const;
export type Shares = Record<(typeof kOrigins)[number], number>;

// A camera whose surface is drawn.
export interface DrawnCamera {
  stream: Stream;
  model: Pinhole; // Of the pixels that the surface is made of; without distortion.
  mesh: CameraMesh;
  depth: Texture; // 16-bit depth of each pixel.
  remembered: CameraMesh | null;
  hasColor: boolean;
  worldFromCamera: Pose;
  opacity: number; // Below 1 for a camera that sends no frames (merge_rules.h, Stale).
}

// A layer of the merge: a camera's newest frame, or its remembered background.
export interface Layer {
  camera: DrawnCamera;
  mesh: CameraMesh;
  isRemembered: boolean;
}

// A part of a framebuffer that gets a view: an eye of a headset.
export interface Output {
  framebuffer: WebGLFramebuffer | null;
  x: number;
  y: number;
  width: number;
  height: number;
  isTransparent: boolean; // Whether the real world shows through the background.
}

const kCalibrationErrorM = 0.005; // As CameraView::calibration_error_m.
const kNotDrawn = 3;

// The textures of a view, for one size and one number of layers.
interface Pictures {
  width: number;
  height: number;
  layers: number;
  fragments: Texture;
  depths: Texture;
  byLayer: Target[];
  merged: Texture;
  scratch: Texture;
  surfaces: Texture;
  mergeTarget: Target;
  scratchTarget: Target;
  softTarget: Target;
  soft: Texture;
}

// Uniforms that depend on the view and its layers only.
export type ViewUniforms = Record<string, number[]>;

export class Renderer {
  readonly gl: Gl;
  private readonly defines: Record<string, string>;
  private readonly drawMesh: Program;
  private readonly soften: Program;
  private readonly present: Program;
  private readonly merges = new Map<number, Program>();
  private readonly extension: Extension;
  private readonly surfaceFormat: number;
  private pictures: Pictures | null = null;

  constructor(canvas: HTMLCanvasElement, private readonly rules: Rules) {
    const gl = canvas.getContext('webgl2', { alpha: false, antialias: false, depth: false,
                                             powerPreference: 'high-performance' });
    if (!gl) throw new Error('no WebGL2');
    this.gl = gl;
    const hasFloats = gl.getExtension('EXT_color_buffer_float') !== null;
    if (!hasFloats && !gl.getExtension('EXT_color_buffer_half_float')) throw new Error('no textures of floats');
    this.surfaceFormat = hasFloats ? gl.RGBA32F : gl.RGBA16F;
    this.defines = {};
    for (const [name, value] of Object.entries(rules))
      this.defines[name] = ['BLOCK', 'MIXED_COLORS'].includes(name) ? `${value}` : value.toExponential(9);
    kOrigins.forEach((name, i) => (this.defines[`ORIGIN_${name.toUpperCase()}`] = `${i}.0`));
    this.drawMesh = new Program(gl, drawVertex, drawFragment, this.defines);
    this.soften = new Program(gl, quad, softenText, this.defines);
    this.present = new Program(gl, quad, presentText, this.defines);
    this.extension = new Extension(gl, this.defines, rules, this.surfaceFormat);
    gl.frontFace(gl.CCW); // The meshes are clockwise in pictures whose first row is at the top.
    gl.cullFace(gl.BACK);
  }

  // `width` and `height` are those of the surfaces.
  makeCamera(stream: Stream, width: number, height: number): DrawnCamera {
    const share = width / stream.width;
    const model = { width, height, fx: stream.fx * share, fy: stream.fy * share, cx: stream.cx * share,
                    cy: stream.cy * share };
    const depth = makeTexture(this.gl, this.gl.R16UI, width, height);
    return { stream, model, mesh: new CameraMesh(this.gl, width, height), depth, remembered: null,
             hasColor: false, worldFromCamera: stream.worldFromCamera, opacity: 1 };
  }

  upload(camera: DrawnCamera, surface: Surface): void {
    const gl = this.gl;
    const { width, height } = camera.model;
    camera.mesh.upload(surface.seen, surface.buffer);
    camera.hasColor = surface.hasColor;
    camera.worldFromCamera = surface.worldFromCamera;
    gl.bindTexture(gl.TEXTURE_2D, camera.depth.id);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl.RED_INTEGER, gl.UNSIGNED_SHORT,
                     new Uint16Array(surface.buffer, surface.depth.offset, width * height));
    if (surface.remembered === undefined) return;
    if (surface.remembered === null) {
      camera.remembered?.dispose();
      camera.remembered = null;
    } else {
      camera.remembered ??= new CameraMesh(gl, width, height);
      camera.remembered.upload(surface.remembered, surface.buffer);
    }
  }

  dispose(camera: DrawnCamera): void {
    camera.mesh.dispose();
    camera.remembered?.dispose();
    this.gl.deleteTexture(camera.depth.id);
  }

  // Draws the view to the output, by default the canvas. Its size must be that of the eye's picture.
  draw(cameras: DrawnCamera[], eye: Eye, unseen: Unseen, background: number[], output?: Output): void {
    const gl = this.gl;
    const layers: Layer[] = cameras.map((camera) => ({ camera, mesh: camera.mesh, isRemembered: false }));
    for (const camera of cameras)
      if (camera.remembered && unseen !== 'black') layers.push({ camera, mesh: camera.remembered, isRemembered: true });
    if (layers.length === 0) {
      this.bindOutput(output);
      gl.clearColor(background[0]!, background[1]!, background[2]!, output?.isTransparent ? 0 : 1);
      gl.clear(gl.COLOR_BUFFER_BIT);
      return;
    }
    const { width, height } = eye.intrinsics;
    const pictures = this.room(width, height, layers.length);
    this.drawLayers(layers, eye, pictures);
    const uniforms = this.viewUniforms(layers, eye, unseen === 'dim' ? 0.5 : 1);
    this.merge(layers, uniforms, pictures);
    this.softenAll(layers, unseen !== 'black', pictures);
    const shown = this.extension.fill(layers, eye, uniforms, unseen, background, pictures.soft, pictures.surfaces);
    this.bindOutput(output);
    this.present.use({ view: shown },
                     { corner: [output?.x ?? 0, output?.y ?? 0], is_transparent: output?.isTransparent ?? false });
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  private bindOutput(output: Output | undefined): void {
    bindTarget(this.gl, null);
    if (!output) return;
    this.gl.bindFramebuffer(this.gl.FRAMEBUFFER, output.framebuffer);
    this.gl.viewport(output.x, output.y, output.width, output.height);
  }

  // Saves work at the cost of unseen parts that follow a moving scene a few views later.
  set isThrifty(isThrifty: boolean) {
    this.extension.mostAge = isThrifty ? 4 : 1;
  }

  // The depth of the last view at a pixel, in metres along the eye's axis; 0 where nothing is shown.
  depthAt(x: number, y: number): number {
    return this.extension.surfaceAt(x, y)[0]!;
  }

  // Fractions of the last view's pixels by origin. Waits for the graphics card.
  shares(): Shares | null {
    return this.extension.shares();
  }

  private room(width: number, height: number, layers: number): Pictures {
    const old = this.pictures;
    if (old && old.width === width && old.height === height && old.layers === layers) return old;
    const gl = this.gl;
    if (old) {
      for (const texture of [old.fragments, old.depths, old.merged, old.scratch, old.surfaces, old.soft])
        gl.deleteTexture(texture.id);
      for (const target of [...old.byLayer, old.mergeTarget, old.scratchTarget, old.softTarget])
        gl.deleteFramebuffer(target.id);
    }
    const fragments = makeLayers(gl, gl.RGBA8, width, height, layers);
    const depths = makeLayers(gl, gl.DEPTH_COMPONENT32F, width, height, layers);
    const merged = makeTexture(gl, gl.RGBA8, width, height), scratch = makeTexture(gl, gl.RGBA8, width, height);
    const soft = makeTexture(gl, gl.RGBA8, width, height);
    const surfaces = makeTexture(gl, this.surfaceFormat, width, height);
    this.pictures = {
      width, height, layers, fragments, depths, merged, scratch, soft, surfaces,
      byLayer: Array.from({ length: layers }, (_, i) => makeLayerTarget(gl, fragments, depths, i)),
      mergeTarget: makeTarget(gl, [merged, surfaces]),
      scratchTarget: makeTarget(gl, [scratch]),
      softTarget: makeTarget(gl, [soft]),
    };
    return this.pictures;
  }

  private drawLayers(layers: Layer[], eye: Eye, pictures: Pictures): void {
    const gl = this.gl;
    const clip = clipFromEye(eye.intrinsics), eyeFromWorld = inverse(eye.worldFromEye);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.CULL_FACE);
    gl.clearColor(0, 0, 0, 0);
    layers.forEach(({ camera, mesh }, i) => {
      bindTarget(gl, pictures.byLayer[i]!);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      if (camera.opacity <= 0) return;
      const matrix = times(clip, product(eyeFromWorld, camera.worldFromCamera));
      this.drawMesh.use({ camera_texture: mesh.texture }, { clip_from_camera: matrix });
      mesh.draw();
    });
    gl.disable(gl.DEPTH_TEST);
    gl.disable(gl.CULL_FACE);
  }

  private viewUniforms(layers: Layer[], eye: Eye, brightness: number): ViewUniforms {
    const { fx, fy, cx, cy } = eye.intrinsics;
    const cameraFromEye = layers.map(({ camera }) => product(inverse(camera.worldFromCamera), eye.worldFromEye));
    const noises = layers.map(({ camera }) => camera.stream.noise);
    return {
      w_near_far: [1 / kNearM, 1 / kFarM],
      ray_from_pixel: [1 / fx, 1 / fy, -cx / fx, -cy / fy],
      near_m: [kNearM],
      brightness: [brightness],
      camera_axis: cameraFromEye.flatMap((pose) => row(pose, 2)),
      camera_from_eye: cameraFromEye.flat(),
      calibration_error: layers.map(() => kCalibrationErrorM),
      noise_per_square: noises.map((noise) => noise.uncertaintyPerSquare),
      precision_factor: noises.map((noise) => noise.precision),
      opacity: layers.map(({ camera, isRemembered }) => camera.opacity * (isRemembered ? brightness : 1)),
      rank: layers.map(({ camera, isRemembered }) =>
        camera.opacity <= 0 ? kNotDrawn : isRemembered ? 2 : camera.opacity < 1 ? 1 : 0),
    };
  }

  private merge(layers: Layer[], uniforms: ViewUniforms, pictures: Pictures): void {
    let merge = this.merges.get(layers.length);
    if (!merge) {
      merge = new Program(this.gl, quad, mergeText, { ...this.defines, LAYERS: `${layers.length}` });
      this.merges.set(layers.length, merge);
    }
    bindTarget(this.gl, pictures.mergeTarget);
    merge.use({ fragments: pictures.fragments, depths: pictures.depths }, uniforms);
    this.gl.drawArrays(this.gl.TRIANGLES, 0, 3);
  }

  // Softens silhouettes along rows, and then along columns if wanted.
  private softenAll(layers: Layer[], alongColumns: boolean, pictures: Pictures): void {
    const coarsest = Math.max(...layers.map(({ camera }) => camera.stream.noise.inverseStep));
    const apart = this.rules['SILHOUETTE_STEPS']! * coarsest;
    const soften = (direction: number[], from: Texture, to: Target) => {
      bindTarget(this.gl, to);
      this.soften.use({ merged: from, surfaces: pictures.surfaces }, { direction, apart });
      this.gl.drawArrays(this.gl.TRIANGLES, 0, 3);
    };
    soften([1, 0], pictures.merged, alongColumns ? pictures.scratchTarget : pictures.softTarget);
    if (alongColumns) soften([0, 1], pictures.scratch, pictures.softTarget);
  }
}
