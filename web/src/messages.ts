/** What the page asks of its workers, and what they answer. */
import type { MovingCalls } from './moving-messages';

/** What a frame is lit by, and how. */
export interface Look {
  shading: string;
  bands: number;
  /** Turns the light: [x, y, z, w]. */
  rotation: [number, number, number, number];
  /** Diffuse, specular, shininess. */
  material: [number, number, number];
  eye: [number, number, number];
  /** What one unit of radiance is shown as. */
  gain: number;
}

/** A file in memory. */
export interface Bytes {
  name: string;
  bytes: ArrayBuffer;
}

/** All points of a scene, and what was baked. */
export interface Geometry {
  positions: Float32Array<ArrayBuffer>;
  triangles: Uint32Array<ArrayBuffer>;
  bands: number;
  transfer: string;
  /** Colours of negative values and of heat, [scale, 256, 3]. */
  scales: Uint8Array<ArrayBuffer>;
}

/** A light as the page shows it. */
export interface Lamp {
  /** [channel, n²]. */
  coeffs: Float32Array<ArrayBuffer>;
  energies: Float32Array<ArrayBuffer>;
  meanRadiance: [number, number, number];
  /** Lat-long radiance, [width / 2, width, 3]; empty if no width was asked for. */
  picture: Float32Array<ArrayBuffer>;
}

/** What comes of a frame. */
export interface Lit {
  /** [point, 3]. */
  radiance: Float32Array<ArrayBuffer>;
  /** How far each point was computed, 0 to 1; empty unless adaptive. */
  reach: Float32Array<ArrayBuffer>;
  /** Shares of the points that the filter spared, diffuse and specular; empty unless adaptive. */
  filtered: number[];
  milliseconds: number;
  /** Of objects that move: where they stood, [object, 8], and how far they had been moved, [object, 3]. */
  placed?: { poses: Float32Array<ArrayBuffer>; moved: number[] };
}

/** A baked scene as `ylm_gpu::PackedScene` has it; n bands, p points, B = ⌈p/64⌉ blocks of 64. */
export interface PackedScene {
  pointCount: number;
  bands: number;
  /** [B, n², 64]. */
  transfer: Float32Array<ArrayBuffer>;
  /** [B, 3, n², 64]; empty if the bake has no bounced light. */
  bounced: Float32Array<ArrayBuffer>;
  /** [p, 12]. */
  surfaces: Float32Array<ArrayBuffer>;
  /** [p, 8]. */
  places: Float32Array<ArrayBuffer>;
  /** [n(n+1)/2, 2]. */
  recurrence: Float32Array<ArrayBuffer>;
  /** [n]. */
  cosine: Float32Array<ArrayBuffer>;
}

/** A frame's light, turned, and material, as `ylm_gpu::pack` makes them. */
export interface PackedLight {
  /** [n², 4]. */
  light: Float32Array<ArrayBuffer>;
  /** [3, ⌈n²/8⌉, n², 8]; empty unless glossy. The same array means the same light. */
  matrix: Float32Array<ArrayBuffer>;
  /** [n]; empty unless glossy. */
  lobe: Float32Array<ArrayBuffer>;
}

/** Questions by name, each with its answer. */
export interface Calls extends MovingCalls {
  /** Bakes a part of the built-in scene; answers its transfer, [point, n²], 0 in the other parts. */
  bakeDemo: { ask: { bands: number; rays: number; part: number; partCount: number }; answer: Float32Array<ArrayBuffer> };
  /** The bytes of the built-in scene's file, of the sum of its parts. */
  demoFile: { ask: { bands: number; rays: number; vectors: Float32Array }; answer: Uint8Array<ArrayBuffer> };
  /** Opens part `part` of `partCount` of a baked file; the geometry comes from part 0. */
  open: { ask: Bytes & { part: number; partCount: number }; answer: Geometry };
  /** The eye that has all of the scene in view. */
  fit: { ask: { azimuth: number; elevation: number; aspect: number }; answer: [number, number, number] };
  /** Takes a probe beside which the words shine. */
  probe: { ask: Bytes; answer: null };
  /** Makes the light; `pictureBands` above 0 for a picture of what so many bands hold. */
  lamp: { ask: { words: string; probeGain: number; pictureWidth: number; pictureBands: number }; answer: Lamp };
  /** Lights the scene by coefficients from now on. */
  light: { ask: Float32Array; answer: null };
  relight: { ask: Look; answer: Lit };
  /** The whole scene, for a GPU. */
  pack: { ask: null; answer: PackedScene };
  packLight: { ask: Look; answer: PackedLight };
}

export type Kind = keyof Calls;
export type Question = { [K in Kind]: { kind: K; ask: Calls[K]['ask'] } }[Kind];
/** What is said of what was thrown. */
export const textOf = (fault: unknown) => (fault instanceof Error ? fault.message : String(fault));

export type Answer = { answer: Calls[Kind]['answer'] } | { fault: string };
