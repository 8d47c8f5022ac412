/** Objects that move: where they were put by hand, the time of the animation, and the controls of both. */
import type { MovingGeometry, Places } from './moving-messages';
import { placed } from './moving-pool';
import { element } from './page';
import type { State } from './state';

/** Ways to multiply what objects hide, by the names of `ylm render --shading`. */
export const SHADINGS_OF_FIELDS = ['field-exact', 'field-chain', 'shexp'];

/** What arrow keys move an object by: of the scene's radius. */
const STEP = 0.02;

type Place = [x: number, z: number];

export class Moving {
  /** Something is elsewhere: another frame is wanted. */
  onMove = () => {};
  geometry: MovingGeometry | null = null;
  private poses = new Float32Array();
  private posesMoved: number[] = [];
  private readonly moved = new Map<number, Place>();
  private chosen = -1;
  private playing = 0;

  constructor(private readonly state: State, private readonly view: { radius: number; right: Place }) {
    element('play').addEventListener('click', () => this.play(this.playing === 0));
    element('back').addEventListener('click', () => this.putBack());
    element('second').addEventListener('input', () => this.play(false));
    const list = element('objects');
    list.addEventListener('focusin', (event) => this.choose(Number((event.target as HTMLElement).dataset['object'] ?? -1)));
    list.addEventListener('keydown', (event) => this.key(event));
  }

  /** Where objects are to be now. */
  get places(): Places {
    const moved = this.moved.size === 0 ? [] : new Array<number>(3 * (this.geometry?.names.length ?? 0)).fill(0);
    for (const [object, [x, z]] of this.moved) [moved[3 * object], moved[3 * object + 2]] = [x, z];
    return { second: this.state.second, moved };
  }

  /** Takes the objects of a scene, or none; a first scene has them where the address says. */
  open(geometry: MovingGeometry | null) {
    this.play(false);
    this.moved.clear();
    this.chosen = -1;
    if (this.geometry) Object.assign(this.state, { moved: '', second: 0 });
    this.geometry = geometry;
    this.poses = new Float32Array();
    if (!geometry) return;
    this.read();
    const slider = element<HTMLInputElement>('second');
    slider.max = String(geometry.seconds || 1);
    element('motion').hidden = geometry.seconds === 0;
    const buttons = geometry.names.slice(0, this.count).map((name, object) => {
      const button = document.createElement('button');
      [button.type, button.textContent, button.dataset['object']] = ['button', name, String(object)];
      button.setAttribute('aria-describedby', 'objects-help');
      return button;
    });
    element('objects').replaceChildren(...buttons);
    this.show();
  }

  /** How many objects can be moved: the ground cannot. */
  private get count(): number {
    return this.geometry ? this.geometry.names.length - Number(this.geometry.hasGround) : 0;
  }

  /** The object that a triangle is of, if it can be moved. */
  objectOf(triangle: number): number | undefined {
    let end = 0;
    for (let object = 0; object < this.count; object++) {
      end += this.geometry!.triangleCounts[object]!;
      if (triangle < end) return object;
    }
    return undefined;
  }

  /** Moves an object on the ground. */
  by(object: number, x: number, z: number) {
    const [u, w] = this.moved.get(object) ?? [0, 0];
    const rounded = (value: number) => Number(value.toFixed(4));
    this.moved.set(object, [rounded(u + x), rounded(w + z)]);
    this.write();
    this.choose(object);
    this.onMove();
  }

  private putBack() {
    this.moved.clear();
    this.write();
    this.show();
    this.onMove();
  }

  /** Whether a frame has told where objects are. */
  get hasPoses(): boolean {
    return this.poses.length > 0;
  }

  /** World positions of a frame, with what was moved since already there. */
  positions(frame?: { poses: Float32Array<ArrayBuffer>; moved: number[] }): Float32Array<ArrayBuffer> {
    if (frame) [this.poses, this.posesMoved] = [frame.poses, frame.moved];
    const poses = this.poses.slice();
    const { moved } = this.places;
    for (let object = 0; 8 * object < poses.length; object++) {
      for (let axis = 0; axis < 3; axis++) poses[8 * object + 4 + axis]! += (moved[3 * object + axis] ?? 0) - (this.posesMoved[3 * object + axis] ?? 0);
    }
    return placed(this.geometry!, poses);
  }

  choose(object: number) {
    this.chosen = object;
    this.show();
  }

  private key(event: KeyboardEvent) {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (!step || this.chosen < 0) return;
    event.preventDefault();
    // As seen: rightwards, and towards the eye.
    const [[x, z], length] = [this.view.right, STEP * this.view.radius];
    const [across, near] = step as Place;
    this.by(this.chosen, length * (across * x - near * z), length * (across * z + near * x));
  }

  private play(isOn: boolean) {
    cancelAnimationFrame(this.playing);
    this.playing = 0;
    const button = element('play');
    button.textContent = isOn ? 'Pause' : 'Play';
    if (!isOn || !this.geometry) return;
    const { seconds } = this.geometry;
    const start = performance.now() - 1000 * this.state.second;
    const next = () => {
      this.state.second = Number((((performance.now() - start) / 1000) % seconds).toFixed(3));
      this.onMove();
      this.playing = requestAnimationFrame(next);
    };
    this.playing = requestAnimationFrame(next);
  }

  get isPlaying(): boolean {
    return this.playing !== 0;
  }

  /** Shows which object is chosen, and how far each was moved. */
  private show() {
    element('objects').querySelectorAll('button').forEach((button, object) => {
      const [x, z] = this.moved.get(object) ?? [0, 0];
      const shown = (value: number) => `${value < 0 ? '−' : '+'}${Math.abs(value).toFixed(2)}`;
      const text = x === 0 && z === 0 ? '' : `x ${shown(x)}, z ${shown(z)}`;
      button.setAttribute('aria-pressed', String(object === this.chosen));
      button.setAttribute('aria-label', `${this.geometry!.names[object]}${text ? `, moved by ${text}` : ''}`);
      button.dataset['moved'] = text;
    });
    element<HTMLButtonElement>('back').disabled = this.moved.size === 0;
  }

  /** Objects and how far they were moved, as `1:0.5,-0.2;3:1,0`. */
  private write() {
    this.state.moved = [...this.moved].map(([object, place]) => `${object}:${place.join(',')}`).join(';');
  }

  private read() {
    for (const text of this.state.moved.split(';')) {
      const [object, x, z] = text.split(/[:,]/).map(Number);
      const isPlace = [object, x, z].every((value) => Number.isFinite(value));
      if (isPlace && Number.isInteger(object) && object! >= 0 && object! < this.count) this.moved.set(object!, [x!, z!]);
    }
    this.write();
  }
}
