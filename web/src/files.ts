/** Files that come to the page: dropped, chosen, or given to `ylm view`. */
import type { Bytes } from './messages';
import { element } from './page';

const isMoving = (file: Bytes) => /\.json$/i.test(file.name);
const isProbe = (name: string) => /\.(hdr|pic|exr|pfm|dds|float)$/i.test(name);

/** Who takes files. */
export interface Taker {
  scene(file: Bytes): Promise<void>;
  /** Takes a scene of objects that move; answers which of the files beside it are its own. */
  moving(scene: Bytes, beside: Bytes[]): Promise<Bytes[]>;
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
    let read = await Promise.all(files.map(async (file) => ({ name: file.name, bytes: await file.arrayBuffer() })));
    const moving = read.find(isMoving);
    if (moving) {
      read = read.filter((file) => file !== moving);
      const own = await taker.moving(moving, read);
      // Beside a scene there may be models and more; what else lights it is a probe.
      read = read.filter((file) => isProbe(file.name) && !own.includes(file));
    }
    // Scenes first, so that a probe has something to light.
    for (const file of read.sort((a, b) => Number(isProbe(a.name)) - Number(isProbe(b.name)))) {
      await (isProbe(file.name) ? taker.probe(file) : taker.scene(file));
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
  /** Paths of the files that a scene of objects that move names; none of a baked scene. */
  files: string[];
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
export async function takeGiven({ name, probe, files: named }: Given, taker: Taker) {
  try {
    const beside = named.map((path, index) => fetched(`file/${index}`, path));
    const files = [fetched('scene', name), ...beside, ...(probe ? [fetched('probe', probe)] : [])];
    await take(await Promise.all(files), taker);
  } catch (fault) {
    taker.fault(fault);
  }
}
