/** A page of the viewer in headless Chromium. */
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { chromium, type Browser, type BrowserContext, type Page } from 'playwright-core';

const FLAGS = ['--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'];

/** What gives WebGPU to a browser without a GPU: SwiftShader, a software adapter. */
const GPU_FLAGS = ['--enable-unsafe-webgpu', '--use-angle=swiftshader', '--enable-features=Vulkan', '--use-vulkan=swiftshader'];

/** Width of the panel beside the picture, in pixels. */
export const PANEL = 304;

/** Starts the Chromium that `YLM_CHROMIUM` names, else `chromium`. */
export function launch(graphics: 'with WebGPU' | 'plain' = 'plain'): Promise<Browser> {
  const name = process.env['YLM_CHROMIUM'] ?? 'chromium';
  const executablePath = execFileSync('sh', ['-c', 'command -v "$0"', name], { encoding: 'utf8' }).trim();
  return chromium.launch({ executablePath, args: graphics === 'plain' ? FLAGS : [...FLAGS, ...GPU_FLAGS] });
}

/** A page, and what it complained of. */
export class Tab {
  private constructor(readonly page: Page, readonly complaints: string[]) {}

  static async open(browser: Browser | BrowserContext, address: string, width = 800 + PANEL, height = 600): Promise<Tab> {
    const page = await browser.newPage();
    await page.setViewportSize({ width, height });
    const complaints: string[] = [];
    page.on('console', (message) => {
      if (message.type() === 'error') complaints.push(message.text());
    });
    page.on('pageerror', (error) => complaints.push(error.message));
    await page.goto(address);
    return new Tab(page, complaints);
  }

  /** Frames that were drawn so far. */
  async frames(): Promise<number> {
    return Number(await this.page.evaluate(() => document.documentElement.dataset['frames'] ?? '0'));
  }

  /** Waits until nothing new has been drawn for a while, and something was. */
  async settled() {
    let [last, quiet] = [-1, 0];
    while (quiet < 4) {
      await this.page.waitForTimeout(100);
      const now = await this.frames();
      const isBusy = (await this.page.getAttribute('#view', 'aria-busy')) === 'true';
      quiet = now === last && now > 0 && !isBusy ? quiet + 1 : 0;
      last = now;
    }
  }

  /** Sets controls by their names, and waits for what comes of it. */
  async set(values: Record<string, string | boolean>) {
    for (const [id, value] of Object.entries(values)) {
      await this.page.evaluate(([name, wanted]) => {
        const input = document.getElementById(name as string) as HTMLInputElement;
        if (typeof wanted === 'boolean') input.checked = wanted;
        else input.value = wanted as string;
        input.dispatchEvent(new Event('input', { bubbles: true }));
      }, [id, value] as const);
    }
    await this.settled();
  }

  /** The picture alone, as PNG. */
  async picture(): Promise<Buffer> {
    const address = await this.page.evaluate(() => (document.getElementById('view') as HTMLCanvasElement).toDataURL('image/png'));
    return Buffer.from(address.split(',')[1]!, 'base64');
  }

  /** Gives files to the page, as if they were dropped. */
  async drop(...paths: string[]) {
    const files = paths.map((path) => ({ name: path.split('/').at(-1)!, bytes: readFileSync(path).toString('base64') }));
    await this.page.evaluate((dropped) => {
      const transfer = new DataTransfer();
      for (const { name, bytes } of dropped) transfer.items.add(new File([Uint8Array.from(atob(bytes), (c) => c.charCodeAt(0))], name));
      document.dispatchEvent(new DragEvent('drop', { dataTransfer: transfer, bubbles: true, cancelable: true }));
    }, files);
  }

  /** Gives files to the page by its dialog: those that are too large to be written into a drop. */
  async choose(...paths: string[]) {
    await this.page.setInputFiles('#panel input[type=file]', paths);
  }

  /** What the page says, once it says something. */
  async message(): Promise<string> {
    await this.page.waitForSelector('#message:not([hidden])');
    return this.page.innerText('#message-text');
  }
}
