/** A scene of chess pieces that can be moved, made by the `ylm` command. */
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { YLM } from './scene';

type Profile = [radius: number, height: number][];

/** A turned piece as .obj: a profile from the foot to the top, both on the axis. */
function turned(profile: Profile, around = 32, between = 3): string {
  const rings: Profile = [];
  profile.slice(1).forEach(([radius, height], i) => {
    const [r, h] = profile[i]!;
    for (let k = 0; k < between; k++) rings.push([r + ((radius - r) * k) / between, h + ((height - h) * k) / between]);
  });
  rings.push(profile.at(-1)!);
  const lines: string[] = [];
  for (const [radius, height] of rings) {
    // A hair off the axis, so that no two corners are the same.
    for (let k = 0; k < around; k++) {
      const phi = (2 * Math.PI * k) / around;
      lines.push(`v ${(Math.max(radius, 1e-4) * Math.sin(phi)).toFixed(5)} ${height.toFixed(5)} ${(Math.max(radius, 1e-4) * Math.cos(phi)).toFixed(5)}`);
    }
  }
  for (let ring = 0; ring + 1 < rings.length; ring++) {
    for (let k = 0; k < around; k++) {
      const [a, b] = [ring * around + k + 1, ring * around + ((k + 1) % around) + 1];
      lines.push(`f ${a} ${b} ${b + around} ${a + around}`);
    }
  }
  return lines.join('\n');
}

/** A ball's profile from one height on the axis to another. */
const ball = (middle: number, radius: number, from: number): Profile =>
  Array.from({ length: 8 }, (_, i) => {
    const theta = from + ((Math.PI - from) * i) / 7;
    return [radius * Math.sin(theta), middle - radius * Math.cos(theta)];
  });

const foot = (radius: number): Profile => [[0, 0], [radius, 0], [radius, 0.1], [0.82 * radius, 0.16], [0.8 * radius, 0.24], [0.55 * radius, 0.34]];
const PIECES: Record<string, Profile> = {
  pawn: [...foot(0.42), [0.16, 0.7], [0.24, 0.76], [0.14, 0.82], ...ball(1.02, 0.24, 0.7)],
  rook: [...foot(0.48), [0.27, 1.05], [0.38, 1.15], [0.4, 1.42], [0.28, 1.42], [0.28, 1.3], [0, 1.3]],
  bishop: [...foot(0.46), [0.16, 1.05], [0.3, 1.13], [0.15, 1.2], [0.25, 1.38], [0.25, 1.5], [0.14, 1.72], [0.05, 1.78], ...ball(1.85, 0.08, 0.9)],
  queen: [...foot(0.52), [0.18, 1.3], [0.34, 1.4], [0.17, 1.48], [0.33, 2.0], [0.22, 1.98], [0.13, 2.08], ...ball(2.16, 0.1, 0.9)],
};

const WOOD = [0.36, 0.2, 0.11];
const IVORY = [0.93, 0.87, 0.74];

interface Piece {
  name: string;
  model: string;
  position: [number, number, number];
  albedo: number[];
  motion?: object[];
}

/** The queen stands highest, so that the view does not depend on where the others are. */
const OBJECTS: Piece[] = [
  { name: 'queen', model: 'queen.obj', position: [-0.2, 0, -0.7], albedo: IVORY },
  { name: 'rook', model: 'rook.obj', position: [-1.9, 0, -0.4], albedo: WOOD },
  { name: 'bishop', model: 'bishop.obj', position: [1.5, 0, -0.3], albedo: WOOD },
  { name: 'pawn', model: 'pawn.obj', position: [-0.9, 0, 1.1], albedo: IVORY, motion: [{ time: 0 }, { time: 2, position: [0.9, 0, 1.3] }, { time: 4, position: [-0.9, 0, 1.1] }] },
  { name: 'second pawn', model: 'pawn.obj', position: [0.9, 0, 0.5], albedo: WOOD },
];

/** A folder with the scene in it, baked; gone with `remove`. */
export class Board {
  readonly folder = mkdtempSync(join(tmpdir(), 'ylm-board-'));
  readonly light = 'sky:overcast?intensity=0.35&color=0.75,0.88,1.1+disc?dir=-0.75,0.75,0.3&angle=12&intensity=17&color=1,0.88,0.7';
  /** Files that the scene names. */
  readonly files = ['queen', 'rook', 'bishop', 'pawn'].flatMap((name) => [`${name}-8.baked`, `${name}-8.field`]);

  constructor() {
    for (const [name, profile] of Object.entries(PIECES)) writeFileSync(this.path(`${name}.obj`), turned(profile));
    this.write('board.json');
    this.ylm('scene', 'board.json');
  }

  /** Writes the scene with objects moved on the ground. */
  write(name: string, moved: Record<number, [number, number]> = {}) {
    const objects = OBJECTS.map((piece, index) => {
      const [u, w] = moved[index] ?? [0, 0];
      const at = ([x, y, z]: number[]) => [x! + u, y!, z! + w];
      const motion = piece.motion?.map((key) => ('position' in key ? { ...key, position: at(key.position as number[]) } : key));
      return { ...piece, position: at(piece.position), ...(motion ? { motion } : {}) };
    });
    const scene = { format: 'scene', format_version: 1, bands: 8, rays: 256, field_error: 0.06, seconds: 4, light: this.light, objects, ground: { size: 7, cells: 70, albedo: [0.52, 0.5, 0.47] } };
    writeFileSync(this.path(name), JSON.stringify(scene));
  }

  path(name: string): string {
    return join(this.folder, name);
  }

  paths(...names: string[]): string[] {
    return names.map((name) => this.path(name));
  }

  ylm(...words: string[]) {
    execFileSync(YLM, [...words, '--quiet'], { cwd: this.folder, stdio: ['ignore', 'ignore', 'inherit'] });
  }

  /** What `ylm render` makes of a scene in this folder. */
  rendered(scene: string, ...words: string[]): Buffer {
    this.ylm('render', scene, '-o', 'expected.png', '--size', '800x600', '--camera', '30,18', '--exposure', 'auto', '--tonemap', 'neutral', '--background', 'black', ...words);
    return readFileSync(this.path('expected.png'));
  }

  remove() {
    rmSync(this.folder, { recursive: true });
  }
}
