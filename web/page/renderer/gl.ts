// Programs, textures and framebuffers of WebGL2.

export type Gl = WebGL2RenderingContext;

export type Uniform = number | boolean | readonly number[] | Float32Array;

export class Program {
  private readonly program: WebGLProgram;
  private readonly uniforms = new Map<string, WebGLActiveInfo & { at: WebGLUniformLocation }>();
  private readonly units = new Map<string, number>();

  // `defines` become macros of both shaders.
  constructor(private readonly gl: Gl, vertex: string, fragment: string, defines: Record<string, string>) {
    const prelude =
      '#version 300 es\nprecision highp float;\nprecision highp int;\nprecision highp sampler2D;\n' +
      Object.entries(defines).map(([name, value]) => `#define ${name} ${value}\n`).join('');
    this.program = gl.createProgram()!;
    const shaders = [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]] as const;
    for (const [type, text] of shaders) {
      const shader = gl.createShader(type)!;
      gl.shaderSource(shader, prelude + text);
      gl.compileShader(shader);
      gl.attachShader(this.program, shader);
    }
    gl.linkProgram(this.program);
    if (!gl.getProgramParameter(this.program, gl.LINK_STATUS) && !gl.isContextLost()) {
      const logs = gl.getAttachedShaders(this.program)!.map((shader) => gl.getShaderInfoLog(shader));
      throw new Error(`a shader does not compile: ${gl.getProgramInfoLog(this.program)} ${logs.join(' ')}`);
    }
    const count = gl.getProgramParameter(this.program, gl.ACTIVE_UNIFORMS) as number;
    for (let i = 0; i < count; ++i) {
      const info = gl.getActiveUniform(this.program, i)!;
      const at = gl.getUniformLocation(this.program, info.name)!;
      const { name, size, type } = info;
      const plain = name.replace('[0]', '');
      this.uniforms.set(plain, { name, size, type, at });
      const isSampler = [gl.SAMPLER_2D, gl.SAMPLER_2D_ARRAY, gl.UNSIGNED_INT_SAMPLER_2D].includes(type);
      if (isSampler) this.units.set(plain, this.units.size);
    }
  }

  // Arrays have the elements of all members, one after the other. Unused uniforms are ignored.
  use(textures: Record<string, Texture>, uniforms: Record<string, Uniform>): void {
    const gl = this.gl;
    gl.useProgram(this.program);
    for (const [name, texture] of Object.entries(textures)) {
      const unit = this.units.get(name);
      if (unit === undefined) continue;
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(texture.target, texture.id);
      gl.uniform1i(this.uniforms.get(name)!.at, unit);
    }
    for (const [name, value] of Object.entries(uniforms)) {
      const uniform = this.uniforms.get(name);
      if (!uniform) continue;
      const list = typeof value === 'number' || typeof value === 'boolean' ? [Number(value)] : value;
      switch (uniform.type) {
        case gl.FLOAT: gl.uniform1fv(uniform.at, list); break;
        case gl.FLOAT_VEC2: gl.uniform2fv(uniform.at, list); break;
        case gl.FLOAT_VEC3: gl.uniform3fv(uniform.at, list); break;
        case gl.FLOAT_VEC4: gl.uniform4fv(uniform.at, list); break;
        case gl.FLOAT_MAT4: gl.uniformMatrix4fv(uniform.at, false, list); break;
        case gl.INT: case gl.BOOL: gl.uniform1iv(uniform.at, list); break;
        case gl.INT_VEC2: gl.uniform2iv(uniform.at, list); break;
        default: throw new Error(`a uniform of unknown type: ${name}`);
      }
    }
  }
}

export interface Texture {
  id: WebGLTexture;
  target: number;
  width: number;
  height: number;
}

export function makeTexture(gl: Gl, format: number, width: number, height: number,
                            filter: number = gl.NEAREST): Texture {
  const texture = { id: gl.createTexture()!, target: gl.TEXTURE_2D, width, height };
  gl.bindTexture(gl.TEXTURE_2D, texture.id);
  gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
  setFilter(gl, gl.TEXTURE_2D, filter);
  return texture;
}

export function makeLayers(gl: Gl, format: number, width: number, height: number, layers: number): Texture {
  const texture = { id: gl.createTexture()!, target: gl.TEXTURE_2D_ARRAY, width, height };
  gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture.id);
  gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, format, width, height, layers);
  setFilter(gl, gl.TEXTURE_2D_ARRAY, gl.NEAREST);
  return texture;
}

function setFilter(gl: Gl, target: number, filter: number): void {
  gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, filter);
  gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, filter);
  gl.texParameteri(target, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.texParameteri(target, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
}

export interface Target {
  id: WebGLFramebuffer;
  width: number;
  height: number;
}

export function makeTarget(gl: Gl, textures: Texture[]): Target {
  const { width, height } = textures[0]!;
  const target = { id: gl.createFramebuffer()!, width, height };
  gl.bindFramebuffer(gl.FRAMEBUFFER, target.id);
  textures.forEach((texture, i) =>
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, texture.id, 0));
  gl.drawBuffers(textures.map((_, i) => gl.COLOR_ATTACHMENT0 + i));
  return target;
}

export function makeLayerTarget(gl: Gl, color: Texture, depth: Texture, layer: number): Target {
  const target = { id: gl.createFramebuffer()!, width: color.width, height: color.height };
  gl.bindFramebuffer(gl.FRAMEBUFFER, target.id);
  gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, color.id, 0, layer);
  gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, depth.id, 0, layer);
  return target;
}

// Binds the target, or the canvas for null, and its whole area.
export function bindTarget(gl: Gl, target: Target | null): void {
  gl.bindFramebuffer(gl.FRAMEBUFFER, target?.id ?? null);
  gl.viewport(0, 0, target?.width ?? gl.drawingBufferWidth, target?.height ?? gl.drawingBufferHeight);
}
