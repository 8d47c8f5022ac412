import { createServer, type Server as HttpServer } from 'node:http';
import { existsSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { extname, join, resolve } from 'node:path';
import type { AddressInfo } from 'node:net';
import type { Browser } from 'playwright-core';
import { afterAll, beforeAll, expect, test } from 'vitest';
import { launch, Tab } from './browser';
import { psnr } from './picture';
import { Place } from './scene';

/** Where screenshots go. */
const SHOTS = resolve(process.env['YLM_SCREENSHOTS'] ?? '../target/viewer');
const PAGE = resolve('../crates/ylm-cli/page');
const TYPES: Record<string, string> = { '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.wasm': 'application/wasm' };
/** The built-in scene, by more rays a point than a visitor waits for. */
const DEMO = 'demo=192';

let browser: Browser;
let files: HttpServer;
let address: string;

beforeAll(async () => {
  mkdirSync(SHOTS, { recursive: true });
  files = createServer((request, response) => {
    const path = join(PAGE, request.url === '/' ? 'index.html' : request.url!.slice(1).split('?')[0]!);
    if (!existsSync(path)) return response.writeHead(404).end();
    return response.writeHead(200, { 'Content-Type': TYPES[extname(path)] }).end(readFileSync(path));
  });
  await new Promise<void>((listening) => files.listen(0, '127.0.0.1', listening));
  address = `http://127.0.0.1:${(files.address() as AddressInfo).port}/`;
  browser = await launch();
});

afterAll(async () => {
  await browser?.close();
  files?.close();
});

/** What the page complained of, but for the description that `ylm view` would serve, which the browser tells of. */
const complaints = (tab: Tab) => tab.complaints.filter((text) => !text.includes('404'));

test('the page alone takes a baked file and a probe that are dropped', async () => {
  const place = new Place();
  const tab = await Tab.open(browser, address);
  await tab.page.waitForSelector('#show-demo');
  await tab.page.screenshot({ path: join(SHOTS, 'viewer-empty.png') });
  // A probe: blue above, warm below, as PFM from the lowest row up.
  const texels = Float32Array.from({ length: 16 * 8 * 3 }, (_, i) => [0.9, 0.6, 0.4][i % 3]! * (i < 16 * 4 * 3 ? 0.3 : [0.5, 1, 2][i % 3]!));
  writeFileSync(place.path('probe.pfm'), Buffer.concat([Buffer.from('PF\n16 8\n-1.0\n'), Buffer.from(texels.buffer)]));
  await tab.drop(place.path('probe.pfm'), place.path('ball.safetensors'));
  await tab.settled();
  expect(await tab.page.innerText('#probe-name')).toBe('probe.pfm');
  // Texels of 22°: the picture of the light is not compared.
  await tab.set({ background: 'plain' });
  const words = ['--size', '800x600', '--camera', '30,18', '--exposure', 'auto', '--tonemap', 'neutral', '--background', 'black'];
  place.ylm('render', 'ball.safetensors', '-o', 'expected.png', '--light', 'probe.pfm', ...words);
  const { decibels, share } = psnr(await tab.picture(), readFileSync(place.path('expected.png')));
  expect(decibels).toBeGreaterThanOrEqual(35);
  expect(share).toBeGreaterThan(0.8);
  expect(complaints(tab)).toEqual([]);
  await tab.page.close();
  place.remove();
});

test('the page alone bakes the built-in scene, and its address brings it back', async () => {
  const tab = await Tab.open(browser, address);
  await tab.page.click('#show-demo');
  await tab.settled();
  expect(await tab.page.innerText('#shape')).toContain('97,784 points');
  const found = /demo=(\d+)/.exec(tab.page.url());
  expect(Number(found?.[1])).toBeGreaterThanOrEqual(64);
  const again = await Tab.open(browser, tab.page.url());
  await again.settled();
  expect(psnr(await again.picture(), await tab.picture()).decibels).toBe(Infinity);
  expect([...complaints(tab), ...complaints(again)]).toEqual([]);
  await Promise.all([tab.page.close(), again.page.close()]);
});

test('it is drawn for light and dark, and for a telephone', async () => {
  const tab = await Tab.open(browser, `${address}#${DEMO}&shading=unshadowed&against=shadowed&wipe=0.42`, 1280, 800);
  await tab.settled();
  await tab.page.waitForSelector('#notice', { state: 'hidden' });
  for (const scheme of ['light', 'dark'] as const) {
    await tab.page.emulateMedia({ colorScheme: scheme });
    await tab.settled();
    await tab.page.screenshot({ path: join(SHOTS, scheme === 'dark' ? 'viewer.png' : 'viewer-light.png') });
  }
  await tab.set({ against: '', shading: 'shadowed' });
  await tab.page.emulateMedia({ colorScheme: 'light' });
  await tab.page.setViewportSize({ width: 360, height: 740 });
  await tab.settled();
  await tab.page.screenshot({ path: join(SHOTS, 'viewer-telephone.png') });
  expect(complaints(tab)).toEqual([]);
  await tab.page.close();
});
