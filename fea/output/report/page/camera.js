// The eye: a direction without perspective, a place in the middle, and how much of the rod is seen.

// Three-quarter view from above the face of the rod.
const USUAL = unit([-0.25, 0.4, 0.88]);

class Camera {
  constructor(positions) {
    this.positions = positions;
    this.aspect = 1;
    this.home();
  }

  // Look from a direction; the rod lies across a wide canvas and stands upright on a narrow one.
  look(towards) {
    this.towards = unit(towards);
    const along = unit(plus([1, 0, 0], this.towards, -this.towards[0]));
    if (this.aspect >= 0.9) [this.right, this.up] = [along, cross(this.towards, along)];
    else [this.right, this.up] = [cross(along, this.towards), along];
  }

  home() {
    this.look(USUAL);
    const ends = [this.right, this.up, this.towards].map((axis) => {
      let low = Infinity, high = -Infinity;
      for (let i = 0; i < this.positions.length; i += 3) {
        const at = dot(axis, this.positions.subarray(i, i + 3));
        low = Math.min(low, at);
        high = Math.max(high, at);
      }
      return [low, high];
    });
    this.middle = [0, 0, 0];
    [this.right, this.up, this.towards].forEach((axis, k) => {
      this.middle = plus(this.middle, axis, (ends[k][0] + ends[k][1]) / 2);
    });
    const [across, height] = ends.map(([low, high]) => (high - low) / 2);
    this.half = 1.16 * Math.max(height, across / this.aspect);
    this.extent = 2 * Math.max(across, height);
  }

  // Turn about the axes of the canvas, rad.
  orbit(across, upwards) {
    for (const [axis, angle] of [[this.up, across], [this.right, upwards]]) {
      this.right = turned(this.right, axis, angle);
      this.up = turned(this.up, axis, angle);
    }
    this.right = unit(this.right);
    this.up = unit(plus(this.up, this.right, -dot(this.up, this.right)));
    this.towards = cross(this.right, this.up);
  }

  // Move by shares of half the height of the canvas.
  pan(across, upwards) {
    this.middle = plus(plus(this.middle, this.right, -across * this.half), this.up, -upwards * this.half);
  }

  zoom(factor) {
    this.half = Math.min(2 * this.extent, Math.max(this.extent / 400, this.half / factor));
  }

  state() {
    return { middle: this.middle, half: this.half, right: this.right, up: this.up };
  }

  set({ middle, half, right, up }) {
    this.middle = middle;
    this.half = half;
    this.right = unit(right);
    this.up = unit(plus(up, this.right, -dot(up, this.right)));
    this.towards = cross(this.right, this.up);
  }

  // What lies between two states.
  static between(from, to, t) {
    return {
      middle: mixed(from.middle, to.middle, t),
      half: from.half * (to.half / from.half) ** t,
      right: mixed(from.right, to.right, t),
      up: mixed(from.up, to.up, t),
    };
  }

  // Column-major matrix to clip space.
  matrix() {
    const x = 1 / (this.half * this.aspect), y = 1 / this.half, z = -1 / (4 * this.extent);
    const { right: r, up: u, towards: t, middle: m } = this;
    return new Float32Array([
      x * r[0], y * u[0], z * t[0], 0, x * r[1], y * u[1], z * t[1], 0, x * r[2], y * u[2], z * t[2], 0,
      -x * dot(r, m), -y * dot(u, m), -z * dot(t, m), 1,
    ]);
  }

  // Where a place is on the canvas, in shares of its width and height from the top left, and how near.
  seen(place) {
    const from = plus(place, this.middle, -1);
    return [
      0.5 + dot(from, this.right) / (2 * this.half * this.aspect),
      0.5 - dot(from, this.up) / (2 * this.half),
      dot(from, this.towards),
    ];
  }
}
