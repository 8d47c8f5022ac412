/** What is drawn: the mesh with a radiance at each point, up to twice side by side, and the light behind it. WebGL2 through three.js. */
import {
  BufferAttribute, BufferGeometry, Color, DataTexture, FloatType, GLSL3, LinearFilter, Matrix3, Matrix4, Mesh, NearestFilter, PerspectiveCamera,
  PlaneGeometry, RGBAFormat, Raycaster, RepeatWrapping, Scene, ShaderMaterial, UnsignedByteType, Vector2, Vector3, WebGLRenderer, type Quaternion, type Ray,
} from 'three';
import { PAST, SHOWN, SKY_FRAGMENT, SKY_VERTEX, SURFACE_FRAGMENT, SURFACE_VERTEX, TONE_MAPS } from './shaders';

/** Vertical field of view of `ylm render`, in degrees. */
const FIELD_OF_VIEW = 35;

/** What a number at each point stands for. */
export type Shown = (typeof SHOWN)[number];

/** How a picture is drawn. */
export interface Picture {
  gain: number;
  tone: string;
  lightRotation: Quaternion;
  /** What is seen past the model: the light, a studio, or black. */
  background: 'light' | 'studio' | 'black';
  /** Where the second side begins, 0 to 1; 1 for none. */
  wipe: number;
}

/** What false colours of negative radiance stand for: the last of the reds, negative or 0 where nothing is below, and white. */
export interface Scale {
  lowest: number;
  white: number;
}

/** One side: all points by one shading. */
class Side {
  readonly material: ShaderMaterial;
  readonly mesh: Mesh<BufferGeometry, ShaderMaterial>;
  shown: Shown = 'radiance';

  constructor(shared: ShaderMaterial['uniforms']) {
    const uniforms = { ...shared, shown: { value: 0 }, white: { value: 1 }, lowest: { value: -1 } };
    const sources = { vertexShader: SURFACE_VERTEX, fragmentShader: SURFACE_FRAGMENT };
    this.material = new ShaderMaterial({ glslVersion: GLSL3, uniforms, ...sources, side: 2 });
    this.mesh = new Mesh(new BufferGeometry(), this.material);
    this.mesh.frustumCulled = false;
  }

  setGeometry(positions: BufferAttribute, triangles: BufferAttribute) {
    this.mesh.geometry.dispose();
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', positions);
    geometry.setAttribute('radiance', new BufferAttribute(new Float32Array(3 * positions.count), 3));
    geometry.setIndex(triangles);
    this.mesh.geometry = geometry;
  }

  /** Answers what negative radiance is scaled by. */
  setRadiance(radiance: Float32Array, shown: Shown): Scale | null {
    const attribute = this.mesh.geometry.getAttribute('radiance') as BufferAttribute;
    (attribute.array as Float32Array).set(radiance);
    attribute.needsUpdate = true;
    const { uniforms } = this.material;
    uniforms['shown']!.value = SHOWN.indexOf(shown);
    this.shown = shown;
    if (shown !== 'negative') return null;
    // White at four times the mean luminance, as `ylm render --shading negative`.
    let [lowest, sum] = [0, 0];
    for (let i = 0; i < radiance.length; i += 3) {
      const [r, g, b] = [radiance[i]!, radiance[i + 1]!, radiance[i + 2]!];
      lowest = Math.min(lowest, r, g, b);
      sum += 0.2126 * r + 0.7152 * g + 0.0722 * b;
    }
    const mean = sum / Math.max(radiance.length / 3, 1);
    const scale = { lowest, white: mean > 0 ? 4 * mean : 1 };
    uniforms['white']!.value = scale.white;
    uniforms['lowest']!.value = lowest < 0 ? lowest : -1;
    return scale;
  }
}

export class Stage {
  readonly camera = new PerspectiveCamera(FIELD_OF_VIEW, 1, 0.01, 100);
  readonly center = new Vector3();
  radius = 1;
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly shared = { gain: { value: 1 }, toneMap: { value: 0 }, scales: { value: null as DataTexture | null } };
  private readonly sides = [new Side(this.shared), new Side(this.shared)] as const;
  private readonly sky: Mesh<PlaneGeometry, ShaderMaterial>;
  private isEmpty = true;

  constructor(private readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    const uniforms = {
      ...this.shared, past: { value: 0 }, aspect: { value: 1 }, light: { value: null }, worldFromClip: { value: new Matrix4() }, eye: { value: new Vector3() }, lightFromWorld: { value: new Matrix3() },
    };
    const sources = { vertexShader: SKY_VERTEX, fragmentShader: SKY_FRAGMENT };
    this.sky = new Mesh(new PlaneGeometry(2, 2), new ShaderMaterial({ glslVersion: GLSL3, uniforms, ...sources, depthTest: false, depthWrite: false }));
    this.sky.frustumCulled = false;
    this.sky.renderOrder = -1;
    this.scene.add(this.sky, ...this.sides.map((side) => side.mesh));
  }

  setGeometry(positions: Float32Array, triangles: Uint32Array) {
    const attributes = [new BufferAttribute(positions, 3), new BufferAttribute(triangles, 1)] as const;
    for (const side of this.sides) side.setGeometry(...attributes);
    const { geometry } = this.sides[0].mesh;
    geometry.computeBoundingBox();
    geometry.computeBoundingSphere();
    geometry.boundingBox!.getCenter(this.center);
    this.radius = geometry.boundingSphere!.radius || 1;
    this.isEmpty = false;
  }

  /** Moves the points. */
  setPositions(positions: Float32Array) {
    // Both sides have the same.
    const { geometry } = this.sides[0].mesh;
    const attribute = geometry.getAttribute('position') as BufferAttribute;
    (attribute.array as Float32Array).set(positions);
    attribute.needsUpdate = true;
    geometry.computeBoundingSphere();
  }

  /** The ray from the eye through a place of the canvas, in pixels. */
  ray(x: number, y: number): Ray {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const caster = new Raycaster();
    caster.setFromCamera(new Vector2((2 * x) / width - 1, 1 - (2 * y) / height), this.camera);
    return caster.ray;
  }

  /** The triangle that a ray meets first, and where. */
  hit(ray: Ray): { triangle: number; point: Vector3 } | undefined {
    const found = new Raycaster(ray.origin, ray.direction).intersectObject(this.sides[0].mesh)[0];
    return found && { triangle: found.faceIndex!, point: found.point };
  }

  setRadiance(side: 0 | 1, radiance: Float32Array, shown: Shown): Scale | null {
    return this.sides[side].setRadiance(radiance, shown);
  }

  /** Takes the colours of false-colour pictures, [scale, 256, 3]: those of negative values, and of heat. */
  setScales(colours: Uint8Array) {
    const texels = new Uint8Array((colours.length / 3) * 4).fill(255);
    for (let i = 0; i < colours.length / 3; i++) texels.set(colours.subarray(3 * i, 3 * i + 3), 4 * i);
    this.shared.scales.value?.dispose();
    const texture = new DataTexture(texels, 256, texels.length / 1024, RGBAFormat, UnsignedByteType);
    texture.needsUpdate = true;
    this.shared.scales.value = texture;
  }

  /** A lat-long picture, `width` wide and half as high. */
  setSky(picture: Float32Array, width: number) {
    const texels = new Float32Array((picture.length / 3) * 4);
    for (let i = 0; i < picture.length / 3; i++) texels.set(picture.subarray(3 * i, 3 * i + 3), 4 * i);
    const { uniforms } = this.sky.material;
    (uniforms['light']!.value as DataTexture | null)?.dispose();
    const texture = new DataTexture(texels, width, width / 2, RGBAFormat, FloatType);
    const filter = this.renderer.extensions.has('OES_texture_float_linear') ? LinearFilter : NearestFilter;
    [texture.minFilter, texture.magFilter, texture.wrapS] = [filter, filter, RepeatWrapping];
    texture.needsUpdate = true;
    uniforms['light']!.value = texture;
  }

  /** Fits the canvas to its place; whether there is any. */
  resize(): boolean {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement!;
    if (width === 0 || height === 0) return false;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    return true;
  }

  draw({ gain, tone, lightRotation, background, wipe }: Picture) {
    if (this.isEmpty) return;
    const { camera, sky } = this;
    const distance = camera.position.distanceTo(this.center);
    camera.near = Math.max(distance - 2 * this.radius, 1e-3 * this.radius);
    camera.far = distance + 4 * this.radius;
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
    this.shared.gain.value = gain;
    this.shared.toneMap.value = Math.max(0, TONE_MAPS.indexOf(tone));
    const { uniforms } = sky.material;
    uniforms['aspect']!.value = camera.aspect;
    (uniforms['worldFromClip']!.value as Matrix4).copy(camera.matrixWorld).multiply(camera.projectionMatrixInverse);
    (uniforms['eye']!.value as Vector3).copy(camera.position);
    const lightFromWorld = new Matrix4().makeRotationFromQuaternion(lightRotation.clone().invert());
    (uniforms['lightFromWorld']!.value as Matrix3).setFromMatrix4(lightFromWorld);

    const { clientWidth: width, clientHeight: height } = this.canvas;
    const middle = Math.round(wipe * width);
    this.renderer.setClearColor(new Color(0), 1);
    this.renderer.setScissorTest(true);
    for (const [index, side] of this.sides.entries()) {
      const [start, end] = index === 0 ? [0, middle] : [middle, width];
      if (end <= start) continue;
      this.sides.forEach((other) => (other.mesh.visible = other === side));
      const past = side.shown === 'radiance' ? background : 'ground';
      sky.visible = past !== 'black' && (past !== 'light' || uniforms['light']!.value !== null);
      uniforms['past']!.value = past === 'black' ? 0 : PAST.indexOf(past);
      this.renderer.setScissor(start, 0, end - start, height);
      this.renderer.render(this.scene, camera);
    }
    this.renderer.setScissorTest(false);
  }
}
