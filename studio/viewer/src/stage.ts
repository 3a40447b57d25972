/** Camera, light and drawing: draws only when something changed. */

import {
  AmbientLight,
  Box3,
  Color,
  DirectionalLight,
  HemisphereLight,
  type Object3D,
  PerspectiveCamera,
  Scene,
  Sphere,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";

/** Directions to the eye. */
export const VIEWS: Record<string, [number, number, number]> = {
  Iso: [1, -1.7, 1.4],
  Top: [0, -1e-4, 1],
  Front: [0, -1, 0],
  Right: [1, 0, 0],
};

const FLIGHT_MS = 320;
/** Share of the view's height and width that is filled at most. */
const FILLED = 0.84;

export class Stage {
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(26, 1, 0.01, 100);
  readonly renderer: WebGLRenderer;
  readonly controls: OrbitControls;
  readonly size = new Vector2(1, 1);
  private readonly calls = { before: new Set<() => void>(), after: new Set<() => void>(), resized: new Set<() => void>() };
  private waiting = false;
  private readonly observer = new ResizeObserver(() => this.resize());

  constructor(private readonly host: HTMLElement) {
    this.renderer = new WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    host.append(this.renderer.domElement);
    this.scene.background = new Color(0xf5f6f8);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener("change", () => this.draw());
    this.light();
    this.resize();
    this.observer.observe(host);
  }

  /** Calls `act` before each frame is drawn, until the signal. */
  before(act: () => void, signal?: AbortSignal): void {
    this.call("before", act, signal);
  }

  /** Calls `act` after each frame has been drawn. */
  after(act: () => void, signal?: AbortSignal): void {
    this.call("after", act, signal);
  }

  /** Calls `act` when the view has another size. */
  resized(act: () => void, signal?: AbortSignal): void {
    this.call("resized", act, signal);
  }

  private call(when: keyof Stage["calls"], act: () => void, signal?: AbortSignal): void {
    this.calls[when].add(act);
    signal?.addEventListener("abort", () => this.calls[when].delete(act));
  }

  /** Tells fat lines how large the view is. */
  fitLines(world: Object3D): void {
    world.traverse((object) => {
      if (object instanceof LineSegments2) object.material.resolution.copy(this.size);
    });
  }

  /** Looks where another looks, whenever that one turns. */
  follow(other: Stage): void {
    other.controls.addEventListener("change", () => {
      const target = other.controls.target;
      if (this.camera.position.equals(other.camera.position) && this.controls.target.equals(target)) return;
      this.camera.position.copy(other.camera.position);
      this.controls.target.copy(target);
      this.controls.update();
    });
  }

  /** Gives back the graphics card. */
  dispose(): void {
    this.observer.disconnect();
    this.controls.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
    this.renderer.domElement.remove();
  }

  /** Draws at the next frame. */
  draw(): void {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      for (const act of this.calls.before) act();
      this.renderer.render(this.scene, this.camera);
      for (const act of this.calls.after) act();
    });
  }

  /** Fits points into the view, seen from a direction. */
  look(points: Float32Array[], direction: Vector3, animated: boolean): void {
    const back = direction.clone().normalize();
    const right = new Vector3().crossVectors(this.camera.up, back).normalize();
    const up = new Vector3().crossVectors(back, right);
    const box = new Box3();
    each(points, (p) => box.expandByPoint(p.set(p.dot(right), p.dot(up), p.dot(back))));
    const middle = box.getCenter(new Vector3());
    const tall = Math.tan((this.camera.fov * Math.PI) / 360) * FILLED;
    const wide = tall * this.camera.aspect;
    let distance = 0;
    each(points, (p) => {
      const [x, y, z] = [p.dot(right) - middle.x, p.dot(up) - middle.y, p.dot(back) - middle.z];
      distance = Math.max(distance, z + Math.abs(x) / wide, z + Math.abs(y) / tall);
    });
    const target = right.multiplyScalar(middle.x).addScaledVector(up, middle.y).addScaledVector(back, middle.z);
    this.fly(back.clone().multiplyScalar(distance).add(target), target, animated);
  }

  /** Direction from the looked-at point to the eye. */
  direction(): Vector3 {
    return this.camera.position.clone().sub(this.controls.target);
  }

  /** Pixels on the screen of a length at the looked-at point. */
  pixels(length: number): number {
    const zoom = this.size.y / Math.tan((this.camera.fov * Math.PI) / 360) / 2;
    return (length * zoom) / this.direction().length();
  }

  /** Range of depth that holds everything. */
  setExtent(box: Box3): void {
    const radius = box.getBoundingSphere(new Sphere()).radius;
    this.camera.near = radius / 200;
    this.camera.far = radius * 60;
    this.controls.minDistance = radius / 60;
    this.controls.maxDistance = radius * 20;
    this.camera.updateProjectionMatrix();
  }

  private fly(eye: Vector3, target: Vector3, animated: boolean): void {
    const from = { eye: this.camera.position.clone(), target: this.controls.target.clone() };
    const start = performance.now();
    const step = (): void => {
      const t = animated ? Math.min(1, (performance.now() - start) / FLIGHT_MS) : 1;
      const ease = t * t * (3 - 2 * t);
      this.camera.position.lerpVectors(from.eye, eye, ease);
      this.controls.target.lerpVectors(from.target, target, ease);
      this.controls.update();
      this.draw();
      if (t < 1) requestAnimationFrame(step);
    };
    step();
  }

  private light(): void {
    const sun = new DirectionalLight(0xffffff, 1.5);
    sun.position.set(-0.5, 0.9, 1);
    this.camera.add(sun);
    this.scene.add(this.camera, new HemisphereLight(0xffffff, 0xd9dbe2, 1.35), new AmbientLight(0xffffff, 0.75));
  }

  /** Takes the size that the page gives. */
  resize(): void {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (width === 0 || height === 0) return;
    this.size.set(width, height);
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    for (const act of this.calls.resized) act();
    this.draw();
  }
}

/** Calls `act` with each point in turn; the vector is the same one every time. */
function each(points: Float32Array[], act: (p: Vector3) => void): void {
  const p = new Vector3();
  for (const list of points) {
    for (let i = 0; i < list.length; i += 3) act(p.fromArray(list, i));
  }
}
