// The tools in their true shapes: where the probe is, pale, and where its proxy stands; the contact
// point with its normal, and the force as an arrow.
import * as THREE from 'three';
import { ConvexGeometry } from 'three/addons/geometries/ConvexGeometry.js';

function toolGeometry({ form, size, hull }) {
  const alongZ = (geometry) => geometry.rotateX(Math.PI / 2); // three's axis is y
  switch (form) {
    case 'sphere': return new THREE.SphereGeometry(size[0], 48, 32);
    case 'capsule': return alongZ(new THREE.CapsuleGeometry(size[0], size[1], 16, 40));
    case 'cylinder': return alongZ(new THREE.CylinderGeometry(size[0], size[0], size[1], 48));
    case 'cone': return alongZ(new THREE.ConeGeometry(size[0], size[1], 48));
    case 'box': return new THREE.BoxGeometry(...size);
    default: {
      const points = [];
      for (let i = 0; i < hull.length; i += 3) points.push(new THREE.Vector3(hull[i], hull[i + 1], hull[i + 2]));
      return points.length > 3 ? new ConvexGeometry(points) : new THREE.SphereGeometry(1e-3);
    }
  }
}

// How far the tool reaches from its origin along its own axis z.
function toolReach({ form, size, hull }) {
  switch (form) {
    case 'sphere': return size[0];
    case 'capsule': return size[0] + size[1] / 2;
    case 'box': return size[2] / 2;
    case 'convex': return Math.max(1e-4, ...hull.filter((_, i) => i % 3 === 2));
    default: return size[1] / 2;
  }
}

const STILL_S = 0.5, STALE = 16; // forces go on when nobody sends poses any more
const isTouching = (state) => (state.flags & 1) !== 0;

class Tool extends THREE.Group {
  constructor(description) {
    super();
    this.description = description;
    this.reach = toolReach(description);
    const geometry = toolGeometry(description);
    this.probeMesh = new THREE.Mesh(geometry, new THREE.MeshStandardMaterial({
      color: 0x6f8296, transparent: true, opacity: 0.35, roughness: 0.4, depthWrite: false,
      polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 2, // behind the proxy where both are
    }));
    this.proxyMesh = new THREE.Mesh(geometry, new THREE.MeshStandardMaterial({
      color: 0xd9dee3, roughness: 0.25, metalness: 0.55,
    }));
    this.arrow = new THREE.ArrowHelper(new THREE.Vector3(0, 0, 1), new THREE.Vector3(), 1, 0xe0662c);
    this.spot = new THREE.Mesh(new THREE.SphereGeometry(1, 16, 12), new THREE.MeshBasicMaterial({ color: 0xe0662c }));
    this.normal = new THREE.Line(new THREE.BufferGeometry().setFromPoints([new THREE.Vector3(), new THREE.Vector3(0, 0, 1)]),
      new THREE.LineBasicMaterial({ color: 0x0d7f83 }));
    this.add(this.probeMesh, this.proxyMesh, this.arrow, this.spot, this.normal);
    this.visible = false;
    this.heard = -Infinity;
    this.state = null;
  }

  take(state) {
    this.state = state;
    if ((state.flags & STALE) === 0) this.heard = performance.now();
  }

  // Nobody moves it any more.
  isStill() {
    return performance.now() - this.heard > 1000 * STILL_S;
  }

  // A tool that nobody moves is not there.
  update({ diagonal, maxForce, isForceShown }) {
    this.visible = !this.isStill();
    if (!this.visible) return;
    const [w, x, y, z] = this.state.orientation;
    const touches = isTouching(this.state), isShown = touches && isForceShown;
    for (const [mesh, place] of [[this.probeMesh, this.state.position], [this.proxyMesh, touches ? this.state.proxy : this.state.position]]) {
      mesh.position.fromArray(place);
      mesh.quaternion.set(x, y, z, w);
    }
    this.spot.visible = this.normal.visible = isShown;
    this.arrow.visible = false;
    if (isShown) this.pointForce(diagonal, maxForce);
  }

  pointForce(diagonal, maxForce) {
    const force = new THREE.Vector3().fromArray(this.state.force), size = force.length();
    const length = Math.max(0.02, Math.min(0.6, (0.35 * size) / maxForce)) * diagonal;
    this.arrow.visible = size > 1e-4;
    this.arrow.position.fromArray(this.state.proxy);
    if (size > 1e-4) this.arrow.setDirection(force.divideScalar(size));
    this.arrow.setLength(length, 0.03 * diagonal, 0.018 * diagonal);
    this.spot.position.fromArray(this.state.point);
    this.spot.scale.setScalar(0.006 * diagonal);
    this.normal.position.fromArray(this.state.point);
    this.normal.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), new THREE.Vector3().fromArray(this.state.normal));
    this.normal.scale.setScalar(0.1 * diagonal);
  }

  dispose() {
    this.arrow.dispose();
    for (const part of [this.probeMesh, this.spot, this.normal]) part.geometry.dispose();
    for (const part of [this.probeMesh, this.proxyMesh, this.spot, this.normal]) part.material.dispose();
  }
}

// The scene's tools by their probes.
export class Tools extends THREE.Group {
  constructor() {
    super();
    this.of = new Map();
  }

  // False: they are what they were.
  describe(descriptions) {
    const key = JSON.stringify(descriptions);
    if (key === this.key) return false;
    this.key = key;
    for (const tool of this.of.values()) tool.dispose();
    this.clear();
    this.of.clear();
    for (const description of descriptions) {
      this.of.set(description.probe, new Tool(description));
      this.add(this.of.get(description.probe));
    }
    return true;
  }

  take(force) {
    this.of.get(force.probe)?.take(force);
  }

  moved() {
    return [...this.of.values()].find((tool) => !tool.isStill()) ?? null;
  }

  forget() {
    for (const tool of this.of.values()) tool.heard = -Infinity;
  }

  update(shown) {
    for (const tool of this.of.values()) tool.update(shown);
  }
}
