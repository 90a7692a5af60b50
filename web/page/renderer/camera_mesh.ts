// A camera's mesh and texture on the graphics card.

import { Mesh, Part } from '../messages';
import { Gl, makeTexture, Texture } from './gl';

export class CameraMesh {
  private readonly vertices: WebGLBuffer;
  private readonly corners: WebGLBuffer;
  private readonly array: WebGLVertexArrayObject;
  private count = 0;
  readonly texture: Texture;

  // `width` and `height` are those of the camera's picture.
  constructor(private readonly gl: Gl, width: number, height: number) {
    this.vertices = gl.createBuffer()!;
    this.corners = gl.createBuffer()!;
    this.array = gl.createVertexArray()!;
    this.texture = makeTexture(gl, gl.RGBA8, width + 1, height + 1, gl.LINEAR);
  }

  upload(mesh: Mesh, buffer: ArrayBuffer): void {
    const gl = this.gl;
    const bytes = (part: Part) => new Uint8Array(buffer, part.offset, part.bytes);
    gl.bindVertexArray(this.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.vertices);
    gl.bufferData(gl.ARRAY_BUFFER, bytes(mesh.numbers), gl.STREAM_DRAW);
    for (let i = 0; i < 5; ++i) {
      gl.enableVertexAttribArray(i);
      gl.vertexAttribPointer(i, 1, gl.FLOAT, false, 4, 4 * i * mesh.vertices);
    }
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.corners);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, bytes(mesh.triangles), gl.STREAM_DRAW);
    gl.bindVertexArray(null);
    this.count = mesh.triangles.bytes / 4;
    gl.bindTexture(gl.TEXTURE_2D, this.texture.id);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, this.texture.width, this.texture.height, gl.RGBA, gl.UNSIGNED_BYTE,
                     bytes(mesh.texture));
  }

  draw(): void {
    this.gl.bindVertexArray(this.array);
    this.gl.drawElements(this.gl.TRIANGLES, this.count, this.gl.UNSIGNED_INT, 0);
    this.gl.bindVertexArray(null);
  }

  dispose(): void {
    this.gl.deleteBuffer(this.vertices);
    this.gl.deleteBuffer(this.corners);
    this.gl.deleteVertexArray(this.array);
    this.gl.deleteTexture(this.texture.id);
  }
}
