/** The light of a state, in the words of the command line. */
import type { State } from './state';

/** The sun rises at 6 in the east, +x, stands 60° high in the south, +z, at 12, and sets at 18; elevation and azimuth in degrees. */
export function sunOf(hour: number): [elevation: number, azimuth: number] {
  const turn = ((hour - 12) / 12) * Math.PI;
  const noon = Math.PI / 3;
  const elevation = Math.asin(Math.sin(noon) * Math.cos(turn));
  const azimuth = Math.atan2(-Math.sin(turn), Math.cos(turn) * Math.cos(noon));
  return [(Math.max(elevation, 0) * 180) / Math.PI, (azimuth * 180) / Math.PI];
}

const factor = (stops: number) => Number((2 ** stops).toPrecision(6));

/** A clear sky is blue, the others are as grey as clouds; the sun of a hazy or cloudy one is that much weaker. */
const SKY_COLOUR: Record<string, string> = { clear: '0.7,0.85,1.12', intermediate: '0.85,0.93,1.05' };
const SUN_SHARE: Record<string, number> = { clear: 1, intermediate: 0.5, cloudy: 0.2 };
/** Irradiance by the sun above the air, where the sky alone gives the ground π. */
const SUN_IRRADIANCE = 2.6 * Math.PI;
/** Optical depth of the air straight up, by colour: what makes a low sun red. */
const AIR = [0.05, 0.19, 0.42];

/** What is left of the sun's light at an elevation in degrees; the air's mass by [Kasten & Young 1989]. */
function sunColour(elevation: number): number[] {
  const mass = 1 / (Math.sin((elevation * Math.PI) / 180) + 0.50572 * (elevation + 6.07995) ** -1.6364);
  return AIR.map((depth) => Math.exp(-depth * mass));
}

/** Whether a sky has a sun in it. */
export const hasSun = (sky: string) => sky in SUN_SHARE;

/** The sun is as wide as `bands` bands can hold: a smaller one only makes them ring, and its shadows are no sharper. */
const sunAngle = (bands: number) => Math.max(90 / bands, 1);

function sunWords(state: State, bands: number): string {
  const [elevation, azimuth] = sunOf(state.hour);
  const [e, a] = [(elevation * Math.PI) / 180, (azimuth * Math.PI) / 180];
  const direction = [Math.cos(e) * Math.sin(a), Math.sin(e), Math.cos(e) * Math.cos(a)].map((x) => x.toFixed(5));
  const colour = sunColour(elevation).map((x) => x.toFixed(4));
  const angle = Number(sunAngle(bands).toFixed(2));
  const radiance = SUN_IRRADIANCE / (Math.PI * Math.sin((angle * Math.PI) / 180) ** 2);
  const intensity = Number((radiance * SUN_SHARE[state.sky]! * factor(state.skyStops)).toPrecision(6));
  return `disc?dir=${direction.join(',')}&angle=${angle}&intensity=${intensity}&color=${colour.join(',')}`;
}

/** The words of all that shines but the probe, for a scene of so many bands; empty if nothing does. */
export function wordsOf(state: State, bands: number): string {
  const parts: string[] = [];
  const intensity = `intensity=${factor(state.skyStops)}`;
  if (state.sky === 'white') parts.push(`white?${intensity}`);
  else if (state.sky === 'overcast') parts.push(`sky:overcast?${intensity}`);
  else if (state.sky !== 'none') {
    const sun = sunOf(state.hour).map((degrees) => degrees.toFixed(2));
    const colour = SKY_COLOUR[state.sky];
    parts.push(`sky:${state.sky}?sun=${sun.join(',')}&${intensity}${colour ? `&color=${colour}` : ''}`);
    if (state.sun) parts.push(sunWords(state, bands));
  }
  if (state.disc) {
    const height = (state.height * Math.PI) / 180;
    const direction = [0.6 * Math.cos(height), Math.sin(height), 0.8 * Math.cos(height)].map((x) => x.toFixed(5));
    parts.push(`disc?dir=${direction.join(',')}&angle=${state.angle}&intensity=${factor(state.discStops)}`);
  }
  if (state.words.trim() !== '') parts.push(state.words.trim());
  return parts.join('+');
}

/** How many times over the probe shines. */
export const probeGainOf = (state: State) => (state.probe ? factor(state.probeStops) : 0);
