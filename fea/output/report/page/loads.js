// Forces of the pins as arrows, and where they press on their bores.

const ARROW = 0.3, HEIGHT = 0.42, AROUND = 14;

class Loads {
  constructor(header) {
    this.bores = header.bores;
    this.pressure = header.pressure;
    this.clamped = header.clamped;
    this.force = header.shown.force;
    const sizes = header.results.flatMap((result) => resultForces(result)).map((force) => Math.hypot(...force));
    this.largest = Math.max(...sizes, 1e-9);
    const touches = header.results.flatMap((result) => result.touch ?? []).map((touch) => touch[2]);
    this.hardest = Math.max(...touches, 1e-9);
  }

  // Forces [x, y] on both bores and contact there, of a result at a crank angle; null where there are none.
  acting(result, angle) {
    if (this.bores.length < 2) return null;
    if (result.kind === "case") return { forces: result.forces, touch: result.touch };
    if (result.kind !== "cycle" || !result.loads.forces) return null;
    const at = Math.round(angle);
    return {
      forces: result.loads.forces.map(([x, y]) => [x[at], y[at]]),
      touch: result.loads.touch ? result.loads.touch.map((columns) => columns.map((column) => column[at])) : null,
    };
  }

  // Solids for the painter, and where to write how large the forces are. `touching` are the contact pressures
  // of the nodes and their places, where they are known.
  // `films` are the oil films of the ends that they load.
  drawn(result, angle, camera, tint, touching, films) {
    const acting = this.acting(result, angle);
    if (!acting) return { solids: [], labels: [] };
    const length = this.bores[1].x, solids = [], labels = [];
    this.bores.forEach((bore, k) => {
      const force = acting.forces[k], size = Math.hypot(...force);
      const z = camera.towards[2] >= 0 ? bore.high + 0.04 * length : bore.low - 0.04 * length;
      if (size > 1e-3 * this.largest) {
        const direction = [force[0] / size, force[1] / size, 0];
        const reach = ARROW * length * (size / this.largest);
        solids.push({ ...arrow([bore.x, 0, z], direction, reach, 0.016 * length), tint: [...tint, 1] });
        const tip = plus([bore.x, 0, z], direction, reach + 0.05 * length);
        labels.push({ at: tip, text: `${fixed(this.force.factor * size, this.force.digits)} ${this.force.unit}` });
      }
      const film = acting.touch?.[k]?.[2] > 0 ? null : films[k];
      const arc = film ? film.around(angle) : this.arc(k, force, acting.touch, touching);
      if (arc) {
        for (const face of [bore.low - 0.003 * length, bore.high + 0.003 * length]) {
          solids.push({ ...pressed(bore, face, arc), tint: [...tint.map((c) => c * 0.9), 0.75] });
        }
      }
    });
    return { solids, labels };
  }

  // Middle and width, rad, height in radii and shape of the pressure on a bore.
  arc(k, force, touch, touching) {
    if (k === 0 && this.clamped) return null;
    const size = Math.hypot(...force), middle = Math.atan2(force[1], force[0]);
    if (this.pressure.kind === "contact" || touch?.[k]?.[2] > 0) {
      if (!touch || touch[k][2] <= 0) return null;
      const height = (HEIGHT * touch[k][2]) / this.hardest;
      if (touching) return { middle: 0, width: 2 * Math.PI, height, share: around(this.bores[k], touching) };
      // Over the cycle only the extent and the largest pressure are known.
      return { middle, width: rad(touch[k][1]), height: height / 3, share: () => 1 };
    }
    if (size <= 1e-3 * this.largest) return null;
    const height = (HEIGHT * size) / this.largest;
    if (this.pressure.kind === "oil-film") return { middle, width: Math.PI, height, share: Math.cos };
    if (this.pressure.kind !== "arc") return { middle, width: 2 * Math.PI, height: height / 2, share: () => 1 };
    const outwards = k === 1 ? force[0] > 0 : force[0] < 0;
    const { shares, deg } = outwards ? this.pressure.tension : this.pressure.compression, last = shares.length - 1;
    const share = (away) => {
      const place = Math.min(1, (2 * Math.abs(away)) / rad(deg)) * last, k = Math.min(Math.floor(place), last - 1);
      return shares[k] + (place - k) * (shares[k + 1] - shares[k]);
    };
    return { middle, width: rad(deg), height, share };
  }
}

// The mean pressure along a bore in each direction, as a share of the largest.
function around(bore, { values, positions }) {
  const count = 60, sums = new Float64Array(count), weights = new Float64Array(count);
  for (let i = 0; i < values.length; i++) {
    const x = positions[3 * i] - bore.x, y = positions[3 * i + 1];
    if (Math.abs(Math.hypot(x, y) / bore.radius - 1) > 0.01) continue;
    const k = Math.round(((Math.atan2(y, x) / (2 * Math.PI) + 1) % 1) * count) % count;
    sums[k] += values[i];
    weights[k]++;
  }
  const means = Array.from(sums, (sum, k) => sum / Math.max(1, weights[k])), largest = Math.max(...means, 1e-9);
  return (away) => {
    const place = ((away / (2 * Math.PI) + 1) % 1) * count, k = Math.floor(place);
    return ((1 - place + k) * means[k % count] + (place - k) * means[(k + 1) % count]) / largest;
  };
}

const rad = (degrees) => (degrees * Math.PI) / 180;

function resultForces(result) {
  if (result.kind === "case") return result.forces;
  if (result.kind !== "cycle" || !result.loads.forces) return [];
  return result.loads.forces.flatMap(([x, y]) => x.map((value, i) => [value, y[i]]));
}

// A shaft and a head as triangles.
function arrow(from, direction, length, radius) {
  const head = Math.min(0.45 * length, 3.4 * radius), places = [], normals = [];
  const aside = unit(cross(direction, [0, 0, 1])), above = cross(direction, aside);
  const around = (k) => {
    const angle = (2 * Math.PI * k) / AROUND;
    return plus(aside.map((value) => Math.cos(angle) * value), above, Math.sin(angle));
  };
  const neck = plus(from, direction, length - head), tip = plus(from, direction, length);
  for (let k = 0; k < AROUND; k++) {
    const [a, b] = [around(k), around(k + 1)];
    const quad = (p, q, r, s) => {
      const low = [plus(p, a, r), plus(p, b, r)], high = [plus(q, a, s), plus(q, b, s)];
      places.push(...low[0], ...low[1], ...high[0], ...high[0], ...low[1], ...high[1]);
      normals.push(...a, ...b, ...a, ...a, ...b, ...b);
    };
    quad(from, neck, 0.5 * radius, 0.5 * radius);
    quad(neck, tip, 1.5 * radius, 0);
    quad(neck, neck, 0.5 * radius, 1.5 * radius);
    quad(from, from, 0, 0.5 * radius);
  }
  return { places, normals };
}

// What presses on a bore, as a ring whose height is the pressure, seen from either side.
function pressed(bore, z, { middle, width, height, share }) {
  const places = [], normals = [], pieces = 72;
  const at = (k) => {
    const away = width * (k / pieces - 0.5);
    const [c, s] = [Math.cos(middle + away), Math.sin(middle + away)];
    const inner = bore.radius * (1 - height * Math.max(0.005, share(away)));
    return [[bore.x + bore.radius * c, bore.radius * s, z], [bore.x + inner * c, inner * s, z]];
  };
  for (let k = 0; k < pieces; k++) {
    const [a, b] = at(k), [c, d] = at(k + 1);
    places.push(...a, ...b, ...c, ...c, ...b, ...d);
    normals.push(...new Array(18).fill(0));
  }
  return { places, normals };
}
