import { readFileSync, writeFileSync } from 'node:fs';
import type { Browser } from 'playwright-core';
import { afterAll, beforeAll, expect, test } from 'vitest';
import { launch, Tab } from './browser';
import { coloured, psnr } from './picture';
import { Place, Server } from './scene';

const LIGHT = 'sky:clear?sun=35,60';
/** The light itself past the model, as `ylm render` has it. */
const VIEW = `#${new URLSearchParams({ sky: 'none', words: LIGHT, background: 'light' })}`;

let place: Place;
let server: Server;
let browser: Browser;

beforeAll(async () => {
  place = new Place();
  [server, browser] = await Promise.all([Server.start(place.folder, 'ball.safetensors', '--light', LIGHT), launch()]);
});

afterAll(async () => {
  await browser?.close();
  server?.stop();
  place?.remove();
});

/** The picture is that of `ylm render`, away from edges. */
function expectSame(found: Buffer, ...words: string[]) {
  const exposure = words.includes('negative') ? [] : ['--exposure', 'auto'];
  place.ylm('render', 'ball.safetensors', '-o', 'expected.png', '--size', '800x600', '--camera', '30,18', ...exposure, ...words);
  const { decibels, share } = psnr(found, readFileSync(place.path('expected.png')));
  expect(decibels).toBeGreaterThanOrEqual(35);
  expect(share).toBeGreaterThan(0.8);
}

test('the picture is that of ylm render, whatever the light, the bands and the shading', async () => {
  const tab = await Tab.open(browser, server.address + VIEW);
  await tab.settled();
  const neutral = ['--tonemap', 'neutral'];
  expectSame(await tab.picture(), '--light', LIGHT, ...neutral);

  await tab.set({ tone: 'agx', turn: '50' });
  expectSame(await tab.picture(), '--light', LIGHT, '--light-rotation', '50,0', '--tonemap', 'agx');

  await tab.set({ tone: 'aces', turn: '0', words: '', disc: true, angle: '20', height: '50', discStops: '2' });
  const height = (50 * Math.PI) / 180;
  const direction = [0.6 * Math.cos(height), Math.sin(height), 0.8 * Math.cos(height)].join(',');
  const disc = `disc?dir=${direction}&angle=20&intensity=4`;
  expectSame(await tab.picture(), '--light', disc, '--tonemap', 'aces');

  await tab.set({ sky: 'overcast', tone: 'reinhard' });
  expectSame(await tab.picture(), '--light', `sky:overcast+${disc}`, '--tonemap', 'reinhard');

  await tab.set({ bands: '2', tone: 'none', background: 'plain' });
  expectSame(await tab.picture(), '--light', `sky:overcast+${disc}`, '--light-bands', '2', '--background', 'black');

  await tab.set({ bands: '5', shading: 'glossy', shininess: '12', tone: 'neutral' });
  expectSame(await tab.picture(), '--light', `sky:overcast+${disc}`, '--shading', 'glossy', '--shininess', '12', '--background', 'black', ...neutral);

  await tab.set({ shading: 'adaptive' });
  expectSame(await tab.picture(), '--light', `sky:overcast+${disc}`, '--shading', 'adaptive', '--shininess', '12', '--background', 'black', ...neutral);
  expect(await tab.page.innerText('#spared')).toContain('%');
  expect(tab.complaints).toEqual([]);
  await tab.page.close();
});

test('false colours are those of ylm render', async () => {
  const disc = 'disc?dir=0,-0.5,1&angle=6&intensity=40&color=1,0.7,0.4';
  const tab = await Tab.open(browser, `${server.address}#${new URLSearchParams({ sky: 'none', words: disc, shininess: '12' })}`);
  await tab.settled();
  expect(await tab.page.isVisible('#legend')).toBe(false);

  await tab.set({ negative: true });
  const negative = await tab.picture();
  expect(coloured(negative)).toBeGreaterThan(0.02);
  expectSame(negative, '--light', disc, '--shading', 'negative');
  expect((await tab.page.innerText('#marks')).startsWith('−')).toBe(true);

  await tab.set({ negative: false, shading: 'adaptive', reach: true });
  const reach = await tab.picture();
  expect(coloured(reach)).toBeGreaterThan(0.02);
  expectSame(reach, '--light', disc, '--shading', 'roi', '--shininess', '12');
  expect(await tab.page.innerText('#marks')).toContain('3 bands');

  // Thresholds are of what is shown: on either side another exposure is another frame.
  for (const sides of [{ shading: 'adaptive', against: '' }, { shading: 'shadowed', against: 'adaptive' }, { shading: 'adaptive', against: 'adaptive' }]) {
    await tab.set({ ...sides, reach: false });
    const before = await tab.frames();
    await tab.set({ exposure: '1' });
    expect(await tab.frames()).toBeGreaterThan(before);
  }
  await tab.set({ against: '', auto: true });

  // Where nothing is below 0 all is grey.
  await tab.set({ words: 'white', shading: 'unshadowed', negative: true });
  expect(coloured(await tab.picture())).toBe(0);
  expect(await tab.page.innerText('#legend-text')).toContain('nothing is negative');
  expect(tab.complaints).toEqual([]);
  await tab.page.close();
});

test('shadows and bounces can be left out, and wiped against each other', async () => {
  const tab = await Tab.open(browser, server.address);
  await tab.settled();
  const full = await tab.picture();
  await tab.set({ shading: 'shadowed' });
  const shadowed = await tab.picture();
  await tab.set({ shading: 'unshadowed' });
  const open = await tab.picture();
  for (const [a, b] of [[full, shadowed], [shadowed, open], [full, open]] as const) expect(psnr(a, b).decibels).toBeLessThan(45);
  await tab.set({ against: 'interreflected' });
  const divider = (await tab.page.locator('#divider').boundingBox())!;
  await tab.page.mouse.move(divider.x + 14, 300);
  await tab.page.mouse.down();
  await tab.page.mouse.move(200, 300, { steps: 3 });
  await tab.page.mouse.up();
  expect(await tab.page.getAttribute('#divider', 'aria-valuenow')).toBe('25');
  await tab.page.focus('#divider');
  for (let i = 0; i < 60; i++) await tab.page.keyboard.press('ArrowLeft');
  await tab.settled();
  expect(psnr(await tab.picture(), full).decibels).toBeGreaterThan(35);
  expect(tab.complaints).toEqual([]);
  await tab.page.close();
});

test('what is no baked file, probe or light is told of in one sentence and changes nothing', async () => {
  const tab = await Tab.open(browser, server.address);
  await tab.settled();
  const before = await tab.picture();
  const whole = readFileSync(place.path('ball.safetensors'));
  writeFileSync(place.path('damaged.safetensors'), whole.subarray(0, whole.length / 2));
  writeFileSync(place.path('broken.hdr'), '#?RADIANCE\n\n-Y 4 +X 8\n');
  for (const [file, said] of [['damaged.safetensors', 'damaged.safetensors: '], ['broken.hdr', 'broken.hdr: '], ['ball.obj', 'ball.obj: ']] as const) {
    await tab.drop(place.path(file));
    const message = await tab.message();
    expect(message).toContain(said);
    expect(message).not.toContain('\n');
    await tab.page.click('#dismiss');
  }
  expect(await tab.page.innerText('#name')).toBe('ball.safetensors');
  expect(psnr(await tab.picture(), before).decibels).toBe(Infinity);
  await tab.set({ words: 'sky:purple' });
  expect(await tab.message()).toContain('sky:purple');
  expect(psnr(await tab.picture(), before).decibels).toBe(Infinity);
  // It goes on from there.
  await tab.set({ words: LIGHT });
  expect(psnr(await tab.picture(), before).decibels).toBe(Infinity);
  expect(tab.complaints).toEqual([]);
  await tab.page.close();
});

test('keys and the mouse move the camera and turn the light, and the address keeps it all', async () => {
  const tab = await Tab.open(browser, server.address);
  await tab.settled();
  await tab.page.focus('#view');
  for (const key of ['ArrowLeft', 'ArrowUp', '+', 'Shift+ArrowRight']) await tab.page.keyboard.press(key);
  const target = () => new URLSearchParams(tab.page.url().split('#')[1]).get('eye')!.split(',').slice(3);
  const centre = target();
  await tab.page.keyboard.press('Control+ArrowUp');
  expect(target()).not.toEqual(centre);
  await tab.page.keyboard.press('Control+ArrowDown');
  target().forEach((x, axis) => expect(Number(x)).toBeCloseTo(Number(centre[axis]), 3));
  await tab.page.mouse.move(400, 300);
  await tab.page.mouse.down();
  await tab.page.mouse.move(440, 310, { steps: 4 });
  await tab.page.mouse.up();
  await tab.page.keyboard.down('Shift');
  await tab.page.mouse.down();
  await tab.page.mouse.move(500, 310, { steps: 4 });
  await tab.page.mouse.up();
  await tab.page.keyboard.up('Shift');
  await tab.set({ disc: true, exposure: '-1' });
  expect(await tab.page.isChecked('#auto')).toBe(false);
  const address = tab.page.url();
  for (const part of ['turn=35&', 'eye=', 'disc=1', 'auto=0', 'exposure=-1']) expect(address).toContain(part);
  const again = await Tab.open(browser, address);
  await again.settled();
  expect(psnr(await again.picture(), await tab.picture()).decibels).toBeGreaterThan(50);
  await again.page.click('#all');
  await again.settled();
  expect(again.page.url()).not.toContain('eye=');
  expect([...tab.complaints, ...again.complaints]).toEqual([]);
  await Promise.all([tab.page.close(), again.page.close()]);
});

test('it fits a telephone, and any size that follows', async () => {
  const tab = await Tab.open(browser, server.address, 360, 740);
  await tab.settled();
  const wide = () => tab.page.evaluate(() => [document.documentElement.scrollWidth, document.getElementById('panel')!.scrollWidth]);
  expect(Math.max(...(await wide()))).toBeLessThanOrEqual(360);
  // What `ylm view` was given shines, and all stays in view.
  await tab.page.setViewportSize({ width: 1104, height: 600 });
  await tab.set({ background: 'light' });
  expectSame(await tab.picture(), '--light', LIGHT, '--tonemap', 'neutral');
  expect(tab.complaints).toEqual([]);
  await tab.page.close();
});

test('the GPU gives the picture of the processor, and where there is none it is said', async () => {
  const withGpu = await launch('with WebGPU');
  const tab = await Tab.open(withGpu, server.address);
  await tab.settled();
  for (const shading of ['unshadowed', 'shadowed', 'interreflected', 'glossy']) {
    for (const bands of ['3', '5']) {
      await tab.set({ engine: 'wasm', shading, bands, turn: '0', specular: '0.5' });
      await tab.set({ turn: '40' });
      const expected = await tab.picture();
      await tab.set({ turn: '0' });
      expect(psnr(await tab.picture(), expected).decibels).toBeLessThan(45);
      await tab.set({ engine: 'webgpu', turn: '40' });
      expect(await tab.page.innerText('#time')).toContain('by the GPU');
      expect(psnr(await tab.picture(), expected).decibels).toBeGreaterThan(60);
    }
  }
  // Only the eye moves: the light's product is kept.
  await tab.page.focus('#view');
  await tab.page.keyboard.press('ArrowLeft');
  await tab.settled();
  const moved = await tab.picture();
  await tab.set({ engine: 'wasm' });
  expect(psnr(await tab.picture(), moved).decibels).toBeGreaterThan(60);

  // One that is too small for the scene.
  const small = await withGpu.newContext();
  await small.addInitScript(() => Object.defineProperty(GPUDevice.prototype, 'limits', { get: () => ({ maxStorageBufferBindingSize: 1e5, maxBufferSize: 1e5, maxComputeWorkgroupsPerDimension: 65535 }) }));
  const tight = await Tab.open(small, server.address);
  await tight.settled();
  await tight.set({ engine: 'webgpu', turn: '40' });
  expect(await tight.message()).toMatch(/in one piece.*; the processor goes on/);
  expect(await tight.page.inputValue('#engine')).toBe('wasm');
  const turned = await tight.picture();
  await tight.set({ turn: '0' });
  expect(psnr(await tight.picture(), turned).decibels).toBeLessThan(45);
  expect([...tab.complaints, ...tight.complaints]).toEqual([]);
  await withGpu.close();

  const without = await Tab.open(browser, server.address);
  await without.settled();
  const before = await without.picture();
  await without.set({ engine: 'webgpu' });
  expect(await without.message()).toContain('no WebGPU adapter');
  expect(await without.page.inputValue('#engine')).toBe('wasm');
  expect(psnr(await without.picture(), before).decibels).toBe(Infinity);
  await without.page.close();
});
