// The rod and its controls.

class Viewer {
  constructor(root, header, numbers) {
    this.root = root;
    this.header = header;
    this.canvas = root.querySelector("canvas");
    this.surface = unpackedSurface(numbers, header);
    this.painter = new Painter(this.canvas, this.surface);
    this.camera = new Camera(this.surface.positions);
    this.picker = new Picker(this.surface);
    this.loads = new Loads(header);
    this.results = new Map(header.results.map((own) => [own.id, new KINDS[own.kind](numbers, own, this.surface)]));
    this.charts = new Charts(header.charts ?? []);
    this.films = (header.films ?? []).map((film) => new FilmMap(film, numbers, header.shown.length));
    this.values = new Float32Array(this.surface.count);
    this.moved = new Float32Array(3 * this.surface.count);
    this.shown = { ...header.first, angle: 0, scale: header.exaggeration, mesh: false, loads: true, spot: null };
    this.part = (name) => root.querySelector(`[data-part="${name}"]`);
    this.wire();
    this.resize();
    this.camera.home();
    this.choose(header.first.result);
  }

  wire() {
    const { part } = this;
    hands(this.canvas, this.camera, {
      changed: () => this.repaint(),
      probe: (share) => this.probe(share),
      home: () => this.home(),
    });
    for (const input of this.root.querySelectorAll('input[name="result"]')) {
      input.addEventListener("change", () => this.choose(input.value));
    }
    part("field").addEventListener("change", (event) => this.show({ field: event.target.value }));
    part("scale").addEventListener("change", (event) => this.show({ scale: Number(event.target.value) }));
    part("mesh").addEventListener("change", (event) => this.show({ mesh: event.target.checked }));
    part("loads").addEventListener("change", (event) => this.show({ loads: event.target.checked }));
    part("home").addEventListener("click", () => this.home());
    this.root.querySelectorAll("[data-spot]").forEach((button) => {
      button.addEventListener("click", () => {
        this.fly(this.header.spots[Number(button.dataset.spot)]);
        this.canvas.scrollIntoView({ block: "nearest" });
      });
    });
    const slider = part("angle");
    if (slider) {
      slider.addEventListener("input", () => {
        this.pause();
        this.turn(Number(slider.value));
      });
      part("play").addEventListener("click", () => (this.playing ? this.pause() : this.play()));
    }
    const turned = document.getElementById("film-angle");
    if (turned) {
      document.getElementById("films").hidden = false;
      turned.addEventListener("input", () => {
        this.pause();
        if (this.results.has("cycle")) this.turn(Number(turned.value));
        else this.crank(Number(turned.value));
      });
    }
    new ResizeObserver(() => {
      this.resize();
      this.repaint();
    }).observe(this.canvas);
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.repaint());
    this.canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    this.canvas.addEventListener("webglcontextrestored", () => {
      this.painter.prepare();
      this.show({});
    });
  }

  get result() {
    return this.results.get(this.shown.result);
  }

  get field() {
    const { fields } = this.result.header;
    return fields.find((field) => field.name === this.shown.field) ?? fields[0];
  }

  choose(id) {
    this.pause();
    const { kind, angle } = this.results.get(id).header;
    const changes = { result: id, spot: null };
    if (kind === "case" && angle !== null) changes.angle = angle;
    this.show(changes);
  }

  // Show an instant of the cycle.
  turn(angle) {
    this.show({ result: "cycle", angle, spot: this.shown.result === "cycle" ? this.shown.spot : null });
  }

  // What beside the rod follows the crank angle.
  crank(angle) {
    for (const own of [this.charts, ...this.films]) own.at(angle);
    const turned = document.getElementById("film-angle");
    if (!turned) return;
    turned.value = Math.round(angle);
    turned.nextElementSibling.textContent = `${Math.round(angle)}°`;
  }

  play() {
    this.playing = true;
    this.part("play").textContent = "Pause";
    let before = null;
    const step = (now) => {
      if (!this.playing) return;
      const angle = (this.shown.angle + (before === null ? 0 : (now - before) * 0.09)) % this.header.last;
      before = now;
      this.turn(angle);
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  pause() {
    if (!this.playing) return;
    this.playing = false;
    this.part("play").textContent = "Play";
    this.turn(Math.round(this.shown.angle) % (this.header.last + 1));
  }

  show(changes) {
    Object.assign(this.shown, changes);
    const { result, field } = this;
    this.shown.field = field.name;
    if (result.at) result.at(this.shown.angle);
    result.values(field.name, this.values);
    result.displacement(this.moved);
    this.painter.colour(this.values);
    this.painter.move(this.moved);
    this.sayResult();
    this.legend(field);
    this.repaint();
  }

  repaint() {
    if (this.waiting) return;
    this.waiting = requestAnimationFrame(() => {
      this.waiting = null;
      this.paint();
    });
  }

  paint() {
    const style = getComputedStyle(this.root);
    const colour = (name) => rgb(style.getPropertyValue(name).trim());
    const { result, shown, camera } = this;
    const tint = colour("--load");
    const { solids, labels } = shown.loads
      ? this.loads.drawn(result.header, shown.angle, camera, tint, this.touching, this.filmed)
      : { solids: [], labels: [] };
    this.painter.load(solids);
    this.painter.draw(camera, { field: this.field, scale: this.scale, mesh: shown.mesh, ink: [0.1, 0.1, 0.12] });
    this.picker.aim(camera, this.moved, this.scale);
    this.label(labels);
    this.markSpot();
    this.painted = (this.painted ?? 0) + 1;
  }

  // Whether the result has no displacement.
  get still() {
    const { kind, moves } = this.result.header;
    return kind === "envelope" || moves === false;
  }

  // The oil films that press on the bores; none at rest.
  get filmed() {
    return this.header.pressure.kind === "oil-film" && this.result.header.id !== "gas" ? this.films : [];
  }

  get touching() {
    const { contact } = this.result;
    return contact ? { values: contact, positions: this.surface.positions } : null;
  }

  get scale() {
    return this.still ? 0 : this.shown.scale;
  }

  resize() {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    this.canvas.width = Math.max(1, Math.round(this.canvas.clientWidth * ratio));
    this.canvas.height = Math.max(1, Math.round(this.canvas.clientHeight * ratio));
    const before = this.camera.aspect;
    this.camera.aspect = this.canvas.width / this.canvas.height;
    if (before >= 0.9 !== this.camera.aspect >= 0.9 || Math.abs(before / this.camera.aspect - 1) > 0.3) this.camera.home();
  }

  home() {
    this.shown.spot = null;
    const from = this.camera.state();
    this.camera.home();
    this.glide(from, this.camera.state());
  }

  // Fly to a place, to a side from which it is seen; half the height that is seen then, over the rod's length.
  fly(spot, half = 0.11) {
    this.pause();
    const changes = { result: spot.result, field: spot.field, spot: this.surface.nearest(spot.at) };
    const { kind, angle } = this.results.get(spot.result).header;
    if (spot.angle !== undefined && spot.angle !== null) changes.angle = spot.angle;
    else if (kind === "case" && angle !== null) changes.angle = angle;
    this.show(changes);
    const from = this.camera.state(), place = this.placeOf(changes.spot);
    const normal = unit(Array.from(this.surface.nodeNormals.subarray(3 * changes.spot, 3 * changes.spot + 3)));
    this.camera.look(this.towards(normal, place));
    this.glide(from, { ...this.camera.state(), middle: place, half: half * this.camera.extent });
  }

  towards(normal, place) {
    const facing = [];
    for (let slant = -40; slant <= 40; slant += 10) {
      for (let around = -180; around < 180; around += 15) {
        const [a, b] = [rad(slant), rad(around)];
        const way = [Math.sin(a), Math.cos(a) * Math.sin(b), Math.cos(a) * Math.cos(b)];
        if (dot(way, normal) > 0.15) facing.push([2 * dot(way, normal) + dot(way, USUAL), way]);
      }
    }
    facing.sort((a, b) => b[0] - a[0]);
    for (const [, way] of facing.slice(0, 40)) {
      this.camera.look(way);
      this.camera.middle = place;
      this.picker.aim(this.camera, this.moved, this.scale);
      const hit = this.picker.at(0, 0);
      if (!hit || hit.depth < 0.004 * this.camera.extent) return way;
    }
    return facing.length ? facing[0][1] : USUAL;
  }

  glide(from, to) {
    if (window.matchMedia("(prefers-reduced-motion: reduce)").matches) {
      this.camera.set(to);
      this.repaint();
      return;
    }
    const start = performance.now();
    const flight = (this.flight = {});
    this.camera.set(from);
    const step = (now) => {
      if (this.flight !== flight) return;
      const t = Math.min(1, Math.max(0, (now - start) / 600));
      this.camera.set(Camera.between(from, to, t * t * (3 - 2 * t)));
      this.repaint();
      if (t < 1) requestAnimationFrame(step);
      else this.camera.set(to);
    };
    requestAnimationFrame(step);
  }

  placeOf(node) {
    return plus(this.surface.place(node), Array.from(this.moved.subarray(3 * node, 3 * node + 3)), this.scale);
  }

  where(place) {
    const { unit, factor, digits } = this.header.shown.length;
    return `${place.map((at) => fixed(factor * at, digits)).join(", ")} ${unit}`;
  }

  said(value) {
    const { unit, low, factor } = this.field;
    if (Number.isNaN(value)) return "not judged";
    const digits = low ? value.toFixed(2) : signed(factor * value);
    return unit ? `${digits} ${unit}` : digits;
  }

  // The value at a share (x, y) of the canvas, interpolated as its colour is; null beside the rod.
  valueAt(share) {
    const hit = this.picker.at(2 * share[0] - 1, 1 - 2 * share[1]);
    if (!hit) return null;
    const mean = (values, stride = 1, k = 0) =>
      hit.nodes.reduce((sum, node, n) => sum + hit.weights[n] * values[stride * node + k], 0);
    return { value: mean(this.values), place: [0, 1, 2].map((k) => mean(this.surface.positions, 3, k)) };
  }

  probe(share) {
    const note = this.part("probe");
    const found = share && this.valueAt(share);
    note.hidden = !found;
    if (!found) return;
    note.textContent = `${this.said(found.value)} at ${this.where(found.place)}`;
    note.style.left = `${100 * Math.min(0.72, share[0])}%`;
    note.style.top = `${100 * Math.max(0.08, share[1])}%`;
  }

  sayResult() {
    const { header } = this.result, { part, shown } = this, { field } = this;
    for (const input of this.root.querySelectorAll('input[name="result"]')) input.checked = input.value === shown.result;
    const select = part("field");
    if (select.dataset.of !== header.id) {
      select.replaceChildren(...header.fields.map((own) => new Option(own.label, own.name)));
      select.dataset.of = header.id;
    }
    select.value = field.name;
    part("scale").value = String(shown.scale);
    part("scale").disabled = this.still;
    const slider = part("angle");
    const angle = header.kind === "envelope" ? "" : header.kind === "case" && header.angle === null ? ""
      : `, crank angle ${shown.angle.toFixed(header.kind === "case" ? 1 : 0)}°`;
    if (slider) {
      slider.value = Math.round(shown.angle);
      part("angle-now").textContent = header.kind === "envelope" ? "–" : `${Math.round(shown.angle)}°`;
      slider.setAttribute("aria-valuetext", `${Math.round(shown.angle)} degrees`);
    }
    if (header.kind === "cycle" || (header.kind === "case" && header.angle !== null)) this.crank(shown.angle);
    const worst = this.worst(field), place = this.where(this.surface.place(worst));
    const away = field.away ? " (away from places where the elastic stress is infinite)" : "";
    const most = field.low ? "least" : field.name === "principal_3" ? "lowest" : "largest";
    const size = this.still || shown.scale === 0 ? "not deformed" : `deformation × ${shown.scale}`;
    const text = `${header.title}${angle}: ${field.label}, ${most} ${this.said(this.values[worst])} at ` +
      `x, y, z = ${place}${away}; ${size}.`;
    const caption = part("caption");
    if (!this.playing) caption.textContent = text;
    this.canvas.setAttribute("aria-label", `The rod in three dimensions. ${text}`);
  }

  // The node of the worst value: where the stress is infinite in theory, that of the peak that counts.
  worst(field) {
    if (field.away) return this.surface.nearest(field.away);
    const down = field.low || field.name === "principal_3";
    let best = 0;
    for (let i = 1; i < this.values.length; i++) {
      const [a, b] = [this.values[i], this.values[best]];
      if (Number.isNaN(b) || (down ? a < b : a > b)) best = i;
    }
    // Of places that mirror each other, the one that the tables name.
    const named = this.header.spots.find((spot) => spot.result === this.shown.result && spot.field === field.name);
    if (!named) return best;
    const there = this.surface.nearest(named.at), size = Math.abs(this.values[best]);
    return Math.abs(this.values[there] - this.values[best]) < 2e-3 * size ? there : best;
  }

  legend(field) {
    const box = this.part("legend");
    if (box.dataset.of === `${this.shown.result} ${field.name}`) return;
    box.dataset.of = `${this.shown.result} ${field.name}`;
    drawLegend(box, field);
  }

  label(labels) {
    const box = this.part("labels");
    while (box.children.length < labels.length) box.append(document.createElement("span"));
    Array.from(box.children).forEach((span, k) => {
      span.hidden = k >= labels.length;
      if (span.hidden) return;
      const [x, y] = this.camera.seen(labels[k].at);
      span.hidden = x < -0.1 || x > 1.1 || y < -0.1 || y > 1.1;
      span.textContent = labels[k].text;
      const aside = Math.min(0.2, 34 / Math.max(1, this.canvas.clientWidth));
      span.style.left = `${100 * Math.min(1 - aside, Math.max(aside, x))}%`;
      span.style.top = `${100 * Math.min(0.97, Math.max(0.03, y))}%`;
    });
  }

  markSpot() {
    const ring = this.part("ring");
    ring.hidden = this.shown.spot === null;
    if (ring.hidden) return;
    const [x, y] = this.camera.seen(this.placeOf(this.shown.spot));
    ring.style.left = `${100 * x}%`;
    ring.style.top = `${100 * y}%`;
    ring.hidden = x < 0 || x > 1 || y < 0 || y > 1;
  }
}
