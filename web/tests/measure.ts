/**
 * Not a test: how long a scene takes to relight and to open; of one whose objects move the first is moved from frame to frame.
 * YLM_BAKED=FILE [YLM_LIGHT=WORDS] npm run measure
 */
import { readdirSync, readFileSync, statSync } from 'node:fs';
import { basename, dirname, join, resolve } from 'node:path';
import { gzipSync } from 'node:zlib';
import { test } from 'vitest';
import { launch, Tab } from './browser';
import { Server } from './scene';

const FRAMES = 60;

test('measure', async () => {
  const baked = resolve(process.env['YLM_BAKED'] ?? '');
  const light = process.env['YLM_LIGHT'];
  const server = await Server.start(dirname(baked), basename(baked), ...(light ? ['--light', light] : []));
  const browser = await launch();
  const opening: number[] = [];
  for (let i = 0; i < 5; i++) {
    const start = performance.now();
    const tab = await Tab.open(browser, server.address);
    await tab.page.waitForFunction(() => document.documentElement.dataset['frames'] !== undefined, undefined, { polling: 10 });
    opening.push(performance.now() - start);
    await tab.page.close();
  }
  const tab = await Tab.open(browser, server.address);
  await tab.settled();
  const middle = (times: number[]) => times.sort((a, b) => a - b)[times.length >> 1]!.toFixed(1);
  const lines = [`first picture ${middle(opening)} ms after the address is opened, median of ${opening.length}`];
  const turnLight = (i: number) => tab.page.evaluate((turn) => {
    const input = document.getElementById('turn') as HTMLInputElement;
    input.value = String(turn);
    input.dispatchEvent(new Event('input', { bubbles: true }));
  }, i + 1);
  const turnEye = () => tab.page.keyboard.press('ArrowLeft');
  const moveObject = (i: number) => tab.page.locator('#objects button').first().press(i % 2 === 0 ? 'ArrowRight' : 'ArrowDown');
  const ofBakes = [
    ['unshadowed', turnLight], ['shadowed', turnLight], ['glossy', turnLight], ['glossy', turnEye], ['adaptive', turnLight], ['adaptive', turnEye],
  ] as const;
  const ofScenes = [['field-exact', moveObject], ['field-chain', moveObject], ['shexp', moveObject]] as const;
  for (const [shading, move] of baked.endsWith('.json') ? ofScenes : ofBakes) {
    await tab.set({ shading });
    await tab.page.focus('#view');
    const [relit, drawn]: number[][] = [[], []];
    for (let i = 0; i < FRAMES; i++) {
      const before = await tab.frames();
      await move(i);
      await tab.page.waitForFunction((last) => Number(document.documentElement.dataset['frames']) > last, before, { polling: 2 });
      const [, a, b] = /in ([\d.]+) ms, drawn after ([\d.]+) ms/.exec(await tab.page.innerText('#time'))!;
      relit!.push(Number(a));
      drawn!.push(Number(b));
    }
    const what = move === turnEye ? 'the eye moves' : move === turnLight ? 'the light turns' : 'an object moves';
    lines.push(`${shading}, ${what}: relit in ${middle(relit!)} ms, drawn after ${middle(drawn!)} ms, medians of ${FRAMES} frames`);
  }
  const page = resolve('../crates/ylm-cli/page');
  const files = readdirSync(page).filter((name) => !name.endsWith('.sha256')).map((name) => join(page, name));
  const weight = files.reduce((sum, file) => sum + statSync(file).size, 0);
  const packed = files.reduce((sum, file) => sum + gzipSync(readFileSync(file)).length, 0);
  lines.push(`page: ${(weight / 1e6).toFixed(2)} MB, ${(packed / 1e6).toFixed(2)} MB by gzip`);
  console.log([await tab.page.innerText('#shape'), ...lines].join('\n'));
  await browser.close();
  server.stop();
});
