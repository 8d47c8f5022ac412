/** The controls: each is bound to the key of the state that it is named after. */
import { bandAt, showEnergies } from './charts';
import { hasSun, sunOf } from './light';
import { SHADINGS_OF_FIELDS } from './moving';
import { element } from './page';
import { KEYS, type Key, type State } from './state';
import type { Change, Viewer } from './viewer';

/** What a change of each control asks for; of those that are not here a new frame. */
const CHANGES: Partial<Record<Key, Change>> = {
  probe: 'light', probeStops: 'light', sky: 'light', hour: 'light', sun: 'light', skyStops: 'light', disc: 'light', angle: 'light', height: 'light',
  discStops: 'light', words: 'light', background: 'light', tone: 'picture', wipe: 'picture',
};

const stops = (value: number) => `${value > 0 ? '+' : value < 0 ? '−' : ''}${Math.abs(value).toFixed(1)} EV`;
const degrees = (value: number) => `${value < 0 ? '−' : ''}${Math.round(Math.abs(value))}°`;

/** Draws how far a slider is from 0, or from its least value. */
function fill(slider: HTMLInputElement) {
  const [least, most, value] = [slider.min, slider.max, slider.value].map(Number) as [number, number, number];
  // The thumb stays within the track by its own width.
  const place = (x: number) => `calc(${most > least ? (x - least) / (most - least) : 1} * (100% - 14px) + 7px)`;
  const start = Math.min(Math.max(0, least), most);
  slider.style.setProperty('--from', start === least ? '0%' : place(Math.min(start, value)));
  slider.style.setProperty('--to', place(Math.max(start, value)));
}

/** What stands beside a slider. */
const TEXTS: Partial<Record<Key, (state: State) => string>> = {
  probeStops: (state) => stops(state.probeStops),
  skyStops: (state) => stops(state.skyStops),
  discStops: (state) => stops(state.discStops),
  hour: ({ hour }) => `${Math.floor(hour)}:${String(Math.floor((hour % 1) * 60)).padStart(2, '0')}`,
  angle: (state) => degrees(state.angle),
  height: (state) => degrees(state.height),
  turn: (state) => degrees(state.turn),
  tilt: (state) => degrees(state.tilt),
  diffuse: (state) => state.diffuse.toFixed(2),
  specular: (state) => state.specular.toFixed(2),
  shininess: (state) => String(state.shininess),
  second: (state) => `${state.second.toFixed(2)} s`,
};

export class Panel {
  onChange: (change: Change) => void = () => {};

  constructor(private readonly state: State, private readonly viewer: Viewer) {
    for (const key of KEYS) {
      element<HTMLInputElement | undefined & HTMLElement>(key)?.addEventListener('input', (event) => this.take(key, event.target as HTMLInputElement));
    }
    element('panel').addEventListener('submit', (event) => event.preventDefault());
    this.listenToDivider();
    element('energies').addEventListener('click', (event) => {
      const bands = element<HTMLInputElement>('bands');
      bands.value = String(bandAt(event.clientX) + 1);
      this.take('bands', bands);
    });
  }

  private take(key: Key, { type, checked, value }: HTMLInputElement) {
    Object.assign(this.state, { [key]: type === 'checkbox' ? checked : type === 'range' ? Number(value) : value });
    if (key === 'exposure') this.state.auto = false;
    if (key === 'auto' && !checked) this.state.exposure = Number(element<HTMLInputElement>('exposure').value);
    // Thresholds of adaptive shading are of what is shown, and a picture of bands is one of other bands.
    const isOfLight = key === 'bands' && this.state.background === 'bands';
    const isOfPicture = key === 'exposure' && ![this.state.shading, this.state.against].includes('adaptive');
    this.onChange(isOfLight ? 'light' : isOfPicture ? 'picture' : (CHANGES[key] ?? 'frame'));
    this.show();
  }

  /** Shows the state in the controls. */
  show() {
    const { state, viewer } = this;
    for (const key of KEYS) {
      const input = element(key) as HTMLInputElement | null;
      if (!input || (input === document.activeElement && input.type === 'text')) continue;
      if (input.type === 'checkbox') input.checked = Boolean(state[key]);
      else input.value = String(state[key]);
      const text = TEXTS[key]?.(state);
      if (text !== undefined) this.label(key, text);
    }
    const bands = element<HTMLInputElement>('bands');
    [bands.max, bands.value] = [String(viewer.geometry?.bands ?? 1), String(viewer.bands)];
    this.label('bands', `${viewer.bands} of ${bands.max}`);
    element<HTMLInputElement>('exposure').value = String(viewer.exposure);
    this.label('exposure', stops(viewer.exposure));
    for (const slider of document.querySelectorAll<HTMLInputElement>('input[type=range]')) fill(slider);
    element<HTMLSelectElement>('shading').value = viewer.shadingOf(state.shading);
    this.showWhatApplies();
    this.showDivider();
  }

  private label(key: string, text: string) {
    document.querySelector<HTMLOutputElement>(`output[for=${key}]`)!.value = text;
    element(key).setAttribute('aria-valuetext', text);
  }

  /** Hides what has no effect now. */
  private showWhatApplies() {
    const { state, viewer } = this;
    const shadings = [viewer.shadingOf(state.shading), ...(state.against === '' ? [] : [viewer.shadingOf(state.against)])];
    const applies: Record<string, boolean> = {
      'of-probe': viewer.probe !== null && state.probe,
      'of-sun': hasSun(state.sky),
      'of-sky': state.sky !== 'none',
      'of-disc': state.disc,
      'of-gloss': shadings.some((name) => ['glossy', 'adaptive'].includes(name)),
      'of-adaptive': shadings.includes('adaptive'),
      'of-moving': viewer.geometry?.moving !== undefined,
      'of-baked': viewer.geometry?.moving === undefined,
    };
    for (const [name, does] of Object.entries(applies)) {
      for (const row of document.querySelectorAll<HTMLElement>(`#panel .${name}`)) row.hidden = !does;
    }
    const probe = element<HTMLInputElement>('probe');
    probe.disabled = viewer.probe === null;
    probe.checked = viewer.probe !== null && state.probe;
    element('probe-name').textContent = viewer.probe?.name ?? 'drop an .hdr or .exr';
    element('sun-place').textContent = `The sun stands ${Math.round(sunOf(state.hour)[0])}° high.`;
    const baked = viewer.geometry?.transfer;
    for (const option of document.querySelectorAll<HTMLOptionElement>('#shading option, #against option')) {
      option.hidden = SHADINGS_OF_FIELDS.includes(option.value) ? baked !== 'moving' : baked === 'moving' && option.value !== '';
      option.disabled = baked !== undefined && option.value !== '' && viewer.shadingOf(option.value) !== option.value;
      option.dataset['name'] ??= option.text;
      option.text = option.dataset['name'] + (option.disabled ? ' – not baked' : '');
    }
  }

  /** The energies of the light's bands, those that are used in colour. */
  showEnergies() {
    showEnergies(this.viewer.lamp?.energies ?? new Float32Array(), this.viewer.bands);
  }

  private showDivider() {
    const { against, wipe } = this.state;
    const divider = element('divider');
    divider.hidden = against === '';
    divider.style.left = `${100 * wipe}%`;
    divider.setAttribute('aria-valuenow', String(Math.round(100 * wipe)));
    const name = (id: string, value: string) => [...element<HTMLSelectElement>(id).options].find((option) => option.value === value)?.text ?? '';
    element('left').textContent = name('shading', this.viewer.shadingOf(this.state.shading));
    element('right').textContent = name('against', against);
  }

  private listenToDivider() {
    const divider = element('divider');
    const move = (wipe: number) => {
      this.state.wipe = Math.round(1000 * Math.min(Math.max(wipe, 0.02), 0.98)) / 1000;
      this.onChange('picture');
      this.showDivider();
    };
    divider.addEventListener('pointerdown', (event) => divider.setPointerCapture(event.pointerId));
    divider.addEventListener('pointermove', (event) => {
      if (!divider.hasPointerCapture(event.pointerId)) return;
      const { left, width } = divider.parentElement!.getBoundingClientRect();
      move((event.clientX - left) / width);
    });
    divider.addEventListener('keydown', (event) => {
      const step = { ArrowLeft: -0.02, ArrowRight: 0.02, Home: -1, End: 1 }[event.key];
      if (step === undefined) return;
      event.preventDefault();
      move(this.state.wipe + step);
    });
  }
}
