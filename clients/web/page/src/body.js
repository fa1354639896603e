// The deforming body: positions from counts, smooth normals, a colour per node, its edges, its rest
// shape as a ghost and its fixed nodes.
import * as THREE from 'three';
import { paint } from './colours.js';

const TISSUE = new THREE.Color(0xb5574a);

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
      this.remove(part);
    }
    this.nodes = nodes;
    this.scaleOfCount = scale;
    this.restPosition = rest;
    this.count = new Int16Array(3 * nodes);
    this.value = new Float32Array(nodes); // of the colouring
    this.field = null;
    const indices = new THREE.BufferAttribute(index, 1);
    this.geometry = new THREE.BufferGeometry();
    this.position3 = new THREE.BufferAttribute(rest.slice(), 3).setUsage(THREE.DynamicDrawUsage);
    this.normal3 = new THREE.BufferAttribute(new Float32Array(3 * nodes), 3).setUsage(THREE.DynamicDrawUsage);
    this.colour3 = new THREE.BufferAttribute(new Float32Array(3 * nodes), 3).setUsage(THREE.DynamicDrawUsage);
    this.geometry.setIndex(indices);
    this.geometry.setAttribute('position', this.position3);
    this.geometry.setAttribute('normal', this.normal3);
    this.geometry.setAttribute('color', this.colour3);
    this.mesh = new THREE.Mesh(this.geometry, this.material);
    this.mesh.frustumCulled = false;

    const restGeometry = new THREE.BufferGeometry();
    restGeometry.setIndex(indices);
    restGeometry.setAttribute('position', new THREE.BufferAttribute(rest, 3));
    restGeometry.computeVertexNormals();
    restGeometry.computeBoundingSphere();
    restGeometry.computeBoundingBox();
    this.ghost = new THREE.Mesh(restGeometry, new THREE.MeshStandardMaterial({
      color: 0x8aa0b4, transparent: true, opacity: 0.22, depthWrite: false, roughness: 1,
    }));
    this.edges = new THREE.Mesh(this.geometry, new THREE.MeshBasicMaterial({
      color: 0x202830, wireframe: true, transparent: true, opacity: 0.28,
    }));
    this.edges.frustumCulled = false;
    const fixed = [];
    for (let i = 0; i < nodes; ++i) {
      if (flag[i] & 1) fixed.push(rest[3 * i], rest[3 * i + 1], rest[3 * i + 2]);
    }
    const pins = new THREE.BufferGeometry();
    pins.setAttribute('position', new THREE.Float32BufferAttribute(fixed, 3));
    this.sphere = restGeometry.boundingSphere;
    this.diagonal = restGeometry.boundingBox.getSize(new THREE.Vector3()).length();
    this.fixed = new THREE.Points(pins, new THREE.PointsMaterial({ color: 0x2f6fb0, size: 4, sizeAttenuation: false }));
    this.add(this.mesh, this.ghost, this.edges, this.fixed);
    this.isPresent = true;
    this.isChanged = true;
    this.setColouring(this.colouring);
  }

  takeDelta({ node, displacement }) {
    if (!this.isPresent) return;
    const position = this.position3.array, rest = this.restPosition, count = this.count;
    for (let k = 0; k < node.length; ++k) {
      for (let d = 0; d < 3; ++d) {
        const i = 3 * node[k] + d;
        count[i] = displacement[3 * k + d];
        position[i] = rest[i] + this.scaleOfCount * count[i];
      }
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

  // Area-weighted normals at nodes: the sum of the cross products of their triangles.
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
    this.position3.needsUpdate = true;
    this.computeNormals();
    const range = this.computeValues();
    const colour = this.colour3.array;
    if (range) {
      paint(this.value, range.low, range.high, colour);
    } else {
      for (let i = 0; i < colour.length; i += 3) {
        colour[i] = TISSUE.r; colour[i + 1] = TISSUE.g; colour[i + 2] = TISSUE.b;
      }
    }
    this.colour3.needsUpdate = true;
    return range;
  }
}
