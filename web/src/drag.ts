/** Objects under the pointer are dragged in the plane through where they are held, parallel to the ground. */
import { Plane, Vector3, type Ray } from 'three';

/** What is dragged. */
export interface Draggable {
  /** The ray from the eye through a pixel of the canvas. */
  ray(x: number, y: number): Ray;
  /** The object that a ray meets first, and where, if it can be moved. */
  pick(ray: Ray): { object: number; point: Vector3 } | undefined;
  move(object: number, x: number, z: number): void;
  /** How far from the middle of the scene a held point may go. */
  readonly reach: { center: Vector3; radius: number };
}

export function listenToDrags(canvas: HTMLCanvasElement, scene: Draggable) {
  let held: { object: number; at: Vector3; pointer: number } | undefined;
  let hovered: PointerEvent | undefined;

  const rayOf = ({ clientX, clientY }: PointerEvent) => {
    const { left, top } = canvas.getBoundingClientRect();
    return scene.ray(clientX - left, clientY - top);
  };
  const hover = () => {
    if (hovered) canvas.classList.toggle('movable', scene.pick(rayOf(hovered)) !== undefined);
    hovered = undefined;
  };

  // Before those of the camera, which see nothing of what is dragged.
  canvas.addEventListener('pointerdown', (event) => {
    if (event.button !== 0 || event.shiftKey || event.ctrlKey || event.metaKey || !event.isPrimary) return;
    const found = scene.pick(rayOf(event));
    if (!found) return;
    event.stopImmediatePropagation();
    canvas.focus();
    canvas.setPointerCapture(event.pointerId);
    held = { object: found.object, at: found.point, pointer: event.pointerId };
  }, { capture: true });
  canvas.addEventListener('pointermove', (event) => {
    if (held === undefined || event.pointerId !== held.pointer) {
      if (event.buttons !== 0) return;
      if (!hovered) requestAnimationFrame(hover);
      hovered = event;
      return;
    }
    event.stopImmediatePropagation();
    const at = rayOf(event).intersectPlane(new Plane(new Vector3(0, 1, 0), -held.at.y), new Vector3());
    if (!at) return;
    const { center, radius } = scene.reach;
    const middle = new Vector3(center.x, at.y, center.z);
    at.sub(middle).clampLength(0, radius).add(middle);
    scene.move(held.object, at.x - held.at.x, at.z - held.at.z);
    held.at = at;
  }, { capture: true });
  for (const end of ['pointerup', 'pointercancel', 'lostpointercapture'] as const) {
    canvas.addEventListener(end, (event) => {
      if (event.pointerId === held?.pointer) held = undefined;
    }, { capture: true });
  }
}
