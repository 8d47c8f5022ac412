/// <reference types="vite/client" />
/**
 * Lights the points of a scene on the GPU, by the kernels of crates/ylm-gpu: to the results of the wasm within 1e-3 of the
 * largest radiance (tests/viewer.test.ts).
 *
 * Arrays come packed from Rust (`PackedScene` and `pack` of that crate), so that layouts are written once; here they are only
 * uploaded.
 */
import frameText from '../../crates/ylm-gpu/shaders/frame.wgsl?raw';
import zonalText from '../../crates/ylm-gpu/shaders/zonal.wgsl?raw';
import diffuseText from '../../crates/ylm-gpu/shaders/diffuse.wgsl?raw';
import unshadowedText from '../../crates/ylm-gpu/shaders/unshadowed.wgsl?raw';
import receivedText from '../../crates/ylm-gpu/shaders/received.wgsl?raw';
import lobeText from '../../crates/ylm-gpu/shaders/lobe.wgsl?raw';

import { textOf, type Look, type PackedLight, type PackedScene } from './messages';

type Numbers = Float32Array<ArrayBuffer>;

/** `GPUBufferUsage` and `GPUMapMode`, which TypeScript's own types lack. */
const USAGE = { MAP_READ: 1, COPY_SRC: 4, COPY_DST: 8, UNIFORM: 64, STORAGE: 128 };
const READ = 1;

/** Points of a workgroup, and of a block: `BLOCK` of ylm-gpu. */
const BLOCK = 64;
/** Rows of the matrix that one invocation multiplies: `ROWS` of ylm-gpu. */
const ROWS = 8;
/** Bytes of `Frame`. */
const FRAME_BYTES = 32;

/** Shadings that have kernels. */
export const SHADINGS = ['unshadowed', 'shadowed', 'interreflected', 'glossy'];

const TEXTS = {
  diffuse: frameText + diffuseText,
  unshadowed: frameText + zonalText + unshadowedText,
  received: frameText + receivedText,
  lobe: frameText + zonalText + lobeText,
};

type Kernel = keyof typeof TEXTS;
type Pipelines = Record<Kernel, GPUComputePipeline>;

/** A scene on the GPU. What glossy shading needs besides is made when first asked for. */
interface Loaded {
  pointCount: number;
  bands: number;
  hasBounced: boolean;
  buffers: Record<'frame' | 'light' | 'lobe' | 'cosine' | 'transfer' | 'bounced' | 'surfaces' | 'places' | 'recurrence' | 'radiance', GPUBuffer>;
  groups: Partial<Record<Kernel, GPUBindGroup>>;
  glossy?: { matrix: GPUBuffer; received: GPUBuffer };
  /** Whose product with the transfer is in `received`. */
  matrix?: Numbers | undefined;
}

export class Gpu {
  /** Resolves when the device is gone, to the reason; from then on nothing is lit here. */
  readonly lost: Promise<string>;
  private isLost = false;
  private scene: Loaded | undefined;

  private constructor(
    private readonly device: GPUDevice,
    private readonly pipelines: Pipelines,
  ) {
    this.lost = device.lost.then((info) => {
      this.isLost = true;
      return info.message || info.reason;
    });
  }

  /** Undefined where there is no adapter, or it gives no device. */
  static async create(): Promise<Gpu | undefined> {
    // Not every browser has it, whatever the types say.
    const gpu = navigator.gpu as GPU | undefined;
    const adapter = await gpu?.requestAdapter().catch(() => null);
    if (!adapter) return undefined;
    const { maxStorageBufferBindingSize, maxBufferSize } = adapter.limits;
    const device = await adapter.requestDevice({ requiredLimits: { maxStorageBufferBindingSize, maxBufferSize } }).catch(() => undefined);
    if (!device) return undefined;
    const pipelines = await Promise.all(
      Object.entries(TEXTS).map(async ([name, code]) => {
        const module = device.createShaderModule({ label: name, code });
        return [name, await device.createComputePipelineAsync({ label: name, layout: 'auto', compute: { module, entryPoint: 'main' } })];
      }),
    ).catch((fault: unknown) => {
      throw new Error(`the GPU does not take the shaders: ${textOf(fault)}`);
    });
    return new Gpu(device, Object.fromEntries(pipelines) as Pipelines);
  }

  /** Puts a scene in the place of the one before, which stays if this one does not fit. */
  async load(packed: PackedScene): Promise<void> {
    const { pointCount, bands } = packed;
    const width = bands * bands;
    const points = Math.ceil(pointCount / BLOCK) * BLOCK;
    const expected = {
      transfer: points * width,
      surfaces: 12 * pointCount,
      places: 8 * pointCount,
      recurrence: bands * (bands + 1),
      cosine: bands,
    };
    for (const [name, length] of Object.entries(expected)) {
      const found = packed[name as keyof typeof expected].length;
      if (found !== length) throw new Error(`a scene of ${pointCount} points and ${bands} bands has ${length} numbers of ${name}, not ${found}`);
    }
    const hasBounced = packed.bounced.length > 0;
    if (hasBounced && packed.bounced.length !== 3 * points * width) {
      throw new Error(`a scene of ${pointCount} points and ${bands} bands has ${3 * points * width} numbers of bounced light, not ${packed.bounced.length}`);
    }
    if (points / BLOCK > this.device.limits.maxComputeWorkgroupsPerDimension) {
      throw new Error(`${pointCount} points are more than the GPU takes at once, ${BLOCK * this.device.limits.maxComputeWorkgroupsPerDimension}`);
    }
    const made: GPUBuffer[] = [];
    const empty = (length: number) => {
      const buffer = this.storage(length);
      made.push(buffer);
      return buffer;
    };
    const filled = (numbers: Numbers) => {
      const buffer = empty(numbers.length);
      this.device.queue.writeBuffer(buffer, 0, numbers);
      return buffer;
    };
    try {
      const scene = await this.checked((): Loaded => {
        const frame = this.device.createBuffer({ size: FRAME_BYTES, usage: USAGE.UNIFORM | USAGE.COPY_DST });
        made.push(frame);
        const buffers = {
          frame,
          light: empty(4 * width),
          lobe: empty(bands),
          cosine: filled(packed.cosine),
          transfer: filled(packed.transfer),
          bounced: hasBounced ? filled(packed.bounced) : empty(1),
          surfaces: filled(packed.surfaces),
          places: filled(packed.places),
          recurrence: filled(packed.recurrence),
          radiance: empty(3 * pointCount),
        };
        return { pointCount, bands, hasBounced, buffers, groups: {} };
      });
      this.unload();
      this.scene = scene;
    } catch (fault) {
      for (const buffer of made) buffer.destroy();
      throw fault;
    }
  }

  /** Radiance that leaves each point, [point, 3]; undefined once the device is lost, and then to be had from the wasm. */
  async relight(look: Look, packed: PackedLight): Promise<Numbers | undefined> {
    if (this.isLost) return undefined;
    const { scene, device } = this;
    if (!scene) throw new Error('no scene is open');
    const { pointCount, bands, buffers } = scene;
    const width = bands * bands;
    const isGlossy = look.shading === 'glossy';
    const used = Math.min(look.bands, bands) ** 2;
    const hasBounced = scene.hasBounced && (isGlossy || look.shading === 'interreflected');
    const frame = new ArrayBuffer(FRAME_BYTES);
    new Float32Array(frame, 0, 4).set([...look.eye, isGlossy ? look.material[0] : 1]);
    new Uint32Array(frame, 16, 4).set([pointCount, bands, used, hasBounced ? used : 0]);

    const size = 4 * 3 * pointCount;
    const staging = device.createBuffer({ size, usage: USAGE.MAP_READ | USAGE.COPY_DST });
    try {
      await this.checked(() => {
        const passes: { kernel: Kernel; workgroups: [number, number, number] }[] = [];
        const blocks = Math.ceil(pointCount / BLOCK);
        device.queue.writeBuffer(buffers.frame, 0, frame);
        device.queue.writeBuffer(buffers.light, 0, packed.light);
        passes.push({ kernel: look.shading === 'unshadowed' ? 'unshadowed' : 'diffuse', workgroups: [blocks, 1, 1] });
        if (isGlossy) {
          device.queue.writeBuffer(buffers.lobe, 0, packed.lobe);
          if (this.receive(scene, packed.matrix)) {
            passes.push({ kernel: 'received', workgroups: [blocks, Math.ceil(width / ROWS), 3] });
          }
          passes.push({ kernel: 'lobe', workgroups: [blocks, 1, 1] });
        }
        const encoder = device.createCommandEncoder();
        const pass = encoder.beginComputePass();
        for (const { kernel, workgroups } of passes) {
          pass.setPipeline(this.pipelines[kernel]);
          pass.setBindGroup(0, this.group(scene, kernel));
          pass.dispatchWorkgroups(...workgroups);
        }
        pass.end();
        encoder.copyBufferToBuffer(buffers.radiance, 0, staging, 0, size);
        device.queue.submit([encoder.finish()]);
      });
      await staging.mapAsync(READ);
      return new Float32Array(staging.getMappedRange().slice(0));
    } catch (fault) {
      // What glossy shading has may not be what it was thought to be.
      scene.matrix = undefined;
      // A device that goes while it works ends here first, and then in `lost`.
      await Promise.race([this.lost, new Promise((resolve) => setTimeout(resolve, 0))]);
      if (this.isLost) return undefined;
      throw fault;
    } finally {
      staging.destroy();
    }
  }

  /** Runs what asks something of the device, and throws what the device says of it. */
  private async checked<T>(work: () => T): Promise<T> {
    const { device } = this;
    device.pushErrorScope('validation');
    device.pushErrorScope('out-of-memory');
    const done = await (async () => work())().catch((fault: unknown) => ({ fault }));
    const faults = await Promise.all([device.popErrorScope(), device.popErrorScope()]);
    if (typeof done === 'object' && done !== null && 'fault' in done) throw done.fault;
    const fault = faults.find((found) => found !== null);
    if (fault) throw new Error(`the GPU refuses: ${fault.message}`);
    return done as T;
  }

  /** Frees what a scene has on the GPU. */
  unload() {
    if (!this.scene) return;
    const { buffers, glossy } = this.scene;
    for (const buffer of [...Object.values(buffers), ...Object.values(glossy ?? {})]) buffer.destroy();
    this.scene = undefined;
  }

  /** Uploads the light's matrix where it is another than before; whether it is. */
  private receive(scene: Loaded, matrix: Numbers): boolean {
    const width = scene.bands * scene.bands;
    const length = 3 * Math.ceil(width / ROWS) * ROWS * width;
    if (matrix.length !== length) throw new Error(`glossy shading takes a matrix of ${length} numbers, not ${matrix.length}`);
    if (matrix === scene.matrix) return false;
    if (!scene.glossy) {
      const points = Math.ceil(scene.pointCount / BLOCK) * BLOCK;
      scene.glossy = { matrix: this.storage(length), received: this.storage(3 * width * points) };
    }
    this.device.queue.writeBuffer(scene.glossy.matrix, 0, matrix);
    scene.matrix = matrix;
    return true;
  }

  private storage(length: number): GPUBuffer {
    const size = 4 * length;
    const most = Math.min(this.device.limits.maxStorageBufferBindingSize, this.device.limits.maxBufferSize);
    if (size > most) throw new Error(`the scene needs ${Math.ceil(size / 1e6)} MB in one piece, and the GPU gives ${Math.floor(most / 1e6)}`);
    return this.device.createBuffer({ size, usage: USAGE.STORAGE | USAGE.COPY_DST | USAGE.COPY_SRC });
  }

  /** A kernel's buffers, in the order of its bindings. */
  private group(scene: Loaded, kernel: Kernel): GPUBindGroup {
    const { frame, light, lobe, cosine, transfer, bounced, surfaces, places, recurrence, radiance } = scene.buffers;
    const bound = (): (GPUBuffer | undefined)[] => {
      switch (kernel) {
        case 'diffuse':
          return [frame, light, transfer, bounced, surfaces, radiance];
        case 'unshadowed':
          return [frame, recurrence, cosine, light, places, surfaces, radiance];
        case 'received':
          return [frame, scene.glossy?.matrix, transfer, scene.glossy?.received];
        case 'lobe':
          return [frame, recurrence, lobe, places, scene.glossy?.received, radiance];
      }
    };
    return (scene.groups[kernel] ??= this.device.createBindGroup({
      layout: this.pipelines[kernel].getBindGroupLayout(0),
      entries: bound().map((buffer, binding) => ({ binding, resource: { buffer: buffer! } })),
    }));
  }
}
