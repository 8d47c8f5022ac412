/** What is asked of workers about scenes of objects that move, besides what is asked about all. */
import type { Bytes, Geometry, Look } from './messages';

/** The objects of a scene, and their points one object after the other. */
export interface MovingGeometry {
  /** The ground last, if there is one. */
  names: string[];
  hasGround: boolean;
  pointCounts: Uint32Array<ArrayBuffer>;
  triangleCounts: Uint32Array<ArrayBuffer>;
  /** [point, 3], in each object's own axes. */
  positions: Float32Array<ArrayBuffer>;
  /** Corners of triangles, counted from an object's first point. */
  triangles: Uint32Array<ArrayBuffer>;
  bands: number;
  /** Of the animation; 0 if nothing moves by itself. */
  seconds: number;
  hasMaterials: boolean;
  /** Of the scene's own lamps that stand somewhere, in its middle. */
  meanOfLamps: [number, number, number];
  /** As of a baked scene. */
  scales: Uint8Array<ArrayBuffer>;
}

/** Where objects are at a time. */
export interface Places {
  second: number;
  /** How far each object is from where the animation has it, [object, 3]; none stand for 0. */
  moved: number[];
}

/** What comes of a share of a frame. */
export interface MovingLit {
  /** [point, 3]; 0 at the points of other shares. */
  radiance: Float32Array<ArrayBuffer>;
  /** [object, 8]: a quaternion, a position, a scale. */
  poses: Float32Array<ArrayBuffer>;
  milliseconds: number;
}

export interface MovingCalls {
  /** Opens a share of a scene, or answers which files it names that are not among `files`. */
  openMoving: { ask: Bytes & { files: Bytes[]; part: number; partCount: number }; answer: MovingGeometry | string[] };
  posesMoving: { ask: Places; answer: Float32Array<ArrayBuffer> };
  fitMoving: { ask: { azimuth: number; elevation: number; aspect: number; moved: number[] }; answer: [number, number, number] };
  /** Lights by coefficients, and by the scene's own lamps so many times over. */
  lightMoving: { ask: { coeffs: Float32Array; ownGain: number }; answer: null };
  relightMoving: { ask: Look & Places; answer: MovingLit };
}

/** Of a baked scene nothing moves. */
export type AnyGeometry = Geometry & { moving?: MovingGeometry };
