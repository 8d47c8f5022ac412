/** The page: its state, the viewer, and the controls of both. */
import { given, listen, takeGiven, type Taker } from './files';
import { element, Panel } from './panel';
import { fragmentOf, stateOf } from './state';
import { Viewer, type Change, type Report } from './viewer';

const state = stateOf(location.hash);
const isShared = location.hash.length > 1;
const viewer = new Viewer(state, element<HTMLCanvasElement>('view'));
const panel = new Panel(state, viewer);

function say(text: string) {
  const message = element('message');
  element('message-text').textContent = text;
  message.hidden = text === '';
}

const fault = (what: unknown) => say(what instanceof Error ? what.message : String(what));

function changed(change: Change) {
  viewer.changed(change);
  history.replaceState(null, '', `#${fragmentOf(state)}`);
}

const number = (value: number) => value.toLocaleString('en');

function tell({ lit, isOnGpu, milliseconds }: Report) {
  const { geometry } = viewer;
  if (!geometry) return;
  const shading = lit.reduce((sum, part) => sum + part.milliseconds, 0);
  const spared = lit.find((part) => part.filtered.length > 0)?.filtered.map((part) => `${Math.round(100 * part)} %`);
  element('shape').textContent = `${number(geometry.positions.length / 3)} points, ${number(geometry.triangles.length / 3)} triangles, ${geometry.bands} bands, ${geometry.transfer}`;
  element('time').textContent = `Relit ${isOnGpu ? 'by the GPU ' : ''}in ${shading.toFixed(1)} ms, drawn after ${milliseconds.toFixed(1)} ms`;
  element('spared').textContent = spared ? `Spared by the filter: diffuse ${spared[0]}, specular ${spared[1]} of the points` : '';
  // For tests: how many frames there were.
  document.documentElement.dataset['frames'] = String(Number(document.documentElement.dataset['frames'] ?? 0) + 1);
}

const taker: Taker = {
  async scene(file) {
    await viewer.openScene(file);
    element('name').textContent = file.name;
    document.title = `${file.name} · ylm`;
    element('empty').hidden = true;
    document.body.classList.add('open');
    say('');
    panel.show();
  },
  async probe(file) {
    await viewer.openProbe(file);
    // What is dropped is meant to be seen; beside it the sky goes down.
    Object.assign(state, { probe: true, sky: 'none' });
    say('');
    panel.show();
    changed('light');
  },
  fault,
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
      () => say('The address of this view is copied.'),
      () => say('The address bar holds this view: copy it from there.'),
    );
  });
  act('dismiss', () => say(''));
}

async function begin() {
  viewer.onFault = (what) => {
    fault(what);
    panel.show();
  };
  viewer.onFrame = tell;
  viewer.onLight = () => {
    panel.show();
    panel.showEnergies();
  };
  panel.onChange = (change) => {
    say('');
    changed(change);
    panel.showEnergies();
  };
  viewer.navigation.onMove = () => {
    state.eye = viewer.navigation.numbers.map((x) => x.toPrecision(5)).join(',');
    const isSeen = [state.shading, state.against].some((name) => ['glossy', 'adaptive'].includes(name));
    changed(isSeen ? 'frame' : 'picture');
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
  panel.show();

  const served = await given();
  if (!served) return;
  if (!isShared && (served.light || served.probe)) Object.assign(state, { sky: 'none', words: served.light });
  const wanted = { ...state };
  await takeGiven(served, taker);
  // A shared address says what shines, not what was opened last.
  if (isShared) {
    Object.assign(state, { probe: wanted.probe, sky: wanted.sky });
    panel.show();
    changed('light');
  }
}

void begin();
