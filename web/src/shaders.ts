/** How radiance is shown. Tone maps are those of `ylm render`: crates/ylm-prt/src/render/tonemap.rs. */

export const TONE_MAPS = ['none', 'reinhard', 'aces', 'agx', 'neutral'];
export const SHOWN = ['radiance', 'negative', 'reach'] as const;
/** What is seen past the model. */
export const PAST = ['light', 'studio', 'ground'] as const;

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

/** Radiance as it is shown; or grey with colours of magnitude where a channel is below 0; or a number from 0 to 1 in colours of heat. */
export const SURFACE_FRAGMENT = /* glsl */ `
in vec3 shaded;
out vec4 colour;
uniform int shown;
uniform float white;
uniform float lowest;
// [scale, 256] of ylm-prt's render::{negative_colour, heat_colour}.
uniform sampler2D scales;
${DISPLAY}
vec3 scale(int row, float at) {
  return texelFetch(scales, ivec2(int(255.0 * clamp(at, 0.0, 1.0) + 0.5), row), 0).rgb;
}
void main() {
  vec3 code;
  if (shown == 1) {
    float least = min(shaded.r, min(shaded.g, shaded.b));
    code = least < 0.0 ? scale(0, least / lowest) : encode(vec3(dot(shaded, LUMINANCE) / white));
  } else if (shown == 2) code = scale(1, shaded.r);
  else code = display(shaded);
  colour = vec4(code, 1.0);
}`;

export const SKY_VERTEX = /* glsl */ `
out vec4 far;
out vec2 place;
uniform mat4 worldFromClip;
void main() {
  place = position.xy;
  far = worldFromClip * vec4(position.xy, 1.0, 1.0);
  gl_Position = vec4(position.xy, 1.0, 1.0);
}`;

/** What is seen past the model: the light, a quiet grey that is darker towards the rim, or the ground of false colours. */
export const SKY_FRAGMENT = /* glsl */ `
in vec4 far;
in vec2 place;
out vec4 colour;
uniform int past;
uniform float aspect;
uniform sampler2D light;
uniform vec3 eye;
uniform mat3 lightFromWorld;
${DISPLAY}
vec3 studio() {
  float rim = smoothstep(0.0, 1.5, length((place - vec2(0.0, 0.1)) * vec2(min(aspect, 1.6), 1.0)));
  vec3 code = encode(mix(vec3(0.080, 0.083, 0.091), vec3(0.021, 0.022, 0.026), rim));
  // Half a code of noise: so slow a gradient would show its steps.
  return code + (fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5) / 255.0;
}
void main() {
  vec3 code = past == 1 ? studio() : encode(vec3(0.02));
  if (past == 0) {
    vec3 d = lightFromWorld * normalize(far.xyz / far.w - eye);
    float u = atan(-d.z, d.x) / 6.283185307;
    float v = acos(clamp(d.y, -1.0, 1.0)) / 3.141592654;
    code = display(textureLod(light, vec2(u, v), 0.0).rgb);
  }
  colour = vec4(code, 1.0);
}`;
