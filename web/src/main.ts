/** The page: its state, the viewer, and the controls of both. */
import { showLegend } from './charts';
import { bakeDemo, DEMO_RAYS } from './demo';
import { given, listen, takeGiven, type Taker } from './files';
import { textOf } from './messages';
import { complain, element, listenToMessages, tell } from './page';
import { Panel } from './panel';
import { fragmentOf, stateOf } from './state';
import { Viewer, type Change, type Report } from './viewer';

/** The most rays a point that an address may ask for. */
const MOST_RAYS = 1024;
/** Bands that adaptive shading computes everywhere. */
const BASE_BANDS = 3;

const state = stateOf(location.hash);
const isShared = location.hash.length > 1;
const saysSky = new URLSearchParams(location.hash.slice(1)).has('sky');
const viewer = made();
const panel = new Panel(state, viewer);

function made(): Viewer {
  try {
    return new Viewer(state, element<HTMLCanvasElement>('view'));
  } catch (what) {
    complain('This browser gives no WebGL 2, by which the scene is drawn.');
    throw what;
  }
}

const fault = (what: unknown) => complain(textOf(what));

function changed(change: Change) {
  viewer.changed(change);
  // No sky is what a scene with a light of its own begins with.
  history.replaceState(null, '', `#${fragmentOf(state, viewer.geometry?.moving ? ['sky'] : [])}`);
}

const number = (value: number) => value.toLocaleString('en');

function report({ lit, isOnGpu, legend, milliseconds }: Report) {
  const { geometry } = viewer;
  if (!geometry) return;
  const shading = lit.reduce((sum, part) => sum + part.milliseconds, 0);
  const spared = lit.find((part) => part.filtered.length > 0)?.filtered.map((part) => `${Math.round(100 * part)} %`);
  const what = geometry.moving ? `${geometry.moving.names.length} objects` : geometry.transfer;
  element('shape').textContent = `${number(geometry.positions.length / 3)} points, ${number(geometry.triangles.length / 3)} triangles, ${geometry.bands} bands, ${what}`;
  element('time').textContent = `Relit ${isOnGpu ? 'by the GPU ' : ''}in ${shading.toFixed(1)} ms, drawn after ${milliseconds.toFixed(1)} ms`;
  element('spared').textContent = spared ? `Spared by the filter: diffuse ${spared[0]}, specular ${spared[1]}` : '';
  showLegend(legend, geometry.scales, BASE_BANDS);
  // For tests: how many frames there were.
  document.documentElement.dataset['frames'] = String(Number(document.documentElement.dataset['frames'] ?? 0) + 1);
}

/** Shows that something is being opened, or once nothing is, the scene or what to do to have one. */
function open(what: string) {
  const isOpen = document.body.classList.contains('open');
  element('empty').hidden = isOpen;
  element('welcome').hidden = what !== '';
  element('opening').textContent = isOpen ? '' : what;
}

/** Bakes the built-in scene here and shows it. */
async function showDemo(rays: number) {
  open('Baking the built-in scene in this browser…');
  try {
    const file = await bakeDemo(rays);
    // A file that was dropped meanwhile is what was wanted.
    if (document.body.classList.contains('open')) return;
    await taker.scene(file);
    state.demo = rays;
    changed('picture');
    tell('Drop a baked file or an HDR probe onto the picture to open it.');
  } catch (what) {
    taker.fault(what);
  }
}

/** A scene of this name is open. */
function shown(name: string) {
  element('name').textContent = name;
  document.title = `${name} · ylm`;
  complain('');
}

const taker: Taker = {
  async scene(file) {
    await viewer.openScene(file);
    state.demo = 0;
    shown(file.name);
    panel.show();
  },
  async moving(scene, beside) {
    const own = await viewer.openMoving(scene, beside);
    state.demo = 0;
    shown(scene.name);
    // It has a light of its own.
    Object.assign(state, { probe: true, sky: 'none', words: '' });
    panel.show();
    changed('light');
    return own;
  },
  async probe(file) {
    await viewer.openProbe(file);
    // What is dropped is meant to be seen; beside it the sky goes down.
    Object.assign(state, { probe: true, sky: 'none', background: 'light' });
    complain('');
    panel.show();
    changed('light');
  },
  fault(what) {
    open('');
    fault(what);
  },
};

function act(id: string, action: () => void) {
  element(id).addEventListener('click', action);
}

function listenToButtons() {
  act('all', () => void viewer.seeAll().then(() => changed('frame')));
  act('capture', () => {
    const link = document.createElement('a');
    link.download = `${(element('name').textContent ?? 'ylm').replace(/\.[^.]*$/, '')}.png`;
    link.href = viewer.capture();
    link.click();
  });
  act('share', () => {
    void navigator.clipboard.writeText(location.href).then(
      () => tell('The address of this view is copied.'),
      () => tell('The address bar holds this view: copy it from there.'),
    );
  });
  act('show-demo', () => void showDemo(DEMO_RAYS));
}

async function begin() {
  viewer.onFault = (what) => {
    fault(what);
    panel.show();
  };
  viewer.onScene = () => {
    document.body.classList.add('open');
    open('');
  };
  viewer.onFrame = report;
  viewer.onLight = () => {
    panel.show();
    panel.showEnergies();
  };
  panel.onChange = (change) => {
    complain('');
    changed(change);
    panel.showEnergies();
  };
  viewer.navigation.onMove = () => {
    state.eye = viewer.navigation.numbers.map((x) => x.toPrecision(5)).join(',');
    const isSeen = viewer.geometry?.moving?.hasMaterials ?? [state.shading, state.against].some((name) => ['glossy', 'adaptive'].includes(name));
    changed(isSeen ? 'frame' : 'picture');
  };
  viewer.moving.onMove = () => {
    viewer.moved();
    panel.show();
    // An address that changes with every picture is refused by browsers.
    if (viewer.moving.isPlaying) viewer.changed('frame');
    else changed('frame');
  };
  viewer.navigation.onTurnLight = (turn, tilt) => {
    const tenth = (degrees: number) => Math.round(10 * degrees) / 10;
    state.turn = tenth(((state.turn + turn + 540) % 360) - 180);
    state.tilt = tenth(Math.max(-90, Math.min(90, state.tilt + tilt)));
    panel.show();
    changed('frame');
  };
  listen(taker);
  listenToButtons();
  listenToMessages();
  panel.show();

  const served = await given();
  if (!served) return state.demo > 0 ? showDemo(Math.min(Math.round(state.demo), MOST_RAYS)) : open('');
  open(`Opening ${served.name}…`);
  if (!isShared && (served.light || served.probe)) Object.assign(state, { sky: 'none', words: served.light });
  const wanted = { ...state };
  await takeGiven(served, taker);
  // A shared address says what shines, not what was opened last.
  const { probe, sky, words, background } = wanted;
  if (isShared && (!viewer.geometry?.moving || saysSky)) Object.assign(state, { probe, sky, words, background });
  else if (!isShared && viewer.geometry?.moving && words) Object.assign(state, { probe: false, words });
  else return;
  panel.show();
  changed('light');
}

void begin();
