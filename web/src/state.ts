/** Everything that makes up a view, kept in the address so that it can be shared. */

export const DEFAULTS = {
  /** Rays a point by which the built-in scene is baked and shown, where no other is given; 0 for none. */
  demo: 0,

  /** Of the light: which parts shine, and how many stops brighter than they are. */
  probe: true,
  probeStops: 0,
  sky: 'clear',
  hour: 15.5,
  /** Whether the sun itself shines in a sky that has one. */
  sun: true,
  skyStops: 0,
  disc: false,
  angle: 12,
  height: 45,
  discStops: 3,
  words: '',
  /** Degrees that all of it is turned by: around the up axis, and towards the eye. */
  turn: 0,
  tilt: 0,
  bands: 256,

  /** Of objects that move: the second of the animation, and what was moved by hand, as `object:x,z;…`. */
  second: 0,
  moved: '',

  /** Empty: all that was baked. */
  shading: '',
  /** What the right of the picture is shaded by, if anything, and where that begins. */
  against: '',
  wipe: 0.5,
  diffuse: 0.8,
  specular: 0.2,
  shininess: 20,
  /** Of adaptive shading: how far each point was computed, in place of its radiance. */
  reach: false,
  engine: 'wasm',

  auto: true,
  exposure: 0,
  tone: 'neutral',
  background: 'studio',
  negative: false,
  /** The camera's place and what it looks at, once it was moved: six numbers. */
  eye: '',
};

export type State = typeof DEFAULTS;
export type Key = keyof State;
export const KEYS = Object.keys(DEFAULTS) as Key[];

/** The value that a text gives a key, `undefined` if it gives none. */
function valueOf(key: Key, text: string): State[Key] | undefined {
  switch (typeof DEFAULTS[key]) {
    case 'number':
      return text.trim() !== '' && Number.isFinite(Number(text)) ? Number(text) : undefined;
    case 'boolean':
      return text === '1' ? true : text === '0' ? false : undefined;
    default:
      return text;
  }
}

/** The state in the fragment of an address; what is not there or has no meaning is as by default. */
export function stateOf(fragment: string): State {
  const state = { ...DEFAULTS };
  for (const [key, text] of new URLSearchParams(fragment.replace(/^#/, ''))) {
    if (!Object.hasOwn(DEFAULTS, key)) continue;
    const value = valueOf(key as Key, text);
    if (value !== undefined) Object.assign(state, { [key]: value });
  }
  return state;
}

/** The fragment that says in what a state differs from the default, and keys that are always said. */
export function fragmentOf(state: State, always: Key[] = []): string {
  const given = new URLSearchParams();
  for (const key of KEYS) {
    const value = state[key];
    if (value !== DEFAULTS[key] || always.includes(key)) given.set(key, typeof value === 'boolean' ? (value ? '1' : '0') : String(value));
  }
  return given.toString();
}
