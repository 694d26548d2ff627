// The value under the pointer: the nearest triangle there, and the value within it as the colours have it.

class Picker {
  constructor(surface) {
    this.surface = surface;
    this.flat = new Float32Array(3 * surface.count);
  }

  // Project all nodes to the canvas.
  aim(camera, displacement, scale) {
    const p = this.surface.positions, { right: r, up: u, towards: t, middle: m } = camera;
    const x = 1 / (camera.half * camera.aspect), y = 1 / camera.half;
    for (let i = 0; i < p.length; i += 3) {
      const a = p[i] + scale * displacement[i] - m[0];
      const b = p[i + 1] + scale * displacement[i + 1] - m[1];
      const c = p[i + 2] + scale * displacement[i + 2] - m[2];
      this.flat[i] = x * (r[0] * a + r[1] * b + r[2] * c);
      this.flat[i + 1] = y * (u[0] * a + u[1] * b + u[2] * c);
      this.flat[i + 2] = t[0] * a + t[1] * b + t[2] * c;
    }
  }

  // The triangle at (x, y) of clip space: its nodes, their weights and how near it is; null beside the rod.
  at(x, y) {
    const f = this.flat, t = this.surface.triangles;
    let found = null, nearest = -Infinity;
    for (let i = 0; i < t.length; i += 3) {
      const a = 3 * t[i], b = 3 * t[i + 1], c = 3 * t[i + 2];
      const bx = f[b] - f[a], by = f[b + 1] - f[a + 1], cx = f[c] - f[a], cy = f[c + 1] - f[a + 1];
      const area = bx * cy - by * cx;
      if (area <= 0) continue;
      const px = x - f[a], py = y - f[a + 1];
      const second = (px * cy - py * cx) / area, third = (bx * py - by * px) / area;
      if (second < 0 || third < 0 || second + third > 1) continue;
      const depth = f[a + 2] + second * (f[b + 2] - f[a + 2]) + third * (f[c + 2] - f[a + 2]);
      if (depth <= nearest) continue;
      nearest = depth;
      found = { nodes: [t[i], t[i + 1], t[i + 2]], weights: [1 - second - third, second, third], depth };
    }
    return found;
  }
}
