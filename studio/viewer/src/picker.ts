/** Which panel is at a point of the view: the panels are drawn with their numbers as colours. */

import {
  DoubleSide,
  Mesh,
  NearestFilter,
  NoBlending,
  Scene,
  ShaderMaterial,
  WebGLRenderTarget,
  type BufferGeometry,
  type PerspectiveCamera,
  type WebGLRenderer,
} from "three";

const VERTEX = `
attribute float face;
varying vec3 number;
#include <clipping_planes_pars_vertex>
void main() {
  float n = face + 1.0;
  number = vec3(mod(n, 256.0), mod(floor(n / 256.0), 256.0), floor(n / 65536.0)) / 255.0;
  vec4 mvPosition = modelViewMatrix * vec4(position, 1.0);
  #include <clipping_planes_vertex>
  gl_Position = projectionMatrix * mvPosition;
}`;

const FRAGMENT = `
varying vec3 number;
#include <clipping_planes_pars_fragment>
void main() {
  #include <clipping_planes_fragment>
  gl_FragColor = vec4(number, 1.0);
}`;

export class Picker {
  private readonly scene = new Scene();
  private readonly mesh: Mesh;

  constructor(
    private readonly renderer: WebGLRenderer,
    private readonly camera: PerspectiveCamera,
    geometry: BufferGeometry,
  ) {
    const material = new ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      side: DoubleSide,
      blending: NoBlending,
      // What a section has cut away can not be picked.
      clipping: true,
    });
    this.mesh = new Mesh(geometry, material);
    this.mesh.frustumCulled = false;
    this.scene.add(this.mesh);
  }

  /** Gives back what the graphics card holds; the geometry is its owner's. */
  dispose(): void {
    (this.mesh.material as ShaderMaterial).dispose();
  }

  /** The panel at a pixel of a view of the given size. */
  at(x: number, y: number, width: number, height: number): number | null {
    this.camera.setViewOffset(width, height, Math.floor(x), Math.floor(y), 1, 1);
    const pixels = this.pixels(1, 1);
    this.camera.clearViewOffset();
    return number(pixels, 0);
  }

  /** Reads the whole view at a lower resolution; the function gives the panel at a place from 0 to 1. */
  map(width: number, height: number): (u: number, v: number) => number | null {
    const [columns, rows] = [Math.max(1, width >> 1), Math.max(1, height >> 1)];
    const pixels = this.pixels(columns, rows);
    return (u, v) => {
      const [x, y] = [Math.floor(u * columns), Math.floor((1 - v) * rows)];
      const inside = x >= 0 && y >= 0 && x < columns && y < rows;
      return inside ? number(pixels, 4 * (y * columns + x)) : null;
    };
  }

  private pixels(width: number, height: number): Uint8Array {
    const target = new WebGLRenderTarget(width, height, { minFilter: NearestFilter, magFilter: NearestFilter });
    const pixels = new Uint8Array(4 * width * height);
    this.renderer.setRenderTarget(target);
    this.renderer.setClearColor(0x000000, 0);
    this.renderer.clear();
    this.renderer.render(this.scene, this.camera);
    this.renderer.readRenderTargetPixels(target, 0, 0, width, height, pixels);
    this.renderer.setRenderTarget(null);
    target.dispose();
    return pixels;
  }
}

function number(pixels: Uint8Array, at: number): number | null {
  const n = pixels[at] + 256 * pixels[at + 1] + 65536 * pixels[at + 2];
  return n > 0 ? n - 1 : null;
}
