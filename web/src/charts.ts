/** Numbers that are drawn: the energies of the light's bands, and what false colours stand for. */
import { element } from './page';
import type { Report } from './viewer';

/** More bands than this stand without their numbers. */
const NUMBERED = 12;
/** Colours of a scale that a legend is made of; between them it is linear. */
const STOPS = 16;

/** A bar for each band, as high as the root of its energy; those that are used in colour. */
export function showEnergies(energies: Float32Array, usedBands: number) {
  const chart = element('energies');
  const largest = Math.max(...energies, 1e-30);
  const columns = Array.from(energies, (energy, band) => {
    const column = document.createElement('span');
    const bar = document.createElement('i');
    bar.style.height = `${100 * Math.sqrt(energy / largest)}%`;
    column.append(bar);
    if (energies.length <= NUMBERED) column.append(String(band));
    column.className = band < usedBands ? '' : 'off';
    column.title = `band ${band}: ${energy.toPrecision(3)}`;
    return column;
  });
  chart.replaceChildren(...columns);
  chart.classList.toggle('many', energies.length > NUMBERED);
  const said = columns.slice(0, NUMBERED).map((column) => column.title).join(', ');
  chart.setAttribute('aria-label', `Energy of the light's bands, bars by its root. ${said}`);
}

/** The band whose bar is at a place across the chart. */
export function bandAt(x: number): number {
  const chart = element('energies');
  const { left, width } = chart.getBoundingClientRect();
  return Math.min(Math.max(Math.floor(((x - left) / width) * chart.childElementCount), 0), chart.childElementCount - 1);
}

/** The stops of a gradient from the first colour of a scale to the last, or the other way round. */
function stopsOf(scales: Uint8Array, row: number, isReversed: boolean, [from, to]: [number, number]): string[] {
  return Array.from({ length: STOPS }, (_, i) => {
    const at = Math.round((255 * (isReversed ? STOPS - 1 - i : i)) / (STOPS - 1));
    const [r, g, b] = scales.subarray(3 * (256 * row + at));
    return `rgb(${r} ${g} ${b}) ${from + ((to - from) * i) / (STOPS - 1)}%`;
  });
}

const short = (value: number) => value.toPrecision(2).replace('-', '−');

/** What the colours of a frame stand for, where they stand for numbers. */
export function showLegend(legend: Report['legend'], scales: Uint8Array, baseBands: number) {
  element('legend').hidden = legend === null;
  if (!legend) return;
  let [stops, marks, text]: [string[], string[], string] = [[], [], ''];
  if (legend.shown === 'reach') {
    stops = stopsOf(scales, 1, false, [0, 100]);
    marks = [`${baseBands} bands`, 'all'];
    text = 'Bands computed';
  } else {
    const { lowest, white } = legend.scale;
    const isBelow = lowest < 0;
    const grey = ['#000', '#777', '#fff'].map((colour, i) => `${colour} ${isBelow ? 50 + 25 * i : 50 * i}%`);
    stops = [...(isBelow ? stopsOf(scales, 0, true, [0, 50]) : []), ...grey];
    marks = isBelow ? [short(lowest), '0', short(white)] : ['0', short(white)];
    text = isBelow ? 'Radiance below 0, luminance above' : 'Luminance; nothing is negative';
  }
  element('ramp').style.background = `linear-gradient(90deg, ${stops.join(', ')})`;
  element('marks').replaceChildren(...marks.map((mark) => Object.assign(document.createElement('span'), { textContent: mark })));
  element('legend-text').textContent = text;
}
