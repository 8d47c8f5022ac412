/** How radiance is shown. Tone maps are those of `ylm render`: crates/ylm-prt/src/render/tonemap.rs. */

export const TONE_MAPS = ['none', 'reinhard', 'aces', 'agx', 'neutral'];
export const SHOWN = ['radiance', 'negative', 'reach'] as const;

const DISPLAY = /* glsl */ `
uniform float gain;
uniform int toneMap;

const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722);

vec3 aces(vec3 colour) {
  const mat3 INPUT = mat3(0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777);
  const mat3 OUTPUT = mat3(1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605, 1.07602);
  vec3 v = min(INPUT * colour, vec3(1e6));
  return OUTPUT * ((v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.432951) + 0.238081));
}

vec3 agx(vec3 colour) {
  const mat3 INSET = mat3(0.84247906, 0.042328242, 0.042375654, 0.0784336, 0.8784686, 0.0784336, 0.079223745, 0.07916613, 0.879143);
  const mat3 OUTSET = mat3(1.196879, -0.05289685, -0.052971635, -0.09802088, 1.1519031, -0.09804345, -0.09902974, -0.09896118, 1.1510737);
  vec3 stops = log2(max(INSET * colour, vec3(1e-10)));
  vec3 x = clamp((stops + 12.47393) / 16.499999, 0.0, 1.0);
  vec3 s = ((((((15.5 * x - 40.14) * x + 31.96) * x - 6.868) * x + 0.4298) * x + 0.1191) * x - 0.00232);
  return pow(max(OUTSET * s, vec3(0.0)), vec3(2.2));
}

vec3 neutral(vec3 colour) {
  const float START = 0.8 - 0.04;
  float least = min(colour.r, min(colour.g, colour.b));
  colour -= least < 0.08 ? least - 6.25 * least * least : 0.04;
  float peak = max(colour.r, max(colour.g, colour.b));
  if (peak < START) return colour;
  float room = 1.0 - START;
  float lowered = 1.0 - room * room / (peak + room - START);
  float white = 1.0 - 1.0 / (0.15 * (peak - lowered) + 1.0);
  return mix(colour * (lowered / peak), vec3(lowered), white);
}

vec3 encode(vec3 colour) {
  colour = clamp(colour, 0.0, 1.0);
  return mix(1.055 * pow(colour, vec3(1.0 / 2.4)) - 0.055, 12.92 * colour, vec3(lessThanEqual(colour, vec3(0.0031308))));
}

vec3 display(vec3 radiance) {
  vec3 colour = max(gain * radiance, vec3(0.0));
  if (toneMap == 1) colour /= 1.0 + dot(colour, LUMINANCE);
  else if (toneMap == 2) colour = aces(colour);
  else if (toneMap == 3) colour = agx(colour);
  else if (toneMap == 4) colour = neutral(colour);
  return encode(colour);
}
`;

export const SURFACE_VERTEX = /* glsl */ `
in vec3 radiance;
out vec3 shaded;
void main() {
  shaded = radiance;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;

/** Radiance as it is shown; or grey with ColorBrewer's OrRd where a channel is below 0; or a number from 0 to 1 in inferno's colours. */
export const SURFACE_FRAGMENT = /* glsl */ `
in vec3 shaded;
out vec4 colour;
uniform int shown;
uniform float white;
uniform float lowest;
${DISPLAY}
vec3 scale(vec3 stops[6], float at) {
  float x = 5.0 * clamp(at, 0.0, 1.0);
  int i = min(int(x), 4);
  return mix(stops[i], stops[i + 1], x - float(i));
}
void main() {
  vec3 code;
  if (shown == 1) {
    float least = min(shaded.r, min(shaded.g, shaded.b));
    const vec3 NEGATIVE[6] = vec3[](vec3(0.992, 0.784, 0.588), vec3(0.990, 0.636, 0.424), vec3(0.966, 0.478, 0.320), vec3(0.878, 0.285, 0.200), vec3(0.717, 0.080, 0.060), vec3(0.498, 0.0, 0.0));
    code = least < 0.0 ? scale(NEGATIVE, least / lowest) : encode(vec3(dot(shaded, LUMINANCE) / white));
  } else if (shown == 2) {
    const vec3 HEAT[6] = vec3[](vec3(0.001, 0.0, 0.014), vec3(0.258, 0.039, 0.406), vec3(0.578, 0.148, 0.404), vec3(0.865, 0.317, 0.226), vec3(0.988, 0.645, 0.040), vec3(0.988, 1.0, 0.645));
    code = scale(HEAT, shaded.r);
  } else code = display(shaded);
  colour = vec4(code, 1.0);
}`;

export const SKY_VERTEX = /* glsl */ `
out vec4 far;
uniform mat4 worldFromClip;
void main() {
  far = worldFromClip * vec4(position.xy, 1.0, 1.0);
  gl_Position = vec4(position.xy, 1.0, 1.0);
}`;

export const SKY_FRAGMENT = /* glsl */ `
in vec4 far;
out vec4 colour;
uniform sampler2D light;
uniform vec3 eye;
uniform mat3 lightFromWorld;
${DISPLAY}
void main() {
  vec3 d = lightFromWorld * normalize(far.xyz / far.w - eye);
  float u = atan(-d.z, d.x) / 6.283185307;
  float v = acos(clamp(d.y, -1.0, 1.0)) / 3.141592654;
  colour = vec4(display(textureLod(light, vec2(u, v), 0.0).rgb), 1.0);
}`;
