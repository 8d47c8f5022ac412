/** The built-in scene of `ylm demo`, baked in the browser. */
import type { Bytes } from './messages';
import { Hand } from './pool';

const BANDS = 5;

/** Workers that bake: as many as there are cores, while each has memory for the scene. */
const WORKER_COUNT = Math.min(Math.max(navigator.hardwareConcurrency, 1), 8);

/** Rays a point: with fewer than 64 the ground is mottled, which takes two cores five seconds; many cores do more. */
export const DEMO_RAYS = Math.max(16 * WORKER_COUNT, 64);

/** The scene as the bytes of a baked file: each worker bakes a part of its points. */
export async function bakeDemo(rays: number): Promise<Bytes> {
  const hands = Array.from({ length: WORKER_COUNT }, () => new Hand());
  try {
    const baked = hands.map((hand, part) => hand.ask('bakeDemo', { bands: BANDS, rays, part, partCount: WORKER_COUNT }));
    const [vectors, ...others] = (await Promise.all(baked)) as [Float32Array<ArrayBuffer>, ...Float32Array[]];
    for (const other of others) other.forEach((value, i) => (vectors[i]! += value));
    const { buffer } = await hands[0]!.ask('demoFile', { bands: BANDS, rays, vectors });
    return { name: 'Built-in scene', bytes: buffer };
  } finally {
    for (const hand of hands) hand.end();
  }
}
