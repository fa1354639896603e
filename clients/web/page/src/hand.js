// The mouse, a finger or a pen as a probe. Pressing on the body pushes along the view: the tool
// comes from outside, touches where the pointer is on the rest shape (which does not give way, so
// that the aim does not run after the surface), and goes in by a depth that grows as a spring is
// drawn. The wheel changes the depth; Shift grasps: the tool then stays at its depth and follows the
// pointer in the plane of the view.
import * as THREE from 'three';

const RISE_S = 0.18, LEAVE_S = 0.25, ARRIVE_S = 0.1, DEPTH_SHARE = 0.045, OUTSIDE_SHARE = 0.03;

export class Hand {
  constructor(canvas, camera, body, tools, link) {
    Object.assign(this, { canvas, camera, body, tools, link });
    this.raycaster = new THREE.Raycaster();
    this.pointer = new THREE.Vector2();
    this.tool = null;
    this.depthShare = DEPTH_SHARE;
    this.press = null;
  }

  setPointer(event) {
    const box = this.canvas.getBoundingClientRect();
    this.pointer.set(((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2);
    this.place = [event.clientX - box.left, event.clientY - box.top];
    this.isShift = event.shiftKey;
  }

  // Where the pointer is on the body at rest.
  hit() {
    if (!this.body.isPresent) return null;
    this.raycaster.setFromCamera(this.pointer, this.camera);
    return this.raycaster.intersectObject(this.body.target, false)[0] ?? null;
  }

  // The first tool that nobody moves, else the first of all.
  chooseTool() {
    if (this.press) return;
    const all = [...this.tools.values()], now = performance.now();
    this.tool = all.find((tool) => now - tool.heard > 500) ?? all[0] ?? null;
  }

  // Begins a press; false when the pointer is beside the body, or there is no tool.
  begin(event) {
    this.setPointer(event);
    this.chooseTool();
    const hit = this.tool ? this.hit() : null;
    if (!hit) return false;
    this.press = { start: performance.now(), point: hit.point.clone(), plane: new THREE.Plane(), isGrasping: false };
    this.update();
    return true;
  }

  move(event) {
    this.setPointer(event);
  }

  wheel(event) {
    if (!this.press) return false;
    this.depthShare = Math.max(0.002, Math.min(0.25, this.depthShare * (event.deltaY > 0 ? 1 / 1.15 : 1.15)));
    return true;
  }

  end() {
    if (this.press && !this.press.left) this.press.left = performance.now();
  }

  cancel() {
    if (this.press) this.link.send('drop');
    this.press = null;
  }

  // Follows the pointer: on the body its surface, beside it and in a grasp the plane of the view
  // through the last place.
  follow(press, direction) {
    const hit = press.isGrasping ? null : this.hit();
    if (hit) {
      press.point.copy(hit.point);
      return;
    }
    press.plane.setFromNormalAndCoplanarPoint(direction, press.point);
    this.raycaster.setFromCamera(this.pointer, this.camera);
    const place = this.raycaster.ray.intersectPlane(press.plane, new THREE.Vector3());
    if (place && place.distanceTo(press.point) < this.body.diagonal) press.point.copy(place);
  }

  update() {
    const press = this.press;
    if (!press) return;
    const now = performance.now(), diagonal = this.body.diagonal;
    const direction = this.camera.getWorldDirection(new THREE.Vector3());
    const pressed = (now - press.start) / 1000, left = press.left ? (now - press.left) / 1000 : 0;
    if (press.outside && now - press.outside > 1000 * ARRIVE_S) {
      this.cancel();
      return;
    }
    if (left > LEAVE_S) press.outside ??= now; // told below, however seldom this is drawn
    if (!press.left) {
      this.follow(press, direction);
      press.isGrasping = press.isGrasping ? this.isShift : this.isShift && pressed > 1.5 * RISE_S;
    }
    const outside = OUTSIDE_SHARE * diagonal, depth = this.depthShare * diagonal;
    const into = press.left
      ? press.into - (press.into + outside) * Math.min(1, left / LEAVE_S)
      : -outside + (depth + outside) * (1 - Math.exp(-pressed / RISE_S));
    if (!press.left) press.into = into;
    const centre = press.point.clone().addScaledVector(direction, into - this.tool.reach);
    const turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), direction);
    const numbers = [centre.x, centre.y, centre.z, turn.w, turn.x, turn.y, turn.z].map((v) => v.toPrecision(9));
    const grasp = press.isGrasping && !press.left ? 1 : 0;
    this.link.send(`aim ${this.tool.description.probe} ${numbers.join(' ')} ${grasp}`);
  }
}
