import type { Browser } from 'playwright-core';
import { afterAll, beforeAll, expect, test } from 'vitest';
import { launch, Tab } from './browser';
import { Place, Server } from './scene';

let place: Place;
let server: Server;
let browser: Browser;

beforeAll(async () => {
  place = new Place();
  [server, browser] = await Promise.all([Server.start(place.folder, 'ball.safetensors'), launch()]);
});

afterAll(async () => {
  await browser?.close();
  server?.stop();
  place?.remove();
});

/** A view in which all that can be hidden is shown. */
const FULL = '#disc=1&shading=adaptive&against=shadowed&reach=1';

const ROLES = ['application', 'button', 'checkbox', 'combobox', 'slider', 'textbox', 'Canvas', 'image', 'form', 'figure'];

test('every control has a name of its own, and says its value', async () => {
  const tab = await Tab.open(browser, server.address + FULL);
  await tab.settled();
  const devtools = await tab.page.context().newCDPSession(tab.page);
  const { nodes } = await devtools.send('Accessibility.getFullAXTree');
  const named = nodes.filter((node) => !node.ignored && ROLES.includes(String(node.role?.value)));
  const names = named.map((node) => `${String(node.role?.value)} ${String(node.name?.value ?? '').trim()}`);
  expect(names.length).toBeGreaterThan(25);
  expect(names.filter((name) => !name.includes(' ') || name.endsWith(' '))).toEqual([]);
  for (const name of ['slider Time of day', 'checkbox Sun', 'combobox Tone map', 'slider Exposure', 'button Save PNG', 'slider Where the second shading begins']) {
    expect(names.some((found) => found.startsWith(name)), `${name} among ${names.join(', ')}`).toBe(true);
  }
  const texts = await tab.page.$$eval('input[type=range]', (sliders) => sliders.filter((slider) => !slider.getAttribute('aria-valuetext')).map((slider) => slider.id));
  expect(texts).toEqual([]);
  expect(await tab.page.getAttribute('#energies', 'aria-label')).toMatch(/band 0: [\d.]+, band 1: /);
  await tab.page.close();
});

test('all of it is reached by the Tab key in the order of the page, and is seen to be', async () => {
  const tab = await Tab.open(browser, server.address + FULL, 480, 360);
  await tab.settled();
  const order: string[] = [];
  for (let i = 0; i < 60; i++) {
    await tab.page.keyboard.press('Tab');
    const [name, outline] = await tab.page.evaluate(() => {
      const { activeElement: element } = document;
      if (!element || element === document.body) return ['', ''];
      // A file's chooser is seen by the button around it, the divider by its handle.
      const seen = element.matches('input[type=file]') ? element.closest('label')! : element;
      const style = element.id === 'divider' ? getComputedStyle(element, '::after') : getComputedStyle(seen);
      return [element.id || element.getAttribute('aria-label') || element.textContent!.trim(), style.outlineStyle];
    });
    if (name === '') break;
    expect(outline, name).toBe('solid');
    order.push(name!);
  }
  expect(order.slice(0, 7)).toEqual(['view', 'divider', 'Open a baked file or a probe', 'all', 'capture', 'share', 'Light']);
  expect(order).toEqual([...new Set(order)]);
  const controls = await tab.page.$$eval('#panel :is(input, select):not(:disabled, [type=file])', (found) => found.filter((one) => one.checkVisibility()).map((one) => one.id));
  expect(controls.filter((id) => !order.includes(id))).toEqual([]);
  await tab.page.close();
});

test('Escape closes what is said to be wrong', async () => {
  const tab = await Tab.open(browser, server.address);
  await tab.settled();
  await tab.set({ words: 'sky:purple' });
  expect(await tab.message()).toContain('sky:purple');
  await tab.page.keyboard.press('Escape');
  expect(await tab.page.isVisible('#message')).toBe(false);
  await tab.page.close();
});

/** Texts whose contrast with what is behind them is below 4.5, with it. */
function faint(): string[] {
  const channel = (code: number) => (code <= 0.03928 ? code / 12.92 : ((code + 0.055) / 1.055) ** 2.4);
  const pixel = document.createElement('canvas').getContext('2d', { willReadFrequently: true })!;
  const colour = (text: string) => {
    pixel.clearRect(0, 0, 1, 1);
    pixel.fillStyle = text;
    pixel.fillRect(0, 0, 1, 1);
    return [...pixel.getImageData(0, 0, 1, 1).data].map((x) => x / 255);
  };
  const luminance = ([r, g, b]: number[]) => 0.2126 * channel(r!) + 0.7152 * channel(g!) + 0.0722 * channel(b!);
  /** Behind overlays is the picture: of its colours, the one that is worst for bright text. */
  const behind = (element: Element | null): number[] => {
    if (!element) return colour(getComputedStyle(document.body).backgroundColor);
    if (element.id === 'stage' && document.body.classList.contains('open')) return [0.6, 0.6, 0.6, 1];
    const [r, g, b, a] = colour(getComputedStyle(element).backgroundColor) as [number, number, number, number];
    if (a === 1) return [r, g, b, 1];
    const below = behind(element.parentElement);
    return [r, g, b].map((x, i) => a * x + (1 - a) * below[i]!);
  };
  const found: string[] = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const element = node.parentElement!;
    const text = node.textContent!.trim();
    const isShown = text !== '' && element.checkVisibility() && element.getClientRects().length > 0 && !element.closest('option, .unseen, script');
    if (!isShown) continue;
    const [one, other] = [colour(getComputedStyle(element).color), behind(element)].map(luminance).sort((a, b) => b - a) as [number, number];
    const contrast = (one + 0.05) / (other + 0.05);
    if (!(contrast >= 4.5)) found.push(`${text.slice(0, 30)}: ${contrast.toFixed(2)}`);
  }
  return found;
}

test('text is told from what is behind it, in light and in dark', async () => {
  for (const colorScheme of ['light', 'dark'] as const) {
    const tab = await Tab.open(browser, server.address + FULL);
    await tab.page.emulateMedia({ colorScheme });
    await tab.settled();
    await tab.set({ words: 'sky:purple' });
    await tab.message();
    expect(await tab.page.evaluate(faint), colorScheme).toEqual([]);
    await tab.page.evaluate(() => document.body.classList.remove('open'));
    await tab.page.evaluate(() => document.getElementById('empty')!.removeAttribute('hidden'));
    expect(await tab.page.evaluate(faint), `${colorScheme}, empty`).toEqual([]);
    await tab.page.close();
  }
});

test('nothing moves by itself where that is not wanted', async () => {
  const tab = await Tab.open(browser, server.address);
  await tab.page.emulateMedia({ reducedMotion: 'reduce' });
  await tab.settled();
  await tab.page.evaluate(() => {
    document.body.classList.remove('open');
    document.getElementById('empty')!.removeAttribute('hidden');
    document.getElementById('opening')!.textContent = 'Opening…';
  });
  expect(await tab.page.evaluate(() => document.getAnimations().length)).toBe(0);
  await tab.page.emulateMedia({ reducedMotion: 'no-preference' });
  expect(await tab.page.evaluate(() => document.getAnimations().length)).toBe(1);
  await tab.page.close();
});
