// Where a surface has sharp edges it is shaded flat on both sides: there a node has a vertex for each
// side, elsewhere one for all. Two triangles are of one side at a node when they share an edge there
// that bends by less than the angle, or are joined by such.

function faceNormals(rest, index) {
  const out = new Float32Array(index.length);
  for (let t = 0; t < index.length; t += 3) {
    const [a, b, c] = [3 * index[t], 3 * index[t + 1], 3 * index[t + 2]];
    const [ux, uy, uz] = [rest[b] - rest[a], rest[b + 1] - rest[a + 1], rest[b + 2] - rest[a + 2]];
    const [vx, vy, vz] = [rest[c] - rest[a], rest[c + 1] - rest[a + 1], rest[c + 2] - rest[a + 2]];
    const [x, y, z] = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    const length = Math.hypot(x, y, z) || 1;
    out.set([x / length, y / length, z / length], t);
  }
  return out;
}

// { nodeOf: the node of each vertex, index: the triangles in vertices }
export function splitCreases(rest, index, nodes, degrees) {
  const normal = faceNormals(rest, index), least = Math.cos((Math.PI / 180) * degrees);
  const parent = Uint32Array.from(index, (_, corner) => corner);
  const root = (corner) => {
    while (parent[corner] !== corner) {
      parent[corner] = parent[parent[corner]];
      corner = parent[corner];
    }
    return corner;
  };
  const join = (a, b) => { parent[root(a)] = root(b); };
  // Edges by their lesser node: a list of corners from which one starts.
  const head = new Int32Array(nodes).fill(-1), next = new Int32Array(index.length);
  const after = (corner) => (corner % 3 === 2 ? corner - 2 : corner + 1);
  for (let corner = 0; corner < index.length; ++corner) {
    const a = index[corner], b = index[after(corner)], low = Math.min(a, b), high = Math.max(a, b);
    let other = head[low];
    while (other >= 0 && Math.max(index[other], index[after(other)]) !== high) other = next[other];
    if (other < 0) {
      next[corner] = head[low];
      head[low] = corner;
      continue;
    }
    const [s, t] = [corner - (corner % 3), other - (other % 3)];
    if (normal[s] * normal[t] + normal[s + 1] * normal[t + 1] + normal[s + 2] * normal[t + 2] < least) continue;
    const isSame = index[other] === a;
    join(corner, isSame ? other : after(other));
    join(after(corner), isSame ? after(other) : other);
  }
  const vertexOf = new Int32Array(index.length).fill(-1), nodeOf = [], out = new Uint32Array(index.length);
  for (let corner = 0; corner < index.length; ++corner) {
    const r = root(corner);
    if (vertexOf[r] < 0) vertexOf[r] = nodeOf.push(index[corner]) - 1;
    out[corner] = vertexOf[r];
  }
  return { nodeOf: Uint32Array.from(nodeOf), index: out };
}
