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

/** The words of all that shines but the probe; empty if nothing does. */
export function wordsOf(state: State): string {
  const parts: string[] = [];
  const intensity = `intensity=${factor(state.skyStops)}`;
  if (state.sky === 'white') parts.push(`white?${intensity}`);
  else if (state.sky === 'overcast') parts.push(`sky:overcast?${intensity}`);
  else if (state.sky !== 'none') {
    const sun = sunOf(state.hour).map((degrees) => degrees.toFixed(2));
    parts.push(`sky:${state.sky}?sun=${sun.join(',')}&${intensity}`);
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
