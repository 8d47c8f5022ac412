/** A worker's share of a scene of objects that move. */
import type { MovingCalls } from './moving-messages';
import { MovingScene, SceneFiles, scales, type Lamp } from './wasm/ylm';

type Answers = { [K in keyof MovingCalls]: (ask: MovingCalls[K]['ask']) => MovingCalls[K]['answer'] };
type Floats = Float32Array<ArrayBuffer>;
type Indices = Uint32Array<ArrayBuffer>;

/** Answers; `shine` takes the lamp of a scene that was opened. */
export function movingAnswers(shine: (lamp: Lamp) => void): Answers {
  let scene: MovingScene | null = null;
  const opened = () => {
    if (!scene) throw new Error('no scene is open');
    return scene;
  };
  return {
    openMoving({ name, bytes, files, part, partCount }) {
      const given = new SceneFiles(name, new Uint8Array(bytes));
      try {
        for (const file of files) given.add(file.name, new Uint8Array(file.bytes));
        const missing = given.missing();
        if (missing.length > 0) return missing;
        const next = new MovingScene(given, part, partCount);
        scene?.free();
        scene = next;
        shine(next.lamp());
        const [r = 0, g = 0, b = 0] = next.mean_of_lamps();
        return {
          names: next.names(), hasGround: next.has_ground(), pointCounts: next.point_counts() as Indices, triangleCounts: next.triangle_counts() as Indices,
          positions: next.positions() as Floats, triangles: next.triangles() as Indices, bands: next.bands(), seconds: next.seconds(),
          hasMaterials: next.has_materials(), meanOfLamps: [r, g, b], scales: scales() as Uint8Array<ArrayBuffer>,
        };
      } finally {
        given.free();
      }
    },
    posesMoving({ second, moved }) {
      return opened().poses(second, new Float32Array(moved)) as Floats;
    },
    fitMoving({ azimuth, elevation, aspect, moved }) {
      const [x = 0, y = 0, z = 0] = opened().fit(azimuth, elevation, aspect, new Float32Array(moved));
      return [x, y, z];
    },
    lightMoving({ coeffs, ownGain }) {
      opened().set_light(coeffs, ownGain);
      return null;
    },
    relightMoving({ shading, bands, rotation, eye, second, moved }) {
      const start = performance.now();
      const lit = opened().relight(shading, bands, new Float32Array(rotation), new Float32Array(eye), second, new Float32Array(moved));
      const answer = { radiance: lit.radiance() as Floats, poses: lit.poses() as Floats };
      lit.free();
      return { ...answer, milliseconds: performance.now() - start };
    },
  };
}
