/** Workers that light objects that move, each its share of the points. */
import type { Bytes, Calls, Lamp, Lit, Look } from './messages';
import type { AnyGeometry, MovingGeometry, Places } from './moving-messages';
import { Hand } from './pool';

const baseName = (path: string) => path.split('/').at(-1)!;

/** Of files that came with a scene, those that it names: by path, else by name, as what is dropped has no folder. */
function chosen(scene: string, paths: string[], offered: Bytes[]): Bytes[] {
  const absent: string[] = [];
  const found = paths.flatMap((path) => {
    const file = offered.find((file) => file.name === path) ?? offered.find((file) => file.name === baseName(path));
    if (!file) absent.push(path);
    else if (file.name !== path && paths.some((other) => other !== path && baseName(other) === file.name)) {
      throw new Error(`${scene} names two files called ${file.name}, which cannot be told apart here; open it with ylm view`);
    }
    return file ? [{ name: path, bytes: file.bytes }] : [];
  });
  if (absent.length > 0) throw new Error(`${scene} needs ${absent.join(', ')} as well: give all of its files together; ylm scene bakes them`);
  return found;
}

export class MovingPool {
  private readonly hands: Hand[];
  private geometry: MovingGeometry | null = null;
  private hasOwnLight = true;

  /** `places` tells where objects are to be in the next frame. */
  constructor(count: number, private readonly places: () => Places) {
    this.hands = Array.from({ length: count }, () => new Hand());
  }

  /** Opens a scene with the files that it names, which are among those offered; tells which those are. */
  async open(scene: Bytes, offered: Bytes[]): Promise<{ geometry: AnyGeometry; used: Bytes[] }> {
    const files: Bytes[] = [];
    const partCount = this.hands.length;
    let answer = await this.hands[0]!.ask('openMoving', { ...scene, files, part: 0, partCount });
    // A light may name files in turn.
    while (Array.isArray(answer)) {
      files.push(...chosen(scene.name, answer, offered));
      answer = await this.hands[0]!.ask('openMoving', { ...scene, files, part: 0, partCount });
    }
    await Promise.all(this.hands.slice(1).map((hand, index) => hand.ask('openMoving', { ...scene, files, part: index + 1, partCount })));
    const moving = (this.geometry = answer);
    let [point, corner, object] = [0, 0, 0];
    const triangles = moving.triangles.slice();
    for (const count of moving.triangleCounts) {
      for (const end = corner + 3 * count; corner < end; corner++) triangles[corner]! += point;
      point += moving.pointCounts[object++]!;
    }
    const positions = placed(moving, await this.hands[0]!.ask('posesMoving', { second: 0, moved: [] }));
    const used = offered.filter((file) => files.some((named) => named.bytes === file.bytes));
    return { geometry: { positions, triangles, bands: moving.bands, transfer: 'moving', scales: moving.scales, moving }, used };
  }

  /** The eye that has all in view that objects pass through, where they are moved to. */
  fit(azimuth: number, elevation: number, aspect: number) {
    return this.hands[0]!.ask('fitMoving', { azimuth, elevation, aspect, moved: this.places().moved });
  }

  /** Takes a probe in the place of the scene's own light. */
  async probe(file: Bytes) {
    await this.hands[0]!.ask('probe', file);
    this.hasOwnLight = false;
  }

  /** Lights the scene by words and so many times the probe, or the scene's own light with its lamps that stand somewhere. */
  async light(ask: Calls['lamp']['ask']): Promise<Lamp> {
    const lamp = await this.hands[0]!.ask('lamp', ask);
    const ownGain = this.hasOwnLight ? ask.probeGain : 0;
    await Promise.all(this.hands.map((hand) => hand.ask('lightMoving', { coeffs: lamp.coeffs, ownGain })));
    const mean = lamp.meanRadiance.map((radiance, c) => radiance + ownGain * this.geometry!.meanOfLamps[c]!);
    return { ...lamp, meanRadiance: mean as Lamp['meanRadiance'] };
  }

  /** Lights all points; the time is that of the slowest worker. */
  async relight(look: Look): Promise<Lit> {
    const ask = { ...look, ...this.places() };
    const [first, ...others] = await Promise.all(this.hands.map((hand) => hand.ask('relightMoving', ask)));
    const { radiance, poses } = first!;
    for (const other of others) other.radiance.forEach((value, i) => (radiance[i]! += value));
    const milliseconds = Math.max(first!.milliseconds, ...others.map((part) => part.milliseconds));
    return { radiance, reach: new Float32Array(), filtered: [], milliseconds, placed: { poses, moved: ask.moved } };
  }

  end() {
    for (const hand of this.hands) hand.end();
  }
}

/** Positions in the world, [point, 3], of objects at poses [object, 8]. */
export function placed({ pointCounts, positions }: MovingGeometry, poses: Float32Array): Float32Array<ArrayBuffer> {
  const world = new Float32Array(positions.length);
  let i = 0;
  pointCounts.forEach((count, object) => {
    const [x, y, z, w, px, py, pz, s] = poses.subarray(8 * object, 8 * object + 8) as unknown as [number, number, number, number, number, number, number, number];
    // The columns of the rotation, scaled.
    const [ax, ay, az] = [s * (1 - 2 * (y * y + z * z)), s * 2 * (x * y + w * z), s * 2 * (x * z - w * y)];
    const [bx, by, bz] = [s * 2 * (x * y - w * z), s * (1 - 2 * (x * x + z * z)), s * 2 * (y * z + w * x)];
    const [cx, cy, cz] = [s * 2 * (x * z + w * y), s * 2 * (y * z - w * x), s * (1 - 2 * (x * x + y * y))];
    for (const end = i + 3 * count; i < end; i += 3) {
      const [u, v, t] = [positions[i]!, positions[i + 1]!, positions[i + 2]!];
      world[i] = px + ax * u + bx * v + cx * t;
      world[i + 1] = py + ay * u + by * v + cy * t;
      world[i + 2] = pz + az * u + bz * v + cz * t;
    }
  });
  return world;
}
