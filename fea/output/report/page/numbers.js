// The packed numbers of the page: base64, deflate, differences from a prediction (see coding.py).

const HOLE = 65535;

async function unpacked(text) {
  const letters = atob(text.trim());
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i++) bytes[i] = letters.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

class Numbers {
  constructor(bytes, entries) {
    this.bytes = bytes;
    this.entries = new Map();
    let offset = 0;
    for (const entry of entries) {
      this.entries.set(entry.name, { ...entry, offset });
      offset += entry.kind === "integers" ? 4 * entry.count : 2 * entry.count * entry.columns;
    }
    if (offset !== bytes.length) throw new Error("the numbers of this page are damaged");
  }

  has(name) {
    return this.entries.has(name);
  }

  integers(name) {
    const { count, offset } = this.entries.get(name);
    const found = new Uint32Array(count);
    for (let plane = 0; plane < 4; plane++) {
      for (let i = 0; i < count; i++) found[i] |= this.bytes[offset + plane * count + i] << (8 * plane);
    }
    return found;
  }

  // One column as 16-bit numbers; parents are two Int32Arrays, -1 where there is none.
  column(entry, k, parents) {
    const { count, offset } = entry;
    const low = offset + 2 * k * count;
    const high = low + count;
    const found = new Uint16Array(count);
    for (let i = 0; i < count; i++) {
      const zigzag = this.bytes[low + i] | (this.bytes[high + i] << 8);
      const first = parents.first[i];
      const predicted = first < 0 ? 0 : (found[first] + found[parents.second[i]]) >> 1;
      found[i] = predicted + ((zigzag >>> 1) ^ -(zigzag & 1));
    }
    return found;
  }

  // Columns as numbers, NaN where there is none.
  values(name, parents) {
    const entry = this.entries.get(name);
    return Array.from({ length: entry.columns }, (_, k) => {
      const steps = this.column(entry, k, parents);
      return Float32Array.from(steps, (q) => (q === HOLE ? NaN : entry.low + entry.step * q));
    });
  }

  // Columns as whole multiples of `step`; of those that are mostly zero, only the others, with their rows.
  steps(name, parents) {
    const entry = this.entries.get(name);
    const columns = Array.from({ length: entry.columns }, (_, k) => {
      const values = Int16Array.from(this.column(entry, k, parents), (q) => q - 32768);
      const rows = Int32Array.from(values.keys()).filter((i) => values[i] !== 0);
      return 3 * rows.length > values.length ? { values } : { rows, values: Int16Array.from(rows, (i) => values[i]) };
    });
    return { columns, step: entry.step };
  }
}

const chain = (count) => {
  const before = Int32Array.from({ length: count }, (_, i) => i - 1);
  return { first: before, second: before };
};

// Numbers in the order of their first use, from their distances below the next unused one.
function fromSteps(steps) {
  const found = new Int32Array(steps.length);
  let next = 0;
  for (let i = 0; i < steps.length; i++) {
    found[i] = next - steps[i];
    if (steps[i] === 0) next++;
  }
  return found;
}
