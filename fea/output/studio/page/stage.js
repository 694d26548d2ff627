// From dark to light, read by the colour-blind: cividis without its darkest part (Nuñez et al. 2018).
const EVEN = [[49, 68, 107], [87, 93, 109], [112, 113, 115], [138, 134, 120], [166, 157, 117], [196, 181, 108], [228, 207, 91], [254, 232, 56]];

// Colours of so many bands between those of a scheme.
function between(scheme, count) {
  return Array.from({ length: count }, (_, band) => {
    const at = count > 1 ? (band / (count - 1)) * (scheme.length - 1) : 0, k = Math.min(Math.floor(at), scheme.length - 2);
    const mixed = scheme[k].map((low, c) => Math.round(low + (at - k) * (scheme[k + 1][c] - low)));
    return `#${mixed.map((part) => part.toString(16).padStart(2, "0")).join("")}`;
  });
}

// The rod as it is now: the same triangles at new places until another mesh comes.

class Stage {
  constructor() {
    const get = (id) => document.getElementById(id);
    Object.assign(this, { canvas: get("canvas"), ring: get("ring"), note: get("probe"), box: get("legend"), veil: get("veil") });
    this.painted = 0;
    this.lines = false;
    this.hot = null;
    get("mesh").addEventListener("change", ({ target }) => {
      this.lines = target.checked;
      this.repaint();
    });
    this.even = get("even");
    this.even.addEventListener("change", () => {
      this.key();
      this.repaint();
    });
    get("home").addEventListener("click", () => this.home());
    new ResizeObserver(() => this.resize()).observe(this.canvas);
  }

  // Triangles of a mesh, which the next frame gives places.
  mesh(triangles) {
    this.triangles = triangles;
    this.surface = null;
  }

  show({ places, values }, field, hot) {
    this.values = values;
    this.own = field;
    this.hot = hot;
    if (!this.surface) this.begin(places);
    for (let i = 0; i < places.length; i++) this.moved[i] = places[i] - this.surface.positions[i];
    this.painter.move(this.moved);
    this.painter.colour(values);
    this.key();
    this.repaint();
  }

  // The legend, and the colours that are asked for.
  key() {
    if (!this.own) return;
    const { own, even: { checked } } = this, key = `${own.labels.join()} ${own.above} ${checked}`;
    this.field = checked ? { ...own, colours: between(EVEN, own.colours.length) } : own;
    if (this.box.dataset.of !== key) drawLegend(this.box, this.field);
    this.box.dataset.of = key;
  }

  begin(places) {
    const lines = new Uint8Array(4 * this.triangles.length).fill(1);
    this.surface = new Surface(places.slice(), this.triangles, lines);
    this.moved = new Float32Array(places.length);
    this.picker = new Picker(this.surface);
    const before = this.camera?.state();
    this.camera ??= this.firstCamera();
    this.camera.positions = this.surface.positions;
    if (this.painter) {
      this.painter.release();
      this.painter.surface = this.surface;
      this.painter.prepare();
    } else {
      this.painter = new Painter(this.canvas, this.surface);
    }
    if (before) this.camera.set(before);
    this.resize();
  }

  firstCamera() {
    const camera = new Camera(this.surface.positions);
    camera.aspect = this.canvas.clientWidth / Math.max(1, this.canvas.clientHeight);
    camera.home();
    hands(this.canvas, camera, {
      changed: () => this.repaint(),
      probe: (share) => this.probe(share),
      home: () => this.home(),
    });
    return camera;
  }

  home() {
    this.camera?.home();
    this.repaint();
  }

  resize() {
    const { canvas, camera } = this, ratio = Math.min(window.devicePixelRatio || 1, 2);
    canvas.width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    canvas.height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (!camera) return;
    const before = camera.aspect;
    camera.aspect = canvas.width / canvas.height;
    if (before >= 0.9 !== camera.aspect >= 0.9 || Math.abs(before / camera.aspect - 1) > 0.3) camera.home();
    this.repaint();
  }

  repaint() {
    if (this.waiting || !this.surface) return;
    this.waiting = requestAnimationFrame(() => {
      this.waiting = null;
      this.aimed = false;
      this.painter.draw(this.camera, { field: this.field, scale: 1, mesh: this.lines, ink: [0.1, 0.1, 0.12] });
      this.mark();
      this.painted++;
    });
  }

  // A ring around the place that governs.
  mark() {
    this.ring.hidden = !this.hot;
    if (!this.hot) return;
    const [x, y] = this.camera.seen(this.hot);
    this.ring.style.left = `${100 * x}%`;
    this.ring.style.top = `${100 * y}%`;
    this.ring.hidden = x < 0 || x > 1 || y < 0 || y > 1;
  }

  probe(share) {
    this.note.hidden = true;
    if (!share || !this.surface) return;
    if (!this.aimed) this.picker.aim(this.camera, this.moved, 1);
    this.aimed = true;
    const hit = this.picker.at(2 * share[0] - 1, 1 - 2 * share[1]);
    if (!hit) return;
    const value = hit.nodes.reduce((sum, node, k) => sum + hit.weights[k] * this.values[node], 0);
    this.note.hidden = false;
    this.note.textContent = Number.isNaN(value) ? "not solved here" : `${signed(value * this.field.factor)} ${this.field.unit}`;
    this.note.style.left = `${100 * Math.min(0.72, share[0])}%`;
    this.note.style.top = `${100 * Math.max(0.08, share[1])}%`;
  }

  // Where rod and figures are not those of the sliders, say so.
  cover(text) {
    this.veil.hidden = !text;
    this.veil.textContent = text;
    document.body.classList.toggle("old", Boolean(text));
  }
}

const signed = (value) => value.toLocaleString("en", { maximumSignificantDigits: 4, useGrouping: false }).replace("-", "−");
