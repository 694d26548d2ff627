// Values and displacement of every node, of a load case, of the whole cycle, or of an instant of it.

const LARGEST_FACTOR = 100;

const mises = (a, b, c) => Math.sqrt(0.5 * ((a - b) ** 2 + (b - c) ** 2 + (c - a) ** 2));

// Principal stresses of a symmetric tensor, largest first (Smith 1961).
function principals(xx, yy, zz, xy, yz, xz) {
  const mean = (xx + yy + zz) / 3;
  const a = xx - mean, b = yy - mean, c = zz - mean;
  const size = Math.sqrt((a * a + b * b + c * c + 2 * (xy * xy + yz * yz + xz * xz)) / 6);
  if (size === 0) return [mean, mean, mean];
  const determinant = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz);
  const angle = Math.acos(Math.max(-1, Math.min(1, determinant / (2 * size ** 3)))) / 3;
  const largest = mean + 2 * size * Math.cos(angle);
  const least = mean + 2 * size * Math.cos(angle + (2 * Math.PI) / 3);
  return [largest, 3 * mean - largest - least, least];
}

class Case {
  constructor(numbers, header, surface) {
    this.header = header;
    const own = (name) => numbers.values(`${header.id}.${name}`, surface.parents);
    this.stress = own("stress");
    this.moved = own("displacement");
    [this.strength] = own("strength");
    this.contact = numbers.has(`${header.id}.contact_pressure`) ? own("contact_pressure")[0] : null;
  }

  displacement(out) {
    for (let k = 0; k < 3; k++) for (let i = 0; i < this.strength.length; i++) out[3 * i + k] = this.moved[k][i];
  }

  values(field, out) {
    const [first, second, third] = this.stress;
    const [x, y, z] = this.moved;
    const of = {
      von_mises: (i) => mises(first[i], second[i], third[i]),
      principal_1: (i) => first[i],
      principal_2: (i) => second[i],
      principal_3: (i) => third[i],
      displacement: (i) => Math.hypot(x[i], y[i], z[i]),
      safety_factor_node: (i) => Math.min(LARGEST_FACTOR, this.strength[i] / mises(first[i], second[i], third[i])),
      contact_pressure: (i) => this.contact[i],
    }[field];
    for (let i = 0; i < out.length; i++) out[i] = of(i);
  }
}

class Envelope {
  constructor(numbers, header, surface) {
    this.header = header;
    this.fields = new Map(header.fields.map((field) => {
      const [values] = numbers.values(`envelope.${field.name}`, surface.parents);
      return [field.name, field.low ? values.map((usage) => 1 / usage) : values];
    }));
  }

  displacement(out) {
    out.fill(0);
  }

  values(field, out) {
    out.set(this.fields.get(field));
  }
}

// Fields whose sum, each times its course over the crank angle, is the stress and the displacement.
class Cycle {
  constructor(numbers, header, surface) {
    this.header = header;
    this.row = fromSteps(numbers.integers("cycle.row"));
    this.sign = numbers.integers("cycle.sign");
    const parents = this.rowParents(surface);
    [this.strength] = numbers.values("cycle.strength", parents);
    this.rows = parents.first.length;
    this.parities = ["even", "odd"].slice(0, header.modes.length).map((name) => ({
      stress: numbers.steps(`${name}.stress`, parents),
      displacement: numbers.steps(`${name}.displacement`, parents),
      courses: numbers.values(`${name}.courses`, chain(header.instants)),
      sum: new Float32Array(6 * this.rows),
      moved: new Float32Array(3 * this.rows),
    }));
    this.principal = [0, 1, 2].map(() => new Float32Array(surface.count));
    this.equivalent = new Float32Array(surface.count);
    this.moved = new Float32Array(3 * surface.count);
    this.angle = -1;
  }

  // The rows beside a row are those of the nodes beside the first node that shows it.
  rowParents(surface) {
    const count = this.row.reduce((most, row) => Math.max(most, row), -1) + 1;
    const parents = { first: new Int32Array(count), second: new Int32Array(count) };
    let next = 0;
    for (let node = 0; node < this.row.length; node++) {
      if (this.row[node] !== next) continue;
      const above = [surface.parents.first[node], surface.parents.second[node]].map((other) => {
        const row = other < 0 ? -1 : this.row[other];
        return row >= next ? next - 1 : row;
      });
      [parents.first[next], parents.second[next]] = above;
      next++;
    }
    return parents;
  }

  at(angle) {
    if (angle === this.angle) return;
    this.angle = angle;
    for (const parity of this.parities) {
      superpose(parity.stress, parity.courses, angle, this.rows, 6, parity.sum);
      superpose(parity.displacement, parity.courses, angle, this.rows, 3, parity.moved);
    }
    const [even, odd] = this.parities;
    const [first, second, third] = this.principal;
    const s = new Float64Array(6);
    for (let i = 0; i < this.row.length; i++) {
      const row = this.row[i], bits = this.sign[i];
      const x = bits & 1 ? -1 : 1, y = bits & 2 ? -1 : 1, z = bits & 4 ? -1 : 1;
      for (let c = 0; c < 6; c++) {
        const at = c * this.rows + row;
        s[c] = odd ? even.sum[at] + y * odd.sum[at] : even.sum[at];
      }
      for (let c = 0; c < 3; c++) {
        const at = c * this.rows + row;
        const u = odd ? even.moved[at] + y * odd.moved[at] : even.moved[at];
        this.moved[3 * i + c] = u * (c === 0 ? x : c === 1 ? y : z);
      }
      const [a, b, c] = principals(s[0], s[1], s[2], s[3] * x * y, s[4] * y * z, s[5] * x * z);
      first[i] = a;
      second[i] = b;
      third[i] = c;
      this.equivalent[i] = mises(a, b, c);
    }
  }

  displacement(out) {
    out.set(this.moved);
  }

  values(field, out) {
    const [first, second, third] = this.principal;
    const u = this.moved;
    const of = {
      von_mises: (i) => this.equivalent[i],
      principal_1: (i) => first[i],
      principal_2: (i) => second[i],
      principal_3: (i) => third[i],
      displacement: (i) => Math.hypot(u[3 * i], u[3 * i + 1], u[3 * i + 2]),
      safety_factor_node: (i) => Math.min(LARGEST_FACTOR, this.strength[this.row[i]] / this.equivalent[i]),
    }[field];
    for (let i = 0; i < out.length; i++) out[i] = of(i);
  }
}

// Sum of modes times their courses at a crank angle in degrees, linear between degrees.
function superpose({ columns, step }, courses, angle, rows, components, out) {
  const before = Math.min(Math.floor(angle), courses[0].length - 1);
  const after = Math.min(before + 1, courses[0].length - 1), share = angle - before;
  out.fill(0);
  for (let k = 0; k * components < columns.length; k++) {
    const weight = step * ((1 - share) * courses[k][before] + share * courses[k][after]);
    for (let c = 0; c < components; c++) {
      const { values, rows: own } = columns[k * components + c], start = c * rows;
      if (own) for (let i = 0; i < own.length; i++) out[start + own[i]] += weight * values[i];
      else for (let i = 0; i < rows; i++) out[start + i] += weight * values[i];
    }
  }
}

const KINDS = { case: Case, envelope: Envelope, cycle: Cycle };
