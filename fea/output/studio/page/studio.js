// The page: it asks, and shows what comes back with the design that it is of.

const RANK = { interpolated: 0, "exact on a moved mesh": 1, converged: 2 };
const LATE = 700; // ms without a new picture after which the one that is there is marked as an earlier one

class StudioPage {
  constructor() {
    const get = (id) => document.getElementById(id);
    this.get = get;
    this.state = { design: {}, operation: {} };
    this.session = { variants: {} };
    Object.assign(this, { serial: 0, shown: null, touched: "", asking: null, meshes: new Map(), drawn: null, dropped: 0 });
    this.sliders = new Sliders(get("groups"), (item, value, rests) => this.change(item, value, rests));
    this.panel = new AnswerPanel();
    this.variants = new Variants(get("compare"), {
      go: (name) => this.say("go", { name, serial: ++this.serial }),
      remove: (name) => this.say("remove", { name }),
      save: (name) => this.say("export", { what: "study", name }),
    });
    this.wire = null;
    try {
      this.stage = new Stage();
    } catch (error) {
      this.note(error.message, true);
    }
    this.listen();
    this.wire = new Wire((kind, told) => this[`on_${kind}`]?.(told), (code) => this.lost(code));
  }

  say(what, told) {
    this.wire.say(what, told);
  }

  listen() {
    const { get } = this;
    get("undo").addEventListener("click", () => this.move(-1));
    get("redo").addEventListener("click", () => this.move(1));
    document.addEventListener("keydown", (event) => {
      const key = event.key.toLowerCase();
      if (!(event.ctrlKey || event.metaKey) || event.altKey || (key !== "z" && key !== "y")) return;
      if (event.target.id === "variant-name") return;
      event.preventDefault();
      this.move(key === "y" || event.shiftKey ? 1 : -1);
    });
    for (const button of document.querySelectorAll("[data-export]")) {
      button.addEventListener("click", () => {
        button.closest("details")?.removeAttribute("open");
        this.say("export", { what: button.dataset.export });
      });
    }
    get("keep").addEventListener("submit", (event) => {
      event.preventDefault();
      const input = get("variant-name"), name = input.value.trim() || input.placeholder;
      this.say("keep", { name });
      this.panel.from(`“${name}”`, this.state);
      if (this.current && RANK[this.shown.label]) this.panel.show(this.shown, this.described(this.state));
      input.value = "";
    });
    get("lighten").addEventListener("click", () => {
      get("tried").replaceChildren();
      this.say("lighten");
    });
    get("stop").addEventListener("click", () => this.say("stop"));
    get("field").addEventListener("change", () => this.ask(true));
  }

  move(by) {
    if (this.get(by < 0 ? "undo" : "redo").disabled) return;
    this.say("move", { by, serial: ++this.serial });
  }

  // An input has changed. While it is moved, one request for each picture of the screen is enough.
  change(item, value, rests) {
    const { design, operation } = this.state;
    this.state = { design: { ...design }, operation: { ...operation } };
    const own = this.state[item.part];
    own[item.key] = value;
    if (value === "" || (value === item.value && !item.select)) delete own[item.key];
    this.touched = item.part === "design" ? item.key : "";
    if (item.key === "material") for (const other of this.sliders.items.values()) if (other.group === "material" && other.range) delete own[other.key];
    if (rests) this.ask(true);
    else this.asking ??= requestAnimationFrame(() => this.ask(false));
  }

  ask(rests) {
    if (this.asking) cancelAnimationFrame(this.asking);
    this.asking = null;
    const told = { serial: ++this.serial, state: this.state, rests, field: this.get("field").value };
    this.say("ask", { ...told, touched: rests ? "" : this.touched });
    this.expect();
  }

  on_hello({ serial, layout, doing }) {
    this.serial = Math.max(this.serial, serial);
    this.fresh = true;
    this.get("message").hidden = true;
    if (layout.title) {
      this.layout = layout;
      this.panel.required = layout.required;
      this.get("required").textContent = `· required safety factor ${layout.required.toFixed(2)}`;
      this.sliders.lay(layout);
      this.get("lighten").hidden = !layout.dimensions.length;
    }
    if (doing !== undefined) this.on_doing({ what: doing });
  }

  on_session({ serial, ...session }) {
    this.session = session;
    this.get("undo").disabled = !session.undo;
    this.get("redo").disabled = !session.redo;
    this.get("variant-name").placeholder = `variant ${Object.keys(session.variants).length + 1}`;
    if (serial === this.serial) this.expect();
    if (this.fresh || serial === this.serial) {
      this.state = { design: session.design, operation: session.operation };
      if (this.layout) this.sliders.set(this.state, this.shown?.operation);
      if (this.layout) this.fresh = false;
    }
    this.compare();
  }

  compare() {
    const now = { state: this.state, answer: this.current && this.shown.figures ? this.shown : null };
    if (this.layout) this.variants.show(now, this.session.variants, this.sliders.items);
  }

  // Whether what is shown is of the design at hand.
  get current() {
    return Boolean(this.shown) && JSON.stringify(this.shown.state) === JSON.stringify(this.state);
  }

  on_mesh({ header, numbers, buffer }) {
    this.meshes.set(header.mesh, new Uint32Array(buffer, numbers));
    if (this.meshes.size > 4) this.meshes.delete(this.meshes.keys().next().value);
  }

  on_frame(message) {
    const { header } = message, { shown } = this;
    const stale = header.serial > this.serial || (shown && header.serial < shown.serial);
    const worse = shown && header.serial === shown.serial && RANK[header.label] < RANK[shown.label];
    if (stale || worse) {
      this.dropped++;
      return;
    }
    this.shown = header;
    const fields = fieldsOf(message);
    if (fields) {
      if (this.drawn !== header.mesh) this.stage.mesh(this.meshes.get(header.mesh));
      this.drawn = header.mesh;
      const worst = header.figures[header.figures.governs];
      const governing = header.figures.cases.find(({ name }) => name === header.figures.governing);
      this.stage.show(fields, header.field, worst.at_mm ?? governing?.at_mm ?? null);
      this.fields(header.figures.cases);
      if (!this.panel.since) this.panel.from("the first design", header.state);
    }
    this.panel.show(header, this.described(header.state));
    if (fields) this.uncover();
    if (this.current) {
      if (!fields) this.stage.cover("an earlier design: let go, and this one is solved at once");
      if (RANK[header.label]) {
        this.sliders.set(this.state, header.operation);
        this.compare();
      }
    } else if (fields) {
      this.expect();
    }
  }

  // A design is asked about: where no picture comes soon, the one that is there is marked as an earlier one.
  expect() {
    this.late ??= setTimeout(() => this.stage.cover("an earlier design: this one is being solved"), LATE);
  }

  uncover() {
    clearTimeout(this.late);
    this.late = null;
    this.stage.cover("");
  }

  // What a design changes in the study, in words.
  described({ design, operation }) {
    if (!this.layout) return "";
    const said = [];
    for (const item of this.sliders.items.values()) {
      const value = { design, operation }[item.part][item.key];
      if (value !== undefined) said.push(`${item.label.toLowerCase()} ${item.select ? value : value.toFixed(item.digits)} ${item.unit}`.trim());
    }
    return said.length ? `With ${said.join(", ")}.` : "The study as it is.";
  }

  fields(cases) {
    const select = this.get("field"), names = cases.map(({ name }) => name);
    if (select.options.length === names.length + 1) return;
    select.replaceChildren(select.options[0], ...names.map((name) => new Option(upper(name), name)));
  }

  on_ranges({ serial, ranges }) {
    if (serial <= this.serial) this.sliders.ranges(ranges);
  }

  on_sampling({ share }) {
    this.panel.solving = share;
    this.get("label").textContent = this.panel.labelled(this.shown ?? {});
  }

  on_refused({ serial, text }) {
    if (serial !== this.serial) return;
    this.uncover();
    this.stage.cover("an earlier design: this one cannot be solved");
    this.note(text, true);
  }

  on_note({ text, bad }) {
    this.note(text, bad);
  }

  on_written({ path, text }) {
    const runs = path.endsWith(".toml") ? ` Run it with: fea run ${path}` : "";
    this.note(`Wrote ${path}.${runs} `, false);
    if (!text) return;
    const link = element("a", { download: path.split(/[\\/]/).pop(), href: URL.createObjectURL(new Blob([text])) }, "Download a copy");
    this.get("message").append(link);
  }

  on_tried({ design }) {
    const { mass_kg: mass, margin, governs, count, most } = design, holds = margin >= 0;
    const said = `${count} of at most ${most}: ${(1000 * mass).toFixed(1)} g, ${holds ? "meets the factors" : `lacks ${(-100 * margin).toFixed(1)} %`} (${governs})`;
    const list = this.get("tried"), look = element("button", { type: "button" }, "Look");
    look.addEventListener("click", () => {
      this.state = design.state;
      this.sliders.set(this.state, this.shown?.operation);
      this.ask(true);
    });
    list.hidden = false;
    list.prepend(element("li", { class: holds ? "holds" : "fails" }, said, " ", look));
  }

  on_doing({ what }) {
    const words = { converge: "a fresh mesh is being refined", lighten: "lighter rods are being tried", report: "the report is being made",
      step: "the solid is being written", study: "", table: "", "": "" }[what];
    document.body.dataset.doing = words;
    this.get("doing").textContent = words && `${upper(words)} …`;
    this.get("stop").hidden = !["lighten", "report"].includes(what);
    this.get("lighten").disabled = what === "lighten";
  }

  note(text, bad) {
    const box = this.get("message");
    box.textContent = text;
    box.classList.toggle("bad", Boolean(bad));
    box.hidden = false;
  }

  lost(code) {
    this.note(code === 4000 ? "This design was opened in another tab, which has taken over." :
      "The connection to fea studio is lost. If the command has ended, start it again: the session is kept.", true);
  }
}

// For scripts and tests.
window.feaStudio = new StudioPage();
