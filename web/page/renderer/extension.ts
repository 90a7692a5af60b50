// Fills the pixels of a view that no camera sees (render_client/renderer/extension_rules.h).

import { Eye, inverse, product } from '../geometry';
import blocksText from '../../shaders/extend_blocks.frag';
import colorsText from '../../shaders/extend_colors.frag';
import estimateText from '../../shaders/extend_estimate.frag';
import fadeText from '../../shaders/extend_fade.frag';
import quad from '../../shaders/quad.vert';
import smoothText from '../../shaders/extend_smooth.frag';
import viewText from '../../shaders/extend_view.frag';
import { bindTarget, Gl, makeTarget, makeTexture, Program, Target, Texture, Uniform } from './gl';
import { kOrigins, Layer, Rules, Shares, Unseen, ViewUniforms } from './renderer';

interface Pictures {
  width: number;
  height: number;
  color: Texture;
  surfaces: Texture;
  viewTarget: Target;
  colorTarget: Target;
  surfaceTarget: Target;
  blocks: Texture;
  estimates: Texture;
  gaps: Texture;
  opacities: Texture;
  opacityTarget: Target;
  summaryTarget: Target; // Blocks and gaps.
  blocksTarget: Target;
  estimatesTarget: Target;
}

export class Extension {
  private readonly summarise: Program;
  private readonly estimate: Program;
  private readonly smooth: Program;
  private readonly takeColors: Program;
  private readonly fillPixels: Program;
  private readonly fades = new Map<number, Program>(); // By number of layers.
  private pictures: Pictures | null = null;
  private estimatedFor = ''; // The eye of the last estimates.
  private estimateAge = 0; // In views.
  // While the eye rests, estimates may be used for so many views. More than one suits slow graphics.
  mostAge = 1;

  constructor(private readonly gl: Gl, private readonly defines: Record<string, string>,
              private readonly rules: Rules, private readonly surfaceFormat: number) {
    this.summarise = new Program(gl, quad, blocksText, defines);
    this.estimate = new Program(gl, quad, estimateText, defines);
    this.smooth = new Program(gl, quad, smoothText, defines);
    this.takeColors = new Program(gl, quad, colorsText, defines);
    this.fillPixels = new Program(gl, quad, viewText, defines);
  }

  // Returns the finished view. `color` and `surfaces` are the outputs of the merge.
  fill(layers: Layer[], eye: Eye, view: ViewUniforms, unseen: Unseen, background: number[], color: Texture,
       surfaces: Texture): Texture {
    const pictures = this.room(color.width, color.height);
    const extends_ = unseen !== 'black';
    const isSameEye = JSON.stringify(eye) === this.estimatedFor;
    if (extends_ && !(isSameEye && ++this.estimateAge < this.mostAge)) {
      this.estimatedFor = JSON.stringify(eye);
      this.estimateAge = 0;
      this.estimateBlocks(color, surfaces, pictures);
      this.fade(layers, view, pictures);
    }
    const { estimates, opacities } = pictures;
    this.run(this.fillPixels, pictures.viewTarget, { estimates, opacities, color, surfaces },
             { brightness: view['brightness']!, background, extends: extends_ });
    if (extends_) this.addColors(layers, eye, view, pictures);
    return pictures.color;
  }

  surfaceAt(x: number, y: number): Float32Array {
    const surface = new Float32Array(4);
    if (!this.pictures) return surface;
    bindTarget(this.gl, this.pictures.surfaceTarget);
    this.gl.readPixels(x, y, 1, 1, this.gl.RGBA, this.gl.FLOAT, surface);
    return surface;
  }

  shares(): Shares | null {
    if (!this.pictures) return null;
    const { width, height, surfaceTarget } = this.pictures;
    const surfaces = new Float32Array(4 * width * height);
    bindTarget(this.gl, surfaceTarget);
    this.gl.readPixels(0, 0, width, height, this.gl.RGBA, this.gl.FLOAT, surfaces);
    const counts = kOrigins.map(() => 0);
    for (let i = 2; i < surfaces.length; i += 4) ++counts[surfaces[i]!]!;
    return Object.fromEntries(kOrigins.map((name, i) => [name, counts[i]! / (width * height)])) as Shares;
  }

  private run(program: Program, target: Target, textures: Record<string, Texture>,
              uniforms: Record<string, Uniform>): void {
    bindTarget(this.gl, target);
    program.use(textures, uniforms);
    this.gl.drawArrays(this.gl.TRIANGLES, 0, 3);
  }

  private room(width: number, height: number): Pictures {
    const old = this.pictures;
    if (old && old.width === width && old.height === height) return old;
    const gl = this.gl;
    if (old) {
      for (const texture of [old.color, old.surfaces, old.blocks, old.estimates, old.gaps, old.opacities])
        gl.deleteTexture(texture.id);
      for (const target of [old.viewTarget, old.colorTarget, old.surfaceTarget, old.summaryTarget, old.blocksTarget,
                            old.estimatesTarget, old.opacityTarget])
        gl.deleteFramebuffer(target.id);
    }
    this.estimatedFor = '';
    const across = Math.ceil(width / this.rules['BLOCK']!), down = Math.ceil(height / this.rules['BLOCK']!);
    const color = makeTexture(gl, gl.RGBA8, width, height);
    const surfaces = makeTexture(gl, this.surfaceFormat, width, height);
    const blocks = makeTexture(gl, this.surfaceFormat, across, down);
    const estimates = makeTexture(gl, this.surfaceFormat, across, down);
    const gaps = makeTexture(gl, gl.RGBA8, across, down), opacities = makeTexture(gl, gl.RGBA8, across, down);
    this.pictures = {
      width, height, color, surfaces, blocks, estimates, gaps, opacities,
      opacityTarget: makeTarget(gl, [opacities]),
      viewTarget: makeTarget(gl, [color, surfaces]),
      colorTarget: makeTarget(gl, [color]),
      surfaceTarget: makeTarget(gl, [surfaces]),
      summaryTarget: makeTarget(gl, [blocks, gaps]),
      blocksTarget: makeTarget(gl, [blocks]),
      estimatesTarget: makeTarget(gl, [estimates]),
    };
    return this.pictures;
  }

  private estimateBlocks(color: Texture, surfaces: Texture, pictures: Pictures): void {
    const { blocks, estimates, gaps } = pictures;
    this.run(this.summarise, pictures.summaryTarget, { color, surfaces }, {});
    this.run(this.estimate, pictures.estimatesTarget, { blocks, gaps }, {});
    // The number of rounds is even, so the result is in `estimates`.
    for (let round = 0; round < this.rules['SMOOTHING_ROUNDS']!; ++round) {
      const [from, to] = round % 2 === 0 ? [estimates, pictures.blocksTarget] : [blocks, pictures.estimatesTarget];
      this.run(this.smooth, to, { estimates: from, gaps }, {});
    }
  }

  private fade(layers: Layer[], view: ViewUniforms, pictures: Pictures): void {
    let fade = this.fades.get(layers.length);
    if (!fade) {
      fade = new Program(this.gl, quad, fadeText, { ...this.defines, LAYERS: `${layers.length}` });
      this.fades.set(layers.length, fade);
    }
    this.run(fade, pictures.opacityTarget, { estimates: pictures.estimates, gaps: pictures.gaps }, {
      ...view,
      intrinsics: layers.flatMap(({ camera: { model: { fx, fy, cx, cy } } }) => [fx, fy, cx, cy]),
      picture: layers.flatMap(({ camera, isRemembered }) =>
        isRemembered || camera.opacity <= 0 ? [0, 0] : [camera.model.width, camera.model.height]),
    });
  }

  // The first camera of the list counts, so it comes last.
  private addColors(layers: Layer[], eye: Eye, view: ViewUniforms, pictures: Pictures): void {
    for (const { camera, mesh, isRemembered } of [...layers].reverse()) {
      if (isRemembered || !camera.hasColor || camera.opacity <= 0) continue;
      const { fx, fy, cx, cy } = camera.model, { distortion, metresPerUnit } = camera.stream;
      this.run(this.takeColors, pictures.colorTarget,
               { surfaces: pictures.surfaces, depth: camera.depth, camera_texture: mesh.texture }, {
        ray_from_pixel: view['ray_from_pixel']!,
        camera_from_eye: product(inverse(camera.worldFromCamera), eye.worldFromEye),
        intrinsics: [fx, fy, cx, cy],
        radial_tangential: distortion.slice(0, 4),
        rational: distortion.slice(4),
        metres_per_unit: metresPerUnit,
        brightness: view['brightness']![0]! * camera.opacity,
      });
    }
  }
}
