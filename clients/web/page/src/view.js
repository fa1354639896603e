// What is seen: the canvas, its light, and the camera, which turns about the body and keeps its share of
// the window when that changes.
import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

const GROUND = { light: 0xeef1f4, dark: 0x12181e };
const WHENCE = new THREE.Vector3(-0.55, -0.75, 0.62).normalize();
const STEEPEST = 0.05; // rad from the axis

export const canDraw = () => document.createElement('canvas').getContext('webgl2') !== null;

export class View {
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(35, 1, 0.001, 10);
    this.orbit = new OrbitControls(this.camera, canvas);
    this.orbit.enableDamping = true;
    this.raycaster = new THREE.Raycaster();
    this.frames = 0;
    this.seen = []; // what the picture shows, in numbers: state()
    canvas.addEventListener('webglcontextrestored', () => { this.seen = []; });
    this.light();
    const dark = matchMedia('(prefers-color-scheme: dark)');
    const paint = () => { this.scene.background = new THREE.Color(dark.matches ? GROUND.dark : GROUND.light); };
    dark.addEventListener('change', paint);
    paint();
    new ResizeObserver(() => this.fit()).observe(canvas.parentElement);
    this.fit();
  }

  // From the eye's own place, so that every side is lit as it is turned to; without a hue, which would
  // be taken for a value's.
  light() {
    const sun = new THREE.DirectionalLight(0xffffff, 1.9), fill = new THREE.DirectionalLight(0xffffff, 0.9);
    sun.position.set(-0.6, 1, 0.6);
    fill.position.set(1, -0.2, 0.8);
    this.camera.add(sun, fill);
    this.scene.add(this.camera, new THREE.HemisphereLight(0xffffff, 0xa8a8a8, 1.9));
  }

  // How far the eye is from a body of radius 1 that fills the window.
  distance() {
    return 1.2 / Math.sin((Math.PI / 360) * this.camera.fov) / Math.min(1, this.camera.aspect);
  }

  frame({ center, radius }) {
    const distance = radius * this.distance();
    this.orbit.target.copy(center);
    this.camera.up.set(0, 0, 1);
    this.camera.position.copy(center).addScaledVector(WHENCE, distance);
    this.orbit.minDistance = 0.2 * radius;
    this.orbit.maxDistance = 5 * distance;
    this.camera.near = distance / 200;
    this.camera.far = distance * 20;
    this.camera.updateProjectionMatrix();
    this.orbit.update();
  }

  fit() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    const before = this.distance();
    this.renderer.setPixelRatio(Math.min(devicePixelRatio || 1, 2));
    this.renderer.setSize(width, height, false);
    this.seen = []; // and empty
    this.camera.aspect = width / Math.max(1, height);
    this.camera.updateProjectionMatrix();
    this.zoom(before / this.distance());
  }

  turn(across, up) {
    const offset = this.camera.position.clone().sub(this.orbit.target);
    const place = new THREE.Spherical().setFromVector3(new THREE.Vector3(offset.y, offset.z, offset.x));
    place.theta += across;
    place.phi = Math.max(STEEPEST, Math.min(Math.PI - STEEPEST, place.phi + up));
    const turned = new THREE.Vector3().setFromSpherical(place);
    this.camera.position.copy(this.orbit.target).add(new THREE.Vector3(turned.z, turned.x, turned.y));
  }

  // Nearer by a factor.
  zoom(factor) {
    this.camera.position.sub(this.orbit.target).divideScalar(factor).add(this.orbit.target);
  }

  direction() {
    return this.camera.getWorldDirection(new THREE.Vector3());
  }

  // The ray through a place of the canvas, in pixels from its upper left corner.
  ray([x, y]) {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    this.raycaster.setFromCamera(new THREE.Vector2((2 * x) / width - 1, 1 - (2 * y) / height), this.camera);
    return this.raycaster;
  }

  // All that a picture depends on: places, the versions of what is in buffers, paints, light and eye.
  state() {
    const { scene, camera } = this, out = [scene.background.getHex(), ...camera.projectionMatrix.elements];
    scene.updateMatrixWorld();
    scene.traverseVisible(({ id, matrixWorld, geometry, material }) => {
      out.push(id, ...matrixWorld.elements);
      if (geometry === undefined) return;
      const { attributes, index } = geometry;
      out.push(geometry.id, index === null ? 0 : index.version, ...Object.values(attributes).map(({ version }) => version));
      out.push(material.id, material.version, material.opacity, material.color === undefined ? 0 : material.color.getHex());
    });
    return out;
  }

  // A frame of the page. A picture that would be the last one is not made again.
  draw() {
    this.orbit.update();
    const state = this.state();
    if (state.length !== this.seen.length || state.some((value, i) => value !== this.seen[i])) {
      this.renderer.render(this.scene, this.camera);
      this.seen = state;
    }
    ++this.frames;
  }
}
