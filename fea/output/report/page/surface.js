// The surface: facets, the nodes between their vertices, small flat triangles, normals, sharp edges.

const CREASE = Math.cos((28 * Math.PI) / 180);
const NO_LINE = 0;

class Surface {
  // Of places (3 n), the nodes of flat triangles, and for each corner which sides are edges of elements.
  constructor(positions, triangles, lines) {
    Object.assign(this, { positions, triangles, lines, count: positions.length / 3 });
    this.flatNormals();
    this.smoothNormals();
    this.findSharpEdges();
  }

  flatNormals() {
    const p = this.positions, t = this.triangles;
    this.flat = new Float32Array(t.length);
    for (let i = 0; i < t.length; i += 3) {
      const a = 3 * t[i], b = 3 * t[i + 1], c = 3 * t[i + 2];
      const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2];
      const vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
      const n = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
      const size = Math.hypot(...n) || 1;
      for (let k = 0; k < 3; k++) this.flat[i + k] = n[k] / size;
    }
  }

  // A normal for each corner: the mean over the triangles there that are not beyond a crease.
  smoothNormals() {
    const t = this.triangles, flat = this.flat;
    const start = new Int32Array(this.count + 1);
    for (const node of t) start[node + 1]++;
    for (let i = 0; i < this.count; i++) start[i + 1] += start[i];
    const here = new Int32Array(t.length), filled = start.slice();
    for (let i = 0; i < t.length; i++) here[filled[t[i]]++] = 3 * Math.floor(i / 3);
    this.normals = new Int8Array(4 * t.length);
    this.nodeNormals = new Float32Array(3 * this.count);
    for (let i = 0; i < t.length; i++) {
      const own = 3 * Math.floor(i / 3);
      let x = 0, y = 0, z = 0;
      for (let k = start[t[i]]; k < start[t[i] + 1]; k++) {
        const other = here[k];
        const along = flat[own] * flat[other] + flat[own + 1] * flat[other + 1] + flat[own + 2] * flat[other + 2];
        if (along < CREASE) continue;
        x += flat[other];
        y += flat[other + 1];
        z += flat[other + 2];
      }
      const size = 127 / (Math.hypot(x, y, z) || 1);
      this.normals.set([x * size, y * size, z * size, 0], 4 * i);
      for (let k = 0; k < 3; k++) this.nodeNormals[3 * t[i] + k] += flat[own + k];
    }
  }

  // Edges of elements at which the surface turns sharply are always drawn: pairs of nodes.
  findSharpEdges() {
    const t = this.triangles, flat = this.flat, first = new Map();
    this.sharp = [];
    for (let i = 0; i < t.length; i++) {
      const triangle = 3 * Math.floor(i / 3), k = i - triangle;
      if (this.lines[4 * triangle + k] === NO_LINE) continue;
      const a = t[triangle + ((k + 1) % 3)], b = t[triangle + ((k + 2) % 3)];
      const key = Math.min(a, b) * this.count + Math.max(a, b);
      const other = first.get(key);
      if (other === undefined) {
        first.set(key, i);
        continue;
      }
      const far = 3 * Math.floor(other / 3);
      const along = flat[triangle] * flat[far] + flat[triangle + 1] * flat[far + 1] + flat[triangle + 2] * flat[far + 2];
      if (along >= CREASE) continue;
      this.sharp.push(a, b);
    }
  }

  place(node) {
    return Array.from(this.positions.subarray(3 * node, 3 * node + 3));
  }

  // The node nearest to a place.
  nearest(place) {
    let best = 0, least = Infinity;
    for (let i = 0; i < this.count; i++) {
      const d = Math.hypot(this.positions[3 * i] - place[0], this.positions[3 * i + 1] - place[1],
        this.positions[3 * i + 2] - place[2]);
      if (d < least) [best, least] = [i, d];
    }
    return best;
  }
}

// The facets of packed numbers: small flat triangles, and the earlier nodes beside each node.
class Facets {
  constructor(corners, { nodes, vertices, order }) {
    Object.assign(this, { corners, vertices });
    this.parents = { first: new Int32Array(nodes), second: new Int32Array(nodes) };
    this.readVertices();
    this.middles = order === 2 ? this.readMiddles() : null;
    this.cut();
  }

  readVertices() {
    let next = 0;
    for (let f = 0; f < this.corners.length; f += 3) {
      const facet = this.corners.subarray(f, f + 3);
      for (const vertex of facet) {
        if (vertex !== next) continue;
        next++;
        const earlier = Array.from(facet).filter((other) => other < vertex).sort((a, b) => b - a);
        const first = earlier.length ? earlier[0] : vertex - 1;
        this.parents.first[vertex] = first;
        this.parents.second[vertex] = earlier.length > 1 ? earlier[1] : first;
      }
    }
  }

  readMiddles() {
    const between = new Map();
    const middles = new Int32Array(this.corners.length);
    let next = this.vertices;
    for (let f = 0; f < this.corners.length; f += 3) {
      for (let k = 0; k < 3; k++) {
        const a = this.corners[f + k], b = this.corners[f + ((k + 1) % 3)];
        const key = Math.min(a, b) * this.vertices + Math.max(a, b);
        let node = between.get(key);
        if (node === undefined) {
          node = next++;
          between.set(key, node);
          this.parents.first[node] = a;
          this.parents.second[node] = b;
        }
        middles[f + k] = node;
      }
    }
    return middles;
  }

  // Divide facets of six nodes into four triangles; `lines` says which sides are edges of elements, by the
  // corner opposite.
  cut() {
    const facets = this.corners.length / 3;
    const pieces = this.middles ? 4 : 1;
    this.triangles = new Int32Array(3 * pieces * facets);
    this.lines = new Uint8Array(4 * 3 * pieces * facets);
    let at = 0;
    const add = (a, b, c, lines) => {
      this.triangles.set([a, b, c], at);
      for (let k = 0; k < 3; k++) this.lines.set(lines, 4 * (at + k));
      at += 3;
    };
    for (let f = 0; f < this.corners.length; f += 3) {
      const [a, b, c] = this.corners.subarray(f, f + 3);
      if (!this.middles) {
        add(a, b, c, [1, 1, 1, 0]);
        continue;
      }
      const [ab, bc, ca] = this.middles.subarray(f, f + 3);
      add(a, ab, ca, [0, 1, 1, 0]);
      add(ab, b, bc, [1, 0, 1, 0]);
      add(ca, bc, c, [1, 1, 0, 0]);
      add(ab, bc, ca, [0, 0, 0, 0]);
    }
  }
}

function unpackedSurface(numbers, header) {
  const { triangles, lines, parents } = new Facets(fromSteps(numbers.integers("corners")), header);
  const [x, y, z] = numbers.values("positions", parents), positions = new Float32Array(3 * header.nodes);
  for (let i = 0; i < header.nodes; i++) positions.set([x[i], y[i], z[i]], 3 * i);
  return Object.assign(new Surface(positions, triangles, lines), { parents });
}
