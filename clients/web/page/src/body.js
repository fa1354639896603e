// The deforming body: positions from counts, smooth normals, a colour per node, its edges, its rest
// shape as a ghost and its fixed nodes.
import * as THREE from 'three';
import { paint } from './colours.js';
import { splitCreases } from './creases.js';

const SHARP_DEGREES = 40, PIN_SHARE = 0.004;
const TISSUE = new THREE.Color(0xb5574a);

// A round dot to be drawn as a point, seen on every colour.
function dot() {
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = 64;
  const context = canvas.getContext('2d');
  for (const [colour, radius] of [['#ffffff', 26], ['#2f6fb0', 18]]) {
    context.fillStyle = colour;
    context.beginPath();
    context.arc(32, 32, radius, 0, 2 * Math.PI);
    context.fill();
  }
  const texture = new THREE.CanvasTexture(canvas);
  texture.colorSpace = THREE.SRGBColorSpace;
  return texture;
}

// Seen where it turns away from the eye, so that what is behind or before it stays what it is.
function glass() {
  return new THREE.ShaderMaterial({
    transparent: true, depthWrite: false, uniforms: { colour: { value: new THREE.Color(0x6f8fb0) } },
    vertexShader: `varying vec3 n, v;
      void main() {
        vec4 place = modelViewMatrix * vec4(position, 1.0);
        n = normalMatrix * normal;
        v = -place.xyz;
        gl_Position = projectionMatrix * place;
      }`,
    fragmentShader: `uniform vec3 colour;
      varying vec3 n, v;
      void main() {
        float away = 1.0 - abs(dot(normalize(n), normalize(v)));
        gl_FragColor = vec4(colour, 0.04 + 0.75 * away * away * away);
        #include <colorspace_fragment>
      }`,
  });
}

export class Body extends THREE.Group {
  constructor() {
    super();
    this.material = new THREE.MeshStandardMaterial({
      color: 0xffffff, vertexColors: true, roughness: 0.42, metalness: 0.0, side: THREE.DoubleSide,
    });
    this.isPresent = false;
    this.colouring = 'none';
  }

  setTopology({ nodes, scale, rest, index, flag }) {
    for (const part of [...this.children]) {
      part.geometry.dispose();
      part.material.map?.dispose();
      if (part.material !== this.material) part.material.dispose();
      this.remove(part);
    }
    this.nodes = nodes;
    this.scaleOfCount = scale;
    this.restPosition = rest;
    this.count = new Int16Array(3 * nodes);
    this.value = new Float32Array(nodes); // of the colouring
    this.field = null;
    const split = splitCreases(rest, index, nodes, SHARP_DEGREES);
    const vertices = split.nodeOf.length, indices = new THREE.BufferAttribute(split.index, 1);
    this.nodeOf = split.nodeOf; // of a vertex
    const restOf = new Float32Array(3 * vertices);
    split.nodeOf.forEach((node, v) => restOf.set(rest.subarray(3 * node, 3 * node + 3), 3 * v));
    const attribute = () => new THREE.BufferAttribute(new Float32Array(3 * vertices), 3).setUsage(THREE.DynamicDrawUsage);
    this.geometry = new THREE.BufferGeometry();
    this.position3 = attribute();
    this.normal3 = attribute();
    this.colour3 = attribute();
    this.geometry.setIndex(indices);
    this.geometry.setAttribute('position', this.position3);
    this.geometry.setAttribute('normal', this.normal3);
    this.geometry.setAttribute('color', this.colour3);
    this.mesh = new THREE.Mesh(this.geometry, this.material);
    this.mesh.frustumCulled = false;

    const restGeometry = new THREE.BufferGeometry();
    restGeometry.setIndex(indices);
    restGeometry.setAttribute('position', new THREE.BufferAttribute(restOf, 3));
    restGeometry.computeVertexNormals();
    restGeometry.computeBoundingSphere();
    restGeometry.computeBoundingBox();
    this.ghost = new THREE.Mesh(restGeometry, glass());
    this.target = new THREE.Mesh(restGeometry); // for the pointer; never drawn
    this.edges = new THREE.Mesh(this.geometry, new THREE.MeshBasicMaterial({
      color: 0x202830, wireframe: true, transparent: true, opacity: 0.28,
    }));
    this.edges.frustumCulled = false;
    this.sphere = restGeometry.boundingSphere;
    this.diagonal = restGeometry.boundingBox.getSize(new THREE.Vector3()).length();
    const { min, max } = restGeometry.boundingBox;
    this.box = [...min.toArray(), ...max.toArray()].map((v) => v.toPrecision(5)).join(' ');
    this.fixed = this.makePins(restOf, restGeometry.attributes.normal.array, flag);
    this.add(this.mesh, this.ghost, this.edges, this.fixed);
    this.isPresent = true;
    this.isChanged = true;
    this.setColouring(this.colouring);
  }

  // A dot a little off the surface for each node that is held.
  makePins(restOf, normal, flag) {
    const place = [], isDone = new Set();
    this.nodeOf.forEach((node, v) => {
      if (!(flag[node] & 1) || isDone.has(node)) return;
      isDone.add(node);
      for (let d = 0; d < 3; ++d) place.push(restOf[3 * v + d] + PIN_SHARE * this.diagonal * normal[3 * v + d]);
    });
    const pins = new THREE.BufferGeometry();
    pins.setAttribute('position', new THREE.Float32BufferAttribute(place, 3));
    return new THREE.Points(pins, new THREE.PointsMaterial({
      size: 8, sizeAttenuation: false, map: dot(), transparent: true, depthWrite: false,
    }));
  }

  takeDelta({ node, displacement }) {
    if (!this.isPresent) return;
    for (let k = 0; k < node.length; ++k) {
      for (let d = 0; d < 3; ++d) this.count[3 * node[k] + d] = displacement[3 * k + d];
    }
    this.isChanged = true;
  }

  takeField(field) {
    this.field = field;
    this.isChanged = true;
  }

  setColouring(name) {
    this.colouring = name;
    this.isChanged = true;
  }

  computePositions() {
    const position = this.position3.array, rest = this.restPosition, count = this.count, scale = this.scaleOfCount;
    this.nodeOf.forEach((node, v) => {
      for (let d = 0; d < 3; ++d) position[3 * v + d] = rest[3 * node + d] + scale * count[3 * node + d];
    });
    this.position3.needsUpdate = true;
  }

  // Area-weighted normals at vertices: the sum of the cross products of their triangles.
  computeNormals() {
    const p = this.position3.array, n = this.normal3.array, index = this.geometry.index.array;
    n.fill(0);
    for (let t = 0; t < index.length; t += 3) {
      const a = 3 * index[t], b = 3 * index[t + 1], c = 3 * index[t + 2];
      const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2];
      const vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
      const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
      n[a] += x; n[a + 1] += y; n[a + 2] += z;
      n[b] += x; n[b + 1] += y; n[b + 2] += z;
      n[c] += x; n[c + 1] += y; n[c + 2] += z;
    }
    for (let i = 0; i < n.length; i += 3) {
      const length = Math.hypot(n[i], n[i + 1], n[i + 2]) || 1;
      n[i] /= length; n[i + 1] /= length; n[i + 2] /= length;
    }
    this.normal3.needsUpdate = true;
  }

  // Values of the colouring and their range; null without one.
  computeValues() {
    const value = this.value;
    if (this.colouring === 'displacement') {
      let high = 1e-3 * this.diagonal;
      for (let i = 0; i < value.length; ++i) {
        value[i] = this.scaleOfCount * Math.hypot(this.count[3 * i], this.count[3 * i + 1], this.count[3 * i + 2]);
        high = Math.max(high, value[i]);
      }
      return { low: 0, high, unit: 'm' };
    }
    if (this.field && this.field.name === this.colouring && this.field.value.length === value.length) {
      const { low, high, unit, value: counts } = this.field;
      for (let i = 0; i < value.length; ++i) value[i] = low + ((counts[i] + 32767) / 65534) * (high - low);
      return { low, high, unit: unit.replace('^3', '³') };
    }
    return null;
  }

  // Brings what is drawn up to date; the colouring's range, null without one, undefined when
  // nothing has changed.
  update() {
    if (!this.isPresent || !this.isChanged) return undefined;
    this.isChanged = false;
    this.computePositions();
    this.computeNormals();
    const range = this.computeValues();
    const colour = this.colour3.array;
    if (range) {
      paint(this.value, this.nodeOf, range.low, range.high, colour);
    } else {
      for (let i = 0; i < colour.length; i += 3) {
        colour[i] = TISSUE.r; colour[i + 1] = TISSUE.g; colour[i + 2] = TISSUE.b;
      }
    }
    this.colour3.needsUpdate = true;
    return range;
  }
}
