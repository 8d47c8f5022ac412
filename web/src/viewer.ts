/** A baked scene and its light: what is asked of the workers when, and what is drawn of the answers. */
import { Euler, Quaternion } from 'three';
import { probeGainOf, wordsOf } from './light';
import { Gpu, SHADINGS } from './gpu';
import { listenToDrags } from './drag';
import { textOf, type Bytes, type Lamp, type Lit, type Look } from './messages';
import { Moving, SHADINGS_OF_FIELDS } from './moving';
import type { AnyGeometry } from './moving-messages';
import { MovingPool } from './moving-pool';
import { Navigation } from './navigation';
import { Pool } from './pool';
import { Stage, type Picture, type Scale, type Shown } from './stage';
import type { State } from './state';

const WORKER_COUNT = 2;
/** Texels across the picture of the light. */
const SKY_WIDTH = 512;
/** `ylm render`'s automatic exposure: a white surface that sees all of the light shows as this. */
const AUTO_LEVEL = 0.5;
const RADIANS = Math.PI / 180;

/** What is drawn past the model, by the names of the state. */
const BACKGROUNDS: Record<string, Picture['background']> = { studio: 'studio', light: 'light', bands: 'light', plain: 'black' };

/** What a change of the state asks for: another light, another frame, or the same frame drawn anew. */
export type Change = 'light' | 'frame' | 'picture';

/** What the page is told of each frame. */
export interface Report {
  lit: Lit[];
  /** Whether the GPU lit all of it. */
  isOnGpu: boolean;
  milliseconds: number;
  /** Of false colours on one of the sides. */
  legend: { shown: 'negative'; scale: Scale } | { shown: 'reach' } | null;
}

export class Viewer {
  geometry: AnyGeometry | null = null;
  readonly moving: Moving;
  /** A probe; without bytes the light of the scene's own file. */
  probe: Bytes | null = null;
  lamp: Lamp | null = null;
  readonly navigation: Navigation;
  /** A scene is open, and about to be shown. */
  onScene = () => {};
  onLight = () => {};
  onFrame: (report: Report) => void = () => {};
  onFault: (fault: unknown) => void = () => {};
  private readonly stage: Stage;
  private pool: Pool | MovingPool | null = null;
  /** Asked for when it is first chosen; undefined where there is none. */
  private gpu: Promise<Gpu | undefined> | null = null;
  private isOnGpu = false;
  // One question at a time; what changes meanwhile is asked for once the answer is there.
  private readonly stale = { light: false, frame: false };
  private isBusy = false;

  constructor(private readonly state: State, private readonly canvas: HTMLCanvasElement) {
    this.stage = new Stage(canvas);
    this.moving = new Moving(state, this.view);
    this.listenToDrags();
    this.navigation = new Navigation(this.stage.camera, canvas);
    new ResizeObserver(() => {
      if (!this.stage.resize()) return;
      this.draw();
      // A view that nobody has chosen keeps all in it.
      if (this.geometry && this.state.eye === '') void this.seeAll().then(() => this.changed('frame'));
    }).observe(canvas.parentElement!);
  }

  /** The shading of a name for this bake; what was not baked is as near to it as there is. */
  shadingOf(name: string): string {
    if (this.geometry?.moving) return SHADINGS_OF_FIELDS.includes(name) ? name : SHADINGS_OF_FIELDS[0]!;
    const baked = this.geometry?.transfer ?? 'shadowed';
    const order = ['unshadowed', 'shadowed', 'interreflected'];
    if (name === 'glossy' || name === 'adaptive') return name;
    const wanted = order.indexOf(name);
    return order[Math.min(wanted < 0 ? 2 : wanted, order.indexOf(baked))]!;
  }

  /** Bands that are used. */
  get bands(): number {
    return Math.max(1, Math.min(Math.round(this.state.bands), this.geometry?.bands ?? 1));
  }

  /** Stops of exposure. */
  get exposure(): number {
    const [r, g, b] = this.lamp?.meanRadiance ?? [0, 0, 0];
    const luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    if (!this.state.auto) return this.state.exposure;
    return luminance > 0 ? Math.log2(AUTO_LEVEL / luminance) : 0;
  }

  /** Opens a baked file; what is shown stays if it is none. */
  async openScene(file: Bytes) {
    const next = new Pool(WORKER_COUNT);
    await this.show(next, async () => {
      const geometry = await next.open(file);
      if (this.probe?.bytes.byteLength) await next.probe(this.probe);
      else this.probe = null;
      return geometry;
    });
  }

  /** Opens a scene of objects that move, which shines by its own light at first; answers which of the files beside it are its own. */
  async openMoving(scene: Bytes, beside: Bytes[]): Promise<Bytes[]> {
    const next = new MovingPool(WORKER_COUNT, () => this.moving.places);
    let own: Bytes[] = [];
    await this.show(next, async () => {
      const { geometry, used } = await next.open(scene, beside);
      own = used;
      this.probe = { name: `the light of ${scene.name}`, bytes: new ArrayBuffer() };
      return geometry;
    });
    return own;
  }

  private async show(next: Pool | MovingPool, open: () => Promise<AnyGeometry>) {
    try {
      const geometry = await open();
      // A frame that is being made is finished by those who began it.
      while (this.isBusy) await new Promise((resolve) => setTimeout(resolve, 5));
      this.pool?.end();
      [this.pool, this.geometry, this.isOnGpu] = [next, geometry, false];
    } catch (fault) {
      next.end();
      throw fault;
    }
    this.moving.open(this.geometry.moving ?? null);
    this.onScene();
    this.stage.setGeometry(this.geometry.positions, this.geometry.triangles);
    this.stage.setScales(this.geometry.scales);
    this.stage.resize();
    const place = this.state.eye.split(',').map(Number);
    if (place.length === 6 && place.every(Number.isFinite)) this.navigation.place(place);
    else await this.seeAll();
    this.changed('light');
  }

  /** Takes a probe; the light stays if it is none. */
  async openProbe(file: Bytes) {
    if (!this.pool) throw new Error(`${file.name}: open a baked file first, then drop a probe to light it`);
    await this.pool.probe(file);
    this.probe = file;
  }

  /** Puts all of the scene in view. */
  async seeAll() {
    if (!this.pool) return;
    const [azimuth, elevation] = [30, 18];
    const eye = await this.pool.fit(azimuth, elevation, this.stage.camera.aspect);
    this.navigation.look(eye, azimuth, elevation, this.stage.center);
    this.state.eye = '';
  }

  /** What arrow keys that move objects go by: how large the scene is, and where right is, as x and z. */
  private get view() {
    const { stage } = this;
    return {
      get radius() {
        return stage.radius;
      },
      get right(): [number, number] {
        const [x = 1, , z = 0] = stage.camera.matrixWorld.elements;
        return [x, z];
      },
    };
  }

  /** Objects are elsewhere: they are seen there at once, and lit there once that is done. */
  moved() {
    if (this.geometry?.moving && this.moving.hasPoses) this.stage.setPositions(this.moving.positions());
    this.draw();
  }

  private listenToDrags() {
    const { stage, moving } = this;
    listenToDrags(this.canvas, {
      ray: (x, y) => stage.ray(x, y),
      pick: (ray) => {
        if (!this.geometry?.moving) return undefined;
        const hit = stage.hit(ray);
        const object = hit && moving.objectOf(hit.triangle);
        return object === undefined ? undefined : { object, point: hit!.point };
      },
      move: (object, x, z) => moving.by(object, x, z),
      get reach() {
        return { center: stage.center, radius: 2 * stage.radius };
      },
    });
  }

  changed(what: Change) {
    if (what === 'picture') return this.draw();
    this.stale.frame = true;
    if (what === 'light') this.stale.light = true;
    void this.work();
  }

  /** The picture as it is now. */
  capture(): string {
    this.draw();
    return this.canvas.toDataURL('image/png');
  }

  private get lightRotation(): Quaternion {
    return new Quaternion().setFromEuler(new Euler(this.state.tilt * RADIANS, this.state.turn * RADIANS, 0, 'YXZ'));
  }

  private async work() {
    if (this.isBusy || !this.pool) return;
    this.isBusy = true;
    this.canvas.setAttribute('aria-busy', 'true');
    try {
      while (this.stale.light || this.stale.frame) {
        if (this.stale.light) {
          this.stale.light = false;
          await this.light(this.pool);
        }
        this.stale.frame = false;
        await this.frame(this.pool);
      }
    } catch (fault) {
      this.onFault(fault);
    } finally {
      this.isBusy = false;
      this.canvas.setAttribute('aria-busy', 'false');
    }
  }

  private async light(pool: Pool | MovingPool) {
    const { state } = this;
    const pictureWidth = BACKGROUNDS[state.background] === 'light' ? SKY_WIDTH : 0;
    this.lamp = await pool.light({
      words: wordsOf(state, this.geometry?.bands ?? 1),
      probeGain: this.probe ? probeGainOf(state) : 0,
      pictureWidth,
      pictureBands: state.background === 'bands' ? this.bands : 0,
    });
    if (pictureWidth > 0) this.stage.setSky(this.lamp.picture, pictureWidth);
    this.onLight();
  }

  private async frame(pool: Pool | MovingPool) {
    const { state } = this;
    const start = performance.now();
    const names = state.against === '' ? [state.shading] : [state.shading, state.against];
    const lit: Lit[] = [];
    let isOnGpu = true;
    let legend: Report['legend'] = null;
    for (const [side, name] of names.entries()) {
      const look = this.look(this.shadingOf(name));
      const byGpu = await this.relightOnGpu(pool, look);
      isOnGpu &&= byGpu !== undefined;
      lit.push(byGpu ?? (await pool.relight(look)));
      const [numbers, shown] = shownOf(lit[side]!, look, state);
      const scale = this.stage.setRadiance(side as 0 | 1, numbers, shown);
      if (shown === 'reach') legend = { shown };
      else if (scale) legend = { shown: 'negative', scale };
      const { placed } = lit[side]!;
      if (placed) this.stage.setPositions(this.moving.positions(placed));
    }
    this.draw();
    this.onFrame({ lit, isOnGpu, legend, milliseconds: performance.now() - start });
  }

  /** What the GPU makes of it, if it is chosen, is there, and has a kernel for it. */
  private async relightOnGpu(pool: Pool | MovingPool, look: Look): Promise<Lit | undefined> {
    if (pool instanceof MovingPool || this.state.engine !== 'webgpu' || !SHADINGS.includes(look.shading)) return undefined;
    try {
      this.gpu ??= Gpu.create();
      const gpu = await this.gpu;
      if (!gpu) throw new Error('this browser gives no WebGPU adapter');
      if (!this.isOnGpu) {
        await gpu.load(await pool.pack());
        this.isOnGpu = true;
      }
      const start = performance.now();
      const radiance = await gpu.relight(look, await pool.packLight(look));
      return radiance && { radiance, reach: new Float32Array(), filtered: [], milliseconds: performance.now() - start };
    } catch (fault) {
      this.state.engine = 'wasm';
      this.onFault(new Error(`${textOf(fault)}; the processor goes on`));
      return undefined;
    }
  }

  private look(shading: string): Look {
    const { state } = this;
    const { x, y, z, w } = this.lightRotation;
    const { position } = this.stage.camera;
    return {
      shading,
      bands: this.bands,
      rotation: [x, y, z, w],
      material: [state.diffuse, state.specular, state.shininess],
      eye: [position.x, position.y, position.z],
      gain: 2 ** this.exposure,
    };
  }

  private draw() {
    const { state } = this;
    this.stage.draw({
      gain: 2 ** this.exposure,
      tone: state.tone,
      lightRotation: this.lightRotation,
      background: BACKGROUNDS[state.background] ?? 'studio',
      wipe: state.against === '' ? 1 : state.wipe,
    });
  }
}

/** What is shown of a frame: three numbers a point, and what they stand for. */
function shownOf(lit: Lit, look: Look, state: State): [Float32Array, Shown] {
  if (look.shading === 'adaptive' && state.reach) {
    const numbers = new Float32Array(lit.radiance.length);
    for (let i = 0; i < lit.reach.length; i++) numbers.fill(lit.reach[i]!, 3 * i, 3 * i + 3);
    return [numbers, 'reach'];
  }
  return [lit.radiance, state.negative ? 'negative' : 'radiance'];
}
