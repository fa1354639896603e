// SPDX-License-Identifier: BSD-3-Clause
// SPDX-FileCopyrightText: 2026 the softsim authors
//
// How far the forces of a replay are from those that were felt while it was recorded.
//   node compare_forces.mjs LOG.lcmlog REPLAY.csv PROBE
import { readFileSync } from 'node:fs';

const [log, csv, probe] = process.argv.slice(2);

// Live: the last force that answered each pose, in the order of the poses.
const poses = [], live = new Map();
const bytes = readFileSync(log);
for (let at = 0; at + 28 <= bytes.length;) {
  const name = bytes.readInt32BE(at + 20), size = bytes.readInt32BE(at + 24);
  const channel = bytes.toString('latin1', at + 28, at + 28 + name), data = bytes.subarray(at + 28 + name, at + 28 + name + size);
  if (channel === `SOFTSIM_PROBE_${probe}`) poses.push(data.readInt32BE(8 + 16)); // seq
  if (channel === `SOFTSIM_FORCE_${probe}`) {
    live.set(data.readInt32BE(8 + 24 + 8), [0, 1, 2].map((d) => data.readDoubleBE(8 + 24 + 24 + 8 * d)));
  }
  at += 28 + name + size;
}
const [head, ...rows] = readFileSync(csv, 'utf8').trim().split('\n').map((row) => row.split(','));
const column = Object.fromEntries(head.map((name, i) => [name, i]));
const size = (f) => Math.hypot(...f);
let count = 0, sum = 0, worst = 0, peak = [0, 0];
for (const row of rows) {
  const felt = live.get(poses[Number(row[column.pose_seq]) - 1]);
  const replayed = ['fx', 'fy', 'fz'].map((name) => Number(row[column[name]]));
  if (!felt) continue;
  const difference = size(felt.map((f, d) => f - replayed[d]));
  count += 1;
  sum += difference ** 2;
  worst = Math.max(worst, difference);
  peak = [Math.max(peak[0], size(felt)), Math.max(peak[1], size(replayed))];
}
if (count === 0 || !(peak[0] > 0) || !(peak[1] > 0)) {
  console.error(`compare_forces: ${count} forces of ${rows.length} belong together, none of them felt`);
  process.exit(1);
}
const newtons = (value) => `${value.toFixed(3)} N`;
console.log(`${count} forces, at most ${newtons(peak[0])} live and ${newtons(peak[1])} replayed; ` +
  `they differ by ${newtons(Math.sqrt(sum / count))} rms, ${newtons(worst)} at worst`);
