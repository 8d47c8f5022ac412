/** Lights a share of the points, with the Rust code of the desktop. */
import { textOf, type Answer, type Calls, type Geometry, type Kind, type Lit, type Question } from './messages';
import { movingAnswers } from './moving-worker';
import init, { Lamp, Scene, bake_demo, demo_file, scales } from './wasm/ylm';

const ready = init();
let scene: Scene | null = null;
let lamp: Lamp | null = null;

function opened<T>(thing: T | null): T {
  if (!thing) throw new Error('no scene is open');
  return thing;
}

/** Arrays that wasm hands out have memory of their own, which may be given away. */
function owned(array: Float32Array): Float32Array<ArrayBuffer>;
function owned(array: Uint32Array): Uint32Array<ArrayBuffer>;
function owned(array: Uint8Array): Uint8Array<ArrayBuffer>;
function owned(array: Float32Array | Uint32Array | Uint8Array) {
  return array;
}

const answers: { [K in Kind]: (ask: Calls[K]['ask']) => Calls[K]['answer'] } = {
  bakeDemo({ bands, rays, part, partCount }) {
    return owned(bake_demo(bands, rays, part, partCount));
  },
  demoFile({ bands, rays, vectors }) {
    return owned(demo_file(bands, rays, vectors));
  },
  ...movingAnswers((next) => {
    lamp?.free();
    lamp = next;
  }),
  open({ bytes, name, part, partCount }) {
    // The scene that is shown stays until the new one is known to be good.
    const next = new Scene(new Uint8Array(bytes), name, part, partCount);
    scene?.free();
    lamp?.free();
    [scene, lamp] = [next, new Lamp(next.bands())];
    const [positions, triangles] = part === 0 ? [next.positions(), next.triangles()] as const : ([new Float32Array(), new Uint32Array()] as const);
    return { positions: owned(positions), triangles: owned(triangles), bands: next.bands(), transfer: next.kind(), scales: owned(scales()) };
  },
  fit({ azimuth, elevation, aspect }) {
    const [x = 0, y = 0, z = 0] = opened(scene).fit(azimuth, elevation, aspect);
    return [x, y, z];
  },
  probe({ bytes, name }) {
    opened(lamp).open_probe(new Uint8Array(bytes), name);
    return null;
  },
  lamp({ words, probeGain, pictureWidth, pictureBands }) {
    const lit = opened(lamp);
    lit.set(words, probeGain);
    const [r = 0, g = 0, b = 0] = lit.mean_radiance();
    return {
      coeffs: owned(lit.coeffs()),
      energies: owned(lit.band_energies()),
      meanRadiance: [r, g, b],
      picture: owned(lit.picture(pictureWidth, pictureWidth / 2, pictureBands)),
    };
  },
  light(coeffs) {
    opened(scene).set_light(coeffs);
    return null;
  },
  relight({ shading, bands, rotation, material, eye, gain }) {
    const start = performance.now();
    const lit = opened(scene).relight(shading, bands, new Float32Array(rotation), new Float32Array(material), new Float32Array(eye), gain);
    const filtered = lit.filtered();
    const answer = { radiance: owned(lit.radiance()), reach: owned(lit.reach()), filtered: filtered === undefined ? [] : [filtered], milliseconds: 0 };
    lit.free();
    return { ...answer, milliseconds: performance.now() - start };
  },
  pack() {
    const packed = opened(scene).packed();
    const answer = {
      pointCount: packed.point_count(), bands: packed.bands(), transfer: owned(packed.transfer()), bounced: owned(packed.bounced()),
      surfaces: owned(packed.surfaces()), places: owned(packed.places()), recurrence: owned(packed.recurrence()), cosine: owned(packed.cosine()),
    };
    packed.free();
    return answer;
  },
  packLight({ shading, bands, rotation, material }) {
    const packed = opened(scene).packed_light(bands, new Float32Array(rotation), new Float32Array(shading === 'glossy' ? material : []));
    const answer = { light: owned(packed.light()), matrix: owned(packed.matrix()), lobe: owned(packed.lobe()) };
    packed.free();
    return answer;
  },
};

/** Memory of an answer that goes to the page for good. */
function given(answer: Calls[Kind]['answer']): ArrayBuffer[] {
  if (!answer || Array.isArray(answer)) return [];
  if (ArrayBuffer.isView(answer)) return [answer.buffer];
  const arrays = Object.values(answer as Geometry | Lit).filter((value) => ArrayBuffer.isView(value));
  return arrays.map((array) => array.buffer as ArrayBuffer);
}

self.onmessage = async ({ data }: MessageEvent<Question>) => {
  try {
    await ready;
    const answer = (answers[data.kind] as (ask: unknown) => Calls[Kind]['answer'])(data.ask);
    self.postMessage({ answer } satisfies Answer, { transfer: given(answer) });
  } catch (fault) {
    self.postMessage({ fault: textOf(fault) } satisfies Answer);
  }
};
