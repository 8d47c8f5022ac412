/** Files that come to the page: dropped, chosen, or given to `ylm view`. */
import type { Bytes } from './messages';
import { element } from './page';

const isProbe = (name: string) => /\.(hdr|pic|exr|pfm|dds|float)$/i.test(name);

/** Who takes files. */
export interface Taker {
  scene(file: Bytes): Promise<void>;
  probe(file: Bytes): Promise<void>;
  fault(fault: unknown): void;
}

/** A file whose bytes are yet to be read. */
interface Coming {
  name: string;
  arrayBuffer(): Promise<ArrayBuffer>;
}

async function take(files: Coming[], taker: Taker) {
  try {
    // Scenes first, so that a probe has something to light.
    for (const file of [...files].sort((a, b) => Number(isProbe(a.name)) - Number(isProbe(b.name)))) {
      const bytes = { name: file.name, bytes: await file.arrayBuffer() };
      await (isProbe(file.name) ? taker.probe(bytes) : taker.scene(bytes));
    }
  } catch (fault) {
    taker.fault(fault);
  }
}

/** Takes what is dropped on the page, or chosen. */
export function listen(taker: Taker) {
  for (const input of document.querySelectorAll<HTMLInputElement>('input[type=file]')) {
    input.addEventListener('change', () => {
      void take([...(input.files ?? [])], taker);
      input.value = '';
    });
  }
  const main = element('stage');
  document.addEventListener('dragover', (event) => {
    event.preventDefault();
    main.classList.add('dropping');
  });
  document.addEventListener('dragleave', (event) => {
    if (!event.relatedTarget) main.classList.remove('dropping');
  });
  document.addEventListener('drop', (event) => {
    event.preventDefault();
    main.classList.remove('dropping');
    void take([...(event.dataTransfer?.files ?? [])], taker);
  });
}

/** What `ylm view` was given. */
export interface Given {
  name: string;
  probe: string | null;
  light: string;
}

async function fetched(path: string, name: string): Promise<Coming> {
  const response = await fetch(path);
  if (!response.ok) throw new Error(`${name}: ${(await response.text()).trim()}`);
  return { name, arrayBuffer: () => response.arrayBuffer() };
}

/** What `ylm view` serves beside the page; a static page has nothing. */
export async function given(): Promise<Given | null> {
  const response = await fetch('view.json').catch(() => null);
  const isDescription = response?.ok && response.headers.get('Content-Type')?.includes('json');
  return isDescription ? ((await response.json()) as Given) : null;
}

/** Takes what was given. */
export async function takeGiven({ name, probe }: Given, taker: Taker) {
  try {
    const files = [fetched('scene', name), ...(probe ? [fetched('probe', probe)] : [])];
    await take(await Promise.all(files), taker);
  } catch (fault) {
    taker.fault(fault);
  }
}
