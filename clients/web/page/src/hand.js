// A probe moved by a mouse, a finger, a pen or keys. Pressing on the body pushes along the view: the
// tool comes from outside, touches where the pointer is on the rest shape (which does not give way, so
// that the aim does not run after the surface), and goes in by a depth that grows as a spring is drawn.
// In a grasp the tool stays at its depth and follows the pointer in the plane of the view.
import * as THREE from 'three';

const RISE_S = 0.18, LEAVE_S = 0.25, ARRIVE_S = 0.1, OUTSIDE_SHARE = 0.03, KEPT_MS = 1000;
// Of the body's diagonal.
export const DEPTH_SHARE = { least: 0.002, first: 0.045, most: 0.25 };

export class Hand {
  constructor(view, body, tools, link) {
    Object.assign(this, { view, body, tools, link });
    this.tool = null;
    this.depthShare = DEPTH_SHARE.first;
    this.press = null;
    this.isServed = false; // there is a server to move it
    this.isOthers = false; // another browser holds the probe
    this.droppedAt = -Infinity;
    this.isShift = this.isLatched = false; // either grasps
    this.onChange = () => {};
  }

  // Where a place of the canvas is on the body at rest.
  hit(place) {
    if (!this.body.isPresent) return null;
    return this.view.ray(place).intersectObject(this.body.target, false)[0] ?? null;
  }

  // The first tool that nobody else moves; the last one stays this hand's for as long as the server keeps
  // it for who moved it.
  freeTool() {
    const isMine = (tool) => tool === this.tool && (this.press || performance.now() - this.droppedAt < KEPT_MS);
    return [...this.tools.of.values()].find((tool) => tool.isStill() || isMine(tool)) ?? null;
  }

  // Why no press can begin; null when one can.
  obstacle() {
    if (!this.isServed || !this.body.isPresent) return 'There is nothing to press at.';
    if (this.isOthers) return 'Another browser holds the tool: you watch';
    if (!this.tools.of.size) return 'This scene has no tool to press with';
    return this.freeTool() ? null : 'Another program moves the tool: you watch';
  }

  takeHolder(holder, isRefused) {
    this.isOthers = holder === 'another browser';
    if (this.press && (this.isOthers || isRefused)) this.cancel();
    this.onChange();
  }

  isPressing() {
    return Boolean(this.press && !this.press.left);
  }

  // Begins a press at a place of the canvas, which `owner` alone moves and ends; false beside the body,
  // or where there is no tool to be had.
  begin(owner, place) {
    const hit = this.isPressing() || this.obstacle() ? null : this.hit(place);
    if (!hit) return false;
    if (!this.press) this.tool = this.freeTool();
    this.press = { owner, start: performance.now(), point: hit.point.clone(), plane: new THREE.Plane(), isGrasping: false };
    this.place = place;
    this.update();
    this.onChange();
    return true;
  }

  move(owner, place) {
    if (this.press?.owner === owner) this.place = place;
  }

  end(owner) {
    if (!this.isPressing() || this.press.owner !== owner) return;
    this.press.left = performance.now();
    this.isLatched = false;
    this.onChange();
  }

  cancel() {
    if (this.press) {
      this.link.send('drop');
      this.droppedAt = performance.now();
    }
    this.press = null;
    this.isLatched = false;
    this.onChange();
  }

  setDepth(share) {
    this.depthShare = Math.max(DEPTH_SHARE.least, Math.min(DEPTH_SHARE.most, share));
    this.onChange();
  }

  setGrasp(isWanted) {
    this.isLatched = isWanted;
    this.onChange();
  }

  // Follows the pointer: on the body its surface, beside it and in a grasp the plane of the view
  // through the last place.
  follow(press, direction) {
    const hit = press.isGrasping ? null : this.hit(this.place);
    if (hit) {
      press.point.copy(hit.point);
      return;
    }
    press.plane.setFromNormalAndCoplanarPoint(direction, press.point);
    const place = this.view.ray(this.place).ray.intersectPlane(press.plane, new THREE.Vector3());
    if (place && place.distanceTo(press.point) < this.body.diagonal) press.point.copy(place);
  }

  // How far in the tool is to be, in metres; outside it is negative.
  reachOf(press, now) {
    const { diagonal } = this.body, outside = OUTSIDE_SHARE * diagonal;
    if (press.left) return press.into - (press.into + outside) * Math.min(1, (now - press.left) / (1000 * LEAVE_S));
    press.into = -outside + (this.depthShare * diagonal + outside) * (1 - Math.exp((press.start - now) / (1000 * RISE_S)));
    return press.into;
  }

  update() {
    const press = this.press, now = performance.now();
    if (!press) return;
    if (press.outside && now - press.outside > 1000 * ARRIVE_S) {
      this.cancel();
      return;
    }
    if (press.left && now - press.left > 1000 * LEAVE_S) press.outside ??= now; // told below, however seldom this is drawn
    const direction = this.view.direction();
    if (!press.left) {
      const isWanted = this.isShift || this.isLatched;
      this.follow(press, direction);
      press.isGrasping = isWanted && (press.isGrasping || now - press.start > 1500 * RISE_S);
    }
    this.aim(press.point.clone().addScaledVector(direction, this.reachOf(press, now) - this.tool.reach), direction,
      press.isGrasping && !press.left);
  }

  aim(centre, direction, isGrasping) {
    const turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), direction);
    const numbers = [centre.x, centre.y, centre.z, turn.w, turn.x, turn.y, turn.z].map((v) => v.toPrecision(9));
    this.link.send(`aim ${this.tool.description.probe} ${numbers.join(' ')} ${isGrasping ? 1 : 0}`);
  }
}
