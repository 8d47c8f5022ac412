/** Workers that light a scene together, each its share of the points. */
import type { Answer, Bytes, Calls, Geometry, Kind, Lamp, Lit, Look, PackedLight, PackedScene, Question } from './messages';

/** A worker whose questions are answered in order. */
export class Hand {
  private readonly worker = new Worker(new URL('./worker.ts', import.meta.url), { type: 'module' });
  private readonly waiting: ((answer: Answer) => void)[] = [];

  constructor() {
    this.worker.onmessage = (event: MessageEvent<Answer>) => this.waiting.shift()?.(event.data);
    // A worker that cannot go on answers nothing more.
    this.worker.onerror = (event) => {
      for (const answer of this.waiting.splice(0)) answer({ fault: event.message || 'the worker stopped' });
    };
  }

  async ask<K extends Kind>(kind: K, ask: Calls[K]['ask']): Promise<Calls[K]['answer']> {
    const answer = await new Promise<Answer>((resolve) => {
      this.waiting.push(resolve);
      this.worker.postMessage({ kind, ask } as Question);
    });
    if ('fault' in answer) throw new Error(answer.fault);
    return answer.answer as Calls[K]['answer'];
  }

  end() {
    this.worker.terminate();
  }
}

/** What adaptive shading computes apart. */
const PARTS = ['adaptive-diffuse', 'adaptive-specular'];

export class Pool {
  private readonly hands: Hand[];
  /** Have the whole scene, for shading that looks at neighbours; started when first asked. */
  private readonly wholes: (Promise<Hand> | undefined)[] = [];
  private file: Bytes | null = null;
  private coeffs = new Float32Array();
  /** Lights so far, and which of them the last packed matrix is of. */
  private lightCount = 0;
  private packed: { light: string; matrix: PackedLight['matrix'] } | null = null;

  constructor(count: number) {
    this.hands = Array.from({ length: count }, () => new Hand());
  }

  /** Opens a baked file in every worker. */
  async open(file: Bytes): Promise<Geometry> {
    this.file = file;
    const opened = this.hands.map((hand, part) => hand.ask('open', { ...file, part, partCount: this.hands.length }));
    return (await Promise.all(opened))[0]!;
  }

  /** The eye that has all of the scene in view, as `ylm render` places it. */
  fit(azimuth: number, elevation: number, aspect: number) {
    return this.hands[0]!.ask('fit', { azimuth, elevation, aspect });
  }

  /** Takes a probe; what shines stays as it is until the next `light`. */
  async probe(file: Bytes) {
    await this.hands[0]!.ask('probe', file);
  }

  /** Lights the scene by words and so many times the probe. */
  async light(ask: Calls['lamp']['ask']): Promise<Lamp> {
    const lamp = await this.hands[0]!.ask('lamp', ask);
    this.coeffs = lamp.coeffs;
    this.lightCount++;
    const hands = [...this.hands, ...(await Promise.all(this.wholes)).filter((hand) => hand !== undefined)];
    await Promise.all(hands.map((hand) => hand.ask('light', lamp.coeffs)));
    return lamp;
  }

  /** Lights all points; the time is that of the slowest worker. */
  async relight(look: Look): Promise<Lit> {
    if (look.shading === 'adaptive') return this.relightAdaptively(look);
    const parts = await Promise.all(this.hands.map((hand) => hand.ask('relight', look)));
    const radiance = new Float32Array(parts.reduce((sum, part) => sum + part.radiance.length, 0));
    let start = 0;
    for (const part of parts) {
      radiance.set(part.radiance, start);
      start += part.radiance.length;
    }
    return { radiance, reach: new Float32Array(), filtered: [], milliseconds: Math.max(...parts.map((part) => part.milliseconds)) };
  }

  /** Adds what one worker makes of diffuse and another of specular reflection: a point's region does not end where a worker's points do. */
  private async relightAdaptively(look: Look): Promise<Lit> {
    const parts = PARTS.map(async (shading, index) => (await this.whole(index)).ask('relight', { ...look, shading }));
    const [diffuse, specular] = (await Promise.all(parts)) as [Lit, Lit];
    specular.radiance.forEach((value, i) => (diffuse.radiance[i]! += value));
    specular.reach.forEach((value, i) => (diffuse.reach[i] = Math.max(diffuse.reach[i]!, value)));
    const milliseconds = Math.max(diffuse.milliseconds, specular.milliseconds);
    return { ...diffuse, filtered: [...diffuse.filtered, ...specular.filtered], milliseconds };
  }

  /** The scene for a GPU. */
  async pack(): Promise<PackedScene> {
    return (await this.whole(0)).ask('pack', null);
  }

  /** A frame's light and material for a GPU; the matrix is the array of the frame before where the light is. */
  async packLight(look: Look): Promise<PackedLight> {
    const packed = await (await this.whole(0)).ask('packLight', look);
    const light = [look.shading, look.bands, ...look.rotation, this.lightCount].join();
    if (light === this.packed?.light) packed.matrix = this.packed.matrix;
    this.packed = { light, matrix: packed.matrix };
    return packed;
  }

  private whole(index: number): Promise<Hand> {
    return (this.wholes[index] ??= this.hire().catch((fault: unknown) => {
      // Another frame may ask again; until then no light waits for what is not there.
      this.wholes[index] = undefined;
      throw fault;
    }));
  }

  private async hire(): Promise<Hand> {
    const hand = new Hand();
    try {
      await hand.ask('open', { ...this.file!, part: 0, partCount: 1 });
      await hand.ask('light', this.coeffs);
      return hand;
    } catch (fault) {
      hand.end();
      throw fault;
    }
  }

  end() {
    for (const hand of this.hands) hand.end();
    for (const whole of this.wholes) void whole?.then((hand) => hand.end());
  }
}
