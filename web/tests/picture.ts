/** Pictures that are compared. */
import { PNG } from 'pngjs';

/** The peak signal-to-noise ratio of two pictures in dB, away from edges, and the part of the pixels that is away from them. */
export function psnr(found: Buffer, expected: Buffer): { decibels: number; share: number } {
  const [a, b] = [PNG.sync.read(found), PNG.sync.read(expected)];
  if (a.width !== b.width || a.height !== b.height) throw new Error(`${a.width}x${a.height} against ${b.width}x${b.height}`);
  const value = (picture: PNG, x: number, y: number, channel: number) => picture.data[4 * (y * picture.width + x) + channel]!;
  let [sum, count] = [0, 0];
  for (let y = 1; y < b.height - 1; y++) {
    for (let x = 1; x < b.width - 1; x++) {
      // An edge is where one of the neighbours, in either picture, differs by more than a smooth surface does.
      let steepest = 0;
      for (const picture of [a, b]) {
        for (const [i, j] of [[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [-1, -1], [1, -1], [-1, 1]] as const) {
          for (let c = 0; c < 3; c++) steepest = Math.max(steepest, Math.abs(value(picture, x, y, c) - value(picture, x + i, y + j, c)));
        }
      }
      if (steepest > 16) continue;
      for (let c = 0; c < 3; c++) sum += (value(a, x, y, c) - value(b, x, y, c)) ** 2;
      count += 3;
    }
  }
  return { decibels: 10 * Math.log10(255 ** 2 / (sum / count)), share: count / 3 / ((b.width - 2) * (b.height - 2)) };
}

/** The part of the pixels that are no grey. */
export function coloured(picture: Buffer): number {
  const { data } = PNG.sync.read(picture);
  let count = 0;
  for (let i = 0; i < data.length; i += 4) {
    const [r, g, b] = data.subarray(i, i + 3);
    if (Math.max(r!, g!, b!) - Math.min(r!, g!, b!) > 24) count++;
  }
  return (4 * count) / data.length;
}
