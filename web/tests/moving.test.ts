import { createServer, type Server as Files } from 'node:http';
import { existsSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { extname, join, resolve } from 'node:path';
import type { AddressInfo } from 'node:net';
import type { Browser } from 'playwright-core';
import { afterAll, beforeAll, expect, test } from 'vitest';
import { launch, PANEL, Tab } from './browser';
import { psnr } from './picture';
import { Board } from './pieces';
import { Server } from './scene';

/** Where screenshots go. */
const SHOTS = resolve(process.env['YLM_SCREENSHOTS'] ?? '../target/viewer');
/** What is the same for pictures that are compared: no background, the tone map of `rendered`. */
const PLAIN = { background: 'plain', tone: 'neutral' };

let board: Board;
let server: Server;
let browser: Browser;

beforeAll(async () => {
  mkdirSync(SHOTS, { recursive: true });
  board = new Board();
  [server, browser] = await Promise.all([Server.start(board.folder, 'board.json'), launch()]);
});

afterAll(async () => {
  await browser?.close();
  server?.stop();
  board?.remove();
});

async function opened(fragment = '', width = 800 + PANEL, height = 600): Promise<Tab> {
  const tab = await Tab.open(browser, server.address + fragment, width, height);
  await tab.settled();
  await tab.set(PLAIN);
  return tab;
}

/** The picture is that of `ylm render`, away from edges. */
function expectSame(found: Buffer, expected: Buffer) {
  const { decibels, share } = psnr(found, expected);
  expect(decibels).toBeGreaterThanOrEqual(35);
  expect(share).toBeGreaterThan(0.8);
}

/** Where the pointer is over an object that can be moved: the first such place in rows from below, which belongs to what stands in front. */
async function overAnObject(tab: Tab): Promise<[x: number, y: number]> {
  for (let y = 470; y > 100; y -= 20) {
    for (let x = 120; x < 700; x += 15) {
      await tab.page.mouse.move(x, y);
      await tab.page.evaluate(() => new Promise(requestAnimationFrame));
      if (await tab.page.evaluate(() => document.getElementById('view')!.classList.contains('movable'))) return [x, y];
    }
  }
  throw new Error('no object is under the pointer anywhere');
}

/** Which objects the address says are moved, and how far. */
function movedIn(tab: Tab): Record<number, [number, number]> {
  const text = new URLSearchParams(new URL(tab.page.url()).hash.slice(1)).get('moved') ?? '';
  return Object.fromEntries(text.split(';').filter((one) => one !== '').map((one) => {
    const [object, x, z] = one.split(/[:,]/).map(Number) as [number, number, number];
    return [object, [x, z]];
  }));
}

test('the picture of a scene is that of ylm render, by every product and at any time', async () => {
  const tab = await opened();
  expect(await tab.page.innerText('#name')).toBe('board.json');
  const exact = await tab.picture();
  expectSame(exact, board.rendered('board.json'));
  await tab.set({ shading: 'field-chain' });
  expectSame(await tab.picture(), board.rendered('board.json', '--shading', 'field-chain'));
  await tab.set({ shading: 'shexp' });
  const balls = await tab.picture();
  expectSame(balls, board.rendered('board.json', '--shading', 'shexp'));
  expect(psnr(balls, exact).decibels).toBeLessThan(40);
  await tab.set({ shading: 'field-exact', second: '2' });
  const later = await tab.picture();
  expectSame(later, board.rendered('board.json', '--time', '2'));
  expect(psnr(later, exact).decibels).toBeLessThan(40);
  // Fewer bands, a turned light and a sky beside the scene's own are other pictures.
  for (const change of [{ bands: '2' }, { bands: '8', turn: '90' }, { turn: '0', sky: 'overcast', probe: false }] as Record<string, string | boolean>[]) {
    await tab.set(change);
    expect(psnr(await tab.picture(), later).decibels).toBeLessThan(40);
  }
  expectSame(await tab.picture(), board.rendered('board.json', '--time', '2', '--light', 'sky:overcast'));
  expect(tab.complaints).toEqual([]);
  await tab.page.close();
});

test('an object is dragged on the ground, and its shadow follows', async () => {
  const tab = await opened();
  const before = await tab.picture();
  const [x, y] = await overAnObject(tab);
  await tab.page.mouse.down();
  await tab.page.mouse.move(x + 60, y + 15, { steps: 6 });
  await tab.page.mouse.up();
  await tab.settled();
  const moved = movedIn(tab);
  expect(Object.keys(moved)).toHaveLength(1);
  expect(tab.page.url()).not.toContain('eye=');
  // All in view again, as `ylm render` has it of the scene with the object there.
  await tab.page.click('#all');
  await tab.settled();
  const after = await tab.picture();
  board.write('moved.json', moved);
  expectSame(after, board.rendered('moved.json'));
  expect(psnr(after, before).decibels).toBeLessThan(35);
  expect(psnr(after, board.rendered('board.json')).decibels).toBeLessThan(35);
  const again = await opened(new URL(tab.page.url()).hash);
  expect(psnr(await again.picture(), after).decibels).toBeGreaterThan(50);
  await again.page.click('#back');
  await again.page.click('#all');
  await again.settled();
  expect(psnr(await again.picture(), before).decibels).toBeGreaterThan(50);
  // Beside the objects the camera is dragged.
  await again.page.mouse.move(60, 60);
  await again.page.mouse.down();
  await again.page.mouse.move(120, 60, { steps: 3 });
  await again.page.mouse.up();
  expect(movedIn(again)).toEqual({});
  expect(again.page.url()).toContain('eye=');
  expect([...tab.complaints, ...again.complaints]).toEqual([]);
  await Promise.all([tab.page.close(), again.page.close()]);
});

test('objects are chosen and moved by keys, and what they do is told', async () => {
  const tab = await opened();
  const before = await tab.picture();
  const button = tab.page.locator('#objects button').nth(4);
  expect(await tab.page.locator('#objects button').allInnerTexts()).toEqual(['queen', 'rook', 'bishop', 'pawn', 'second pawn']);
  await button.focus();
  for (let i = 0; i < 3; i++) await tab.page.keyboard.press('ArrowRight');
  await tab.page.keyboard.press('ArrowDown');
  await tab.settled();
  const [x, z] = movedIn(tab)[4]!;
  // Seen from 30° to the right, right is towards the back: (cos 30°, −sin 30°); and down is towards the eye.
  expect(x).toBeGreaterThan(0);
  expect(Math.hypot(x, z) / Math.hypot(3, 1)).toBeGreaterThan(0.02);
  expect(Math.atan2(-z, x)).toBeCloseTo(Math.PI / 6 - Math.atan2(1, 3), 2);
  expect(await button.getAttribute('aria-label')).toContain('second pawn, moved by x +');
  expect(await button.getAttribute('aria-pressed')).toBe('true');
  board.write('moved.json', movedIn(tab));
  expectSame(await tab.picture(), board.rendered('moved.json'));
  expect(psnr(await tab.picture(), before).decibels).toBeLessThan(40);
  await tab.page.click('#play');
  await tab.page.waitForFunction(() => Number((document.getElementById('second') as HTMLInputElement).value) > 0.3);
  await tab.page.click('#play');
  await tab.settled();
  expect(psnr(await tab.picture(), before).decibels).toBeLessThan(40);
  expect(tab.complaints).toEqual([]);
  await tab.page.close();
});

test('a damaged or missing file is told of in one sentence, and the view stays', async () => {
  const tab = await opened('#moved=1:0.4,0.3');
  const before = await tab.picture();
  writeFileSync(board.path('broken.json'), '{"format": "scene"');
  writeFileSync(board.path('key.json'), readFileSync(board.path('board.json'), 'utf8').replace('"bands"', '"band"'));
  const whole = readFileSync(board.path('rook-8.field'));
  mkdirSync(board.path('damaged'));
  writeFileSync(board.path('damaged/rook-8.field'), whole.subarray(0, whole.length / 2));
  const others = board.paths(...board.files.filter((name) => name !== 'rook-8.field'));
  for (const [paths, said] of [
    [board.paths('broken.json'), 'broken.json: no JSON'],
    [[...board.paths('key.json'), ...others], 'key.json: the scene has a "band"'],
    [[...board.paths('board.json'), ...others], 'board.json needs rook-8.field as well'],
    [[...board.paths('board.json', 'damaged/rook-8.field'), ...others], 'rook-8.field: '],
  ] as const) {
    await tab.choose(...paths);
    const message = await tab.message();
    expect(message).toContain(said);
    expect(message).not.toContain('\n');
    await tab.page.click('#dismiss');
  }
  expect(movedIn(tab)).toEqual({ 1: [0.4, 0.3] });
  expect(psnr(await tab.picture(), before).decibels).toBe(Infinity);
  await tab.set({ turn: '40' });
  await tab.set({ turn: '0' });
  expect(psnr(await tab.picture(), before).decibels).toBe(Infinity);
  expect(tab.complaints).toEqual([]);
  await tab.page.close();
});

/** The page alone. */
async function staticPage(): Promise<Files> {
  const page = resolve('../crates/ylm-cli/page');
  const types: Record<string, string> = { '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.wasm': 'application/wasm' };
  const files = createServer((request, response) => {
    const path = join(page, request.url === '/' ? 'index.html' : request.url!.slice(1).split('?')[0]!);
    if (!existsSync(path)) return response.writeHead(404).end();
    return response.writeHead(200, { 'Content-Type': types[extname(path)] }).end(readFileSync(path));
  });
  await new Promise<void>((listening) => files.listen(0, '127.0.0.1', listening));
  return files;
}

test('the page alone takes a scene whose files are dropped together', async () => {
  const files = await staticPage();
  const tab = await Tab.open(browser, `http://127.0.0.1:${(files.address() as AddressInfo).port}/`, 800 + PANEL, 600);
  await tab.page.waitForSelector('#empty');
  await tab.drop(...board.paths('pawn.obj', ...board.files, 'board.json'));
  await tab.settled();
  await tab.set(PLAIN);
  expect(await tab.page.innerText('#shape')).toContain('6 objects');
  expectSame(await tab.picture(), board.rendered('board.json'));
  // The description that `ylm view` would serve is not there, which the browser tells of.
  expect(tab.complaints.filter((text) => !text.includes('404'))).toEqual([]);
  await tab.page.close();
  files.close();
});

test('a scene is drawn for light and dark', async () => {
  for (const scheme of ['light', 'dark'] as const) {
    const tab = await Tab.open(browser, `${server.address}#moved=4:-0.5,0.9`, 1280, 800);
    await tab.page.emulateMedia({ colorScheme: scheme });
    await tab.settled();
    await tab.page.screenshot({ path: join(SHOTS, scheme === 'dark' ? 'viewer-moving.png' : 'viewer-moving-light.png') });
    expect(tab.complaints).toEqual([]);
    await tab.page.close();
  }
});
