// SPDX-License-Identifier: BSD-3-Clause
// SPDX-FileCopyrightText: 2026 the softsim authors
//
// What of the page needs no browser: sharp edges, numbers with units, parameters' names, gaps in time.
//   node test_parts.mjs PAGE_FOLDER
import assert from 'node:assert/strict';
import { pathToFileURL } from 'node:url';

const source = (name) => import(pathToFileURL(`${process.argv[2]}/src/${name}.js`));
const { splitCreases } = await source('creases');
const { engineering } = await source('colours');
const { controlsOf } = await source('parameters');
const { unbroken } = await source('plots');

// A cube: eight nodes, a vertex of each for each of its three sides; their triangles stay theirs.
const cube = Float32Array.from([0, 1, 2, 3, 4, 5, 6, 7].flatMap((i) => [i & 1, (i >> 1) & 1, i >> 2]));
const sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
const triangles = Uint32Array.from(sides.flatMap(([a, b, c, d]) => [a, b, c, a, c, d]));
const split = splitCreases(cube, triangles, 8, 40);
assert.equal(split.nodeOf.length, 24);
assert.deepEqual([...split.index].map((v) => split.nodeOf[v]), [...triangles]);
sides.forEach((side, s) => {
  const own = new Set(split.index.subarray(6 * s, 6 * s + 6));
  assert.equal(own.size, 4, 'a side shares its vertices');
  [...split.index].forEach((v, corner) => assert.equal(own.has(v), Math.floor(corner / 6) === s, 'with no other side'));
});
assert.equal(splitCreases(cube, triangles, 8, 91).nodeOf.length, 8, 'nothing is sharp');

// A roof that bends by 2 atan(h) stays whole up to the angle; its far corners are of one side each.
for (const [height, vertices] of [[0.3, 4], [0.45, 6]]) {
  const roof = Float32Array.from([0, 0, height, 0, 1, height, 1, 0.5, 0, -1, 0.5, 0]);
  assert.equal(splitCreases(roof, Uint32Array.from([0, 2, 1, 0, 1, 3]), 4, 40).nodeOf.length, vertices);
}

assert.equal(engineering(0.00432, 'm'), '4.32 mm');
assert.equal(engineering(-2930, 'Pa'), '-2.93 kPa');
assert.equal(engineering(0, 'J'), '0 J');

// One value of three names is told apart by its units; what has no number says why; a running server
// takes no mesh rate of 0, and where there is no mesh, none at all.
const rows = (...list) => controlsOf(list.map(([path, value, low = 0, unit = '']) => ({ path, value, low, high: 1e3, unit })));
const moduli = rows(['model.modulus_j', '5', 0, 'J'], ['model.modulus_n_per_m', 'varies', 0, 'N/m'], ['model.modulus_pa', 'varies', 0, 'Pa'],
  ['model.rho', 'varies'], ['publish.field', 'none', 0, 'none|energy']);
assert.deepEqual(moduli.map(({ title }) => title), ['Modulus in J', 'Modulus in N/m', 'Modulus in Pa', 'Rho']);
assert.deepEqual(moduli.slice(1).map(({ why }) => why), ['given in J', 'given in J', 'differs by region']);
assert.deepEqual(rows(['publish.mesh_rate_hz', '60']).map(({ low }) => low), [1]);
assert.deepEqual(rows(['publish.mesh_rate_hz', '0']), []);

// A line over time is broken where nothing was felt for longer than 0.3 s.
assert.deepEqual(unbroken([[1, 2], [1.2, 3], [5, 1], [5.1, 2]]), [[[1, 2], [1.2, 3]], [[5, 1], [5.1, 2]]]);
assert.deepEqual(unbroken([]), []);
console.log('test_parts: sharp edges, units, names, gaps');
