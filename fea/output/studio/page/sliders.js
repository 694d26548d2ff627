// Inputs for dimensions and operation: a slider and a number each, with how far it can go and why.

const WORDS = {
  gas_scale: ["boost: gas load", "×"], E_GPa: ["Young's modulus", "GPa"], nu: ["Poisson's ratio", ""], yield_MPa: ["yield strength", "MPa"],
  ultimate_MPa: ["ultimate strength", "MPa"], endurance_MPa: ["endurance limit", "MPa"], surface: ["surface finish", ""],
};
const THUMB = 16; // width of a slider's handle, px, as in studio.css
const upper = (text) => text.charAt(0).toUpperCase() + text.slice(1);

function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

// Where a share of a slider's way is, as CSS has it: handles stay within their slider.
const across = (share) => `calc(${THUMB / 2}px + ${Math.min(1, Math.max(0, share))} * (100% - ${THUMB}px))`;

class Sliders {
  // `changed` is called with an item, its value and whether the hand rests.
  constructor(root, changed) {
    Object.assign(this, { root, changed, items: new Map() });
  }

  lay({ dimensions, controls, ranges }) {
    this.items.clear();
    const groups = new Map();
    const add = (part, own) => {
      const [label, unit] = WORDS[own.key] ?? [own.label, own.unit];
      const item = { ...own, part, label: upper(label), unit };
      this.items.set(item.key, item);
      if (!groups.has(own.group)) groups.set(own.group, []);
      groups.get(own.group).push(item.choices?.length ? this.choice(item) : this.slider(item));
    };
    controls.filter(({ group }) => group === "operation").forEach((own) => add("operation", own));
    dimensions.forEach((own) => add("design", { ...own, low: Math.min(0.7 * own.value, ranges[own.key].low),
      high: Math.max(1.3 * own.value, ranges[own.key].high) }));
    controls.filter(({ group }) => group !== "operation").sort((a, b) => b.choices.length - a.choices.length)
      .forEach((own) => add("operation", own));
    this.root.replaceChildren(...Array.from(groups, ([name, rows]) =>
      element("details", { open: "", class: "group" }, element("summary", {}, upper(name)), ...rows)));
    this.ranges(ranges);
  }

  choice(item) {
    const id = `in-${item.key}`;
    item.select = element("select", { id }, ...(item.value ? [] : [new Option("as in the study", "")]),
      ...item.choices.map((name) => new Option(name, name)));
    item.select.addEventListener("change", () => this.changed(item, item.select.value, true));
    return element("div", { class: "row" }, element("label", { for: id }, item.label), item.select);
  }

  slider(item) {
    const id = `in-${item.key}`, step = 10 ** Math.floor(Math.log10((item.high - item.low) / 80));
    Object.assign(item, { step, digits: Math.max(0, -Math.round(Math.log10(step))), first: item.value });
    item.from = Math.floor(item.low / step) * step;
    item.to = Math.ceil(item.high / step) * step;
    const bounds = { min: item.from, max: item.to, step: "any" };
    item.range = element("input", { type: "range", id, "aria-describedby": `${id}-why`, ...bounds });
    item.number = element("input", { type: "number", step, "aria-label": `${item.label}${item.unit ? `, ${item.unit}` : ""}` });
    item.why = element("p", { class: "why", id: `${id}-why`, hidden: "" });
    item.marks = element("div", { class: "marks", "aria-hidden": "true" });
    const track = element("div", { class: "track" }, item.marks, item.range);
    const help = item.rest_only ? "counts where the pins are in contact: in the converged answer" : item.help ?? "";
    item.row = element("div", { class: "row", title: help }, element("label", { for: id }, item.label),
      element("span", { class: "number" }, item.number, element("span", { class: "unit" }, item.unit)), track, item.why);
    const take = (value, rests) => {
      this.hold(item);
      const within = this.within(item, value);
      this.write(item, within);
      this.changed(item, within, rests);
    };
    item.range.addEventListener("focus", () => this.hold(item));
    item.range.addEventListener("input", () => take(Math.round(item.range.value / step) * step, false));
    item.range.addEventListener("change", () => take(Math.round(item.range.value / step) * step, true));
    item.range.addEventListener("keydown", (event) => {
      const by = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
      if (!by) return;
      event.preventDefault();
      take(item.now + by * step, false);
      clearTimeout(item.pause);
      item.pause = setTimeout(() => take(item.now, true), 400);
    });
    item.number.addEventListener("change", () => item.number.value !== "" && take(Number(item.number.value), true));
    this.write(item, item.value);
    this.mark(item);
    return item.row;
  }

  // The nearest value that can be had, of numbers that are as round as the slider's steps.
  within(item, value) {
    const { low = item.from, high = item.to } = item.feasible ?? {};
    return Number(Math.min(high, Math.max(low, value)).toFixed(item.digits + 2));
  }

  write(item, value) {
    item.now = value;
    if (item.select) {
      item.select.value = value ?? "";
      return;
    }
    if (value < item.range.min) item.range.min = value;
    if (value > item.range.max) item.range.max = value;
    item.range.value = value;
    const said = value.toFixed(item.digits);
    if (document.activeElement !== item.number || Number(item.number.value) !== value) item.number.value = said;
    item.range.setAttribute("aria-valuetext", `${said} ${item.unit}`);
    this.reason(item);
  }

  // The reason of the slider under the hand is shown; others would move it away.
  hold(item) {
    const before = this.held;
    this.held = item;
    if (before && before !== item) this.reason(before);
    this.reason(item);
  }

  // Why it ends here, at either end of what can be had.
  reason(item) {
    const { low, high, low_reason: below, high_reason: above } = item.feasible ?? {};
    const near = 0.51 * item.step;
    const why = below && item.now <= low + near ? below : above && item.now >= high - near ? above : "";
    item.why.hidden = !why || item !== this.held;
    item.why.textContent = why && `Ends here: ${why}`;
    item.row.classList.toggle("ended", Boolean(why));
  }

  // Values of a design: those that were changed, else those of the last answer, else those of the study.
  set(state, known = {}) {
    for (const item of this.items.values()) {
      const value = state[item.part][item.key] ?? (item.part === "operation" ? known[item.key] : undefined) ?? item.value;
      if (value !== item.now) this.write(item, value);
    }
  }

  ranges(found) {
    for (const [key, range] of Object.entries(found)) {
      const item = this.items.get(key);
      if (!item) continue;
      item.feasible = range;
      this.mark(item);
      this.reason(item);
    }
  }

  // What cannot be had, how far the mesh follows, and where the study began.
  mark(item) {
    const low = Number(item.range.min), high = Number(item.range.max), share = (value) => (value - low) / (high - low);
    const { feasible } = item, marks = [];
    const band = (name, from, to) => {
      const own = element("i", { class: name });
      own.style.left = across(share(from));
      own.style.right = `calc(100% - ${across(share(to))})`;
      marks.push(own);
    };
    const tick = (name, at) => {
      if (at === null || at === undefined || at <= low || at >= high) return;
      const own = element("i", { class: name });
      own.style.left = across(share(at));
      marks.push(own);
    };
    band("can", feasible?.low ?? low, feasible?.high ?? high);
    if (feasible && feasible.covered_low !== null) band("covered", feasible.covered_low, feasible.covered_high);
    tick("first", item.first);
    if (feasible) {
      if (feasible.reach_low > feasible.low) tick("reach", feasible.reach_low);
      if (feasible.reach_high < feasible.high) tick("reach", feasible.reach_high);
    }
    item.marks.replaceChildren(...marks);
  }
}
