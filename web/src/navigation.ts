/** The hand on the scene: pointer and keys move the camera, with Shift the light, keys with Ctrl across. */
import { Vector3, type PerspectiveCamera } from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

const RADIANS = Math.PI / 180;

export class Navigation {
  onMove = () => {};
  onTurnLight: (turn: number, tilt: number) => void = () => {};
  private readonly controls: OrbitControls;
  private isQuiet = false;

  constructor(private readonly camera: PerspectiveCamera, private readonly canvas: HTMLCanvasElement) {
    // Before the camera's own listeners, which see nothing of what turns the light.
    this.turnLightByShift();
    this.controls = new OrbitControls(camera, canvas);
    this.controls.zoomToCursor = false;
    this.controls.addEventListener('change', () => {
      if (!this.isQuiet) this.onMove();
    });
    canvas.addEventListener('keydown', (event) => this.key(event));
  }

  /** Looks from an eye along azimuth and elevation in degrees; the orbit is around what is nearest to `center`. */
  look(eye: [number, number, number], azimuth: number, elevation: number, center: Vector3) {
    const [a, e] = [azimuth * RADIANS, elevation * RADIANS];
    const back = new Vector3(Math.sin(a) * Math.cos(e), Math.sin(e), Math.cos(a) * Math.cos(e));
    const from = new Vector3(...eye);
    const distance = back.dot(from.clone().sub(center));
    this.place([...eye, ...from.addScaledVector(back, -distance).toArray()]);
  }

  /** Looks from the first three numbers to the last three. */
  place([x = 0, y = 0, z = 0, u = 0, v = 0, w = 0]: number[]) {
    this.isQuiet = true;
    this.camera.position.set(x, y, z);
    this.controls.target.set(u, v, w);
    this.controls.update();
    this.isQuiet = false;
  }

  /** The camera's place and what it looks at. */
  get numbers(): number[] {
    return [...this.camera.position.toArray(), ...this.controls.target.toArray()];
  }

  private turnLightByShift() {
    let last: { x: number; y: number } | null = null;
    this.canvas.addEventListener('pointerdown', (event) => {
      if (!event.shiftKey || event.button !== 0) return;
      event.stopImmediatePropagation();
      this.canvas.focus();
      this.canvas.setPointerCapture(event.pointerId);
      last = { x: event.clientX, y: event.clientY };
    });
    this.canvas.addEventListener('pointermove', (event) => {
      if (!last) return;
      this.onTurnLight((event.clientX - last.x) * 0.5, (event.clientY - last.y) * 0.5);
      last = { x: event.clientX, y: event.clientY };
    });
    for (const end of ['pointerup', 'pointercancel'] as const) this.canvas.addEventListener(end, () => (last = null));
  }

  private key(event: KeyboardEvent) {
    if (event.metaKey || event.altKey) return;
    const steps: Record<string, [number, number]> = { ArrowLeft: [-5, 0], ArrowRight: [5, 0], ArrowUp: [0, -5], ArrowDown: [0, 5] };
    const step = steps[event.key];
    if (event.ctrlKey && !step) return;
    const dolly = { '+': 0.9, '=': 0.9, '-': 1 / 0.9 }[event.key];
    if (!step && !dolly) return;
    event.preventDefault();
    if (step && event.shiftKey) return this.onTurnLight(...step);
    if (step && event.ctrlKey) return this.pan(...step);
    const offset = this.camera.position.clone().sub(this.controls.target);
    if (dolly) offset.multiplyScalar(dolly);
    if (step) {
      const [turn, rise] = step.map((degrees) => degrees * RADIANS) as [number, number];
      offset.applyAxisAngle(new Vector3(0, 1, 0), -turn);
      const raised = offset.clone().applyAxisAngle(new Vector3(0, 1, 0).cross(offset).normalize(), rise);
      if (Math.abs(raised.clone().normalize().y) < 0.999) offset.copy(raised);
    }
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
  }
  /** Moves the eye and what it looks at across the picture, by so many hundredths of their distance. */
  private pan(right: number, down: number) {
    const { camera, controls } = this;
    const reach = camera.position.distanceTo(controls.target) / 100;
    const shift = new Vector3(right, -down, 0).multiplyScalar(reach).applyQuaternion(camera.quaternion);
    camera.position.add(shift);
    controls.target.add(shift);
    controls.update();
  }
}
