/** The `ylm` command, and a small scene for it. */
import { execFileSync, spawn, type ChildProcess } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';

export const YLM = process.env['YLM'] ?? resolve('../target/debug/ylm');

/** A ball above a floor beside a wall, as .obj: shadows, and light that bounces. */
function model(): string {
  const lines: string[] = [];
  let count = 0;
  const grid = (columns: number, rows: number, colour: string, place: (u: number, v: number) => number[]) => {
    for (let row = 0; row <= rows; row++) {
      for (let column = 0; column <= columns; column++) lines.push(`v ${place(column / columns, row / rows).join(' ')} ${colour}`);
    }
    for (let row = 0; row < rows; row++) {
      for (let column = 0; column < columns; column++) {
        const corner = count + row * (columns + 1) + column + 1;
        lines.push(`f ${corner} ${corner + 1} ${corner + columns + 2}`, `f ${corner} ${corner + columns + 2} ${corner + columns + 1}`);
      }
    }
    count += (columns + 1) * (rows + 1);
  };
  grid(24, 24, '0.9 0.88 0.84', (u, v) => [4 * u - 2, 0, 2 - 4 * v]);
  grid(24, 12, '0.85 0.4 0.25', (u, v) => [4 * u - 2, 2 * v, -2]);
  grid(48, 24, '0.93 0.93 0.93', (u, v) => {
    const [phi, theta] = [2 * Math.PI * u, Math.PI * (1 - v)];
    return [0.7 * Math.sin(theta) * Math.cos(phi), 0.8 + 0.7 * Math.cos(theta), -0.7 * Math.sin(theta) * Math.sin(phi)];
  });
  return lines.join('\n');
}

/** A folder with a baked scene in it, gone with `remove`. */
export class Place {
  readonly folder = mkdtempSync(join(tmpdir(), 'ylm-view-'));

  constructor() {
    writeFileSync(this.path('ball.obj'), model());
    this.ylm('bake', 'ball.obj', '-o', 'ball.safetensors', '--bands', '5', '--rays', '256', '--transfer', 'interreflected', '--bounces', '2');
  }

  path(name: string): string {
    return join(this.folder, name);
  }

  ylm(...words: string[]) {
    execFileSync(YLM, [...words, '--quiet'], { cwd: this.folder, stdio: ['ignore', 'ignore', 'inherit'] });
  }

  remove() {
    rmSync(this.folder, { recursive: true });
  }
}

/** A running `ylm view`. */
export class Server {
  private constructor(private readonly child: ChildProcess, readonly address: string) {}

  static async start(folder: string, ...words: string[]): Promise<Server> {
    const child = spawn(YLM, ['view', ...words, '--json'], { cwd: folder, stdio: ['ignore', 'pipe', 'inherit'] });
    const line = await new Promise<string>((told, failed) => {
      child.stdout.once('data', (data: Buffer) => told(data.toString()));
      child.once('exit', () => failed(new Error('ylm view ended')));
    });
    return new Server(child, (JSON.parse(line) as { address: string }).address);
  }

  stop() {
    this.child.kill();
  }
}
