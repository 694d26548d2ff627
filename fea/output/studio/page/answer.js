// The answer: mass and safety factors with their bars, and which design they are of.

const MODES = [["yielding", "Yielding"], ["fatigue", "Fatigue"], ["buckling", "Buckling"], ["bolts", "Bolts and joint"]];
const KNOWN = { interpolated: "Interpolated", "exact on a moved mesh": "Exact on a moved mesh", converged: "Converged" };
const PINS = { contact: "pins in contact", bonded: "pins bonded", "oil-film": "crank pin in oil" };
// What is solved: whether in one piece, and what loads the bores.
const loading = ({ pins, one_piece: onePiece, corrected }) =>
  `${onePiece ? "in one piece, " : ""}${PINS[pins] ?? `prescribed pressure ${pins}`}${corrected ? ", corrected from a prescribed pressure" : ""}`;
// Answers are compared where the same is solved.
const alike = ({ pins, one_piece: onePiece }) => `${pins} ${Boolean(onePiece)}`;
const two = (value) => (value >= 100 ? "> 100" : value.toFixed(2));

// A factor and how far it may be off: the bar is of the stress behind it.
// A bar of 100 % of the stress leaves the factor without an upper end.
function bounds({ factor, low, high }) {
  return { factor, low, high: high ?? Infinity };
}

function verdict({ low, high }, required) {
  return low >= required ? ["holds", "met"] : high < required ? ["fails", "not met"] : ["open", "undecided"];
}

class AnswerPanel {
  constructor() {
    const get = (id) => document.getElementById(id);
    Object.assign(this, { root: get("cards"), of: get("of"), governs: get("governs"), said: get("said"), label: get("label"), mini: get("mini") });
    this.required = 1;
    this.solving = NaN; // share of the rods that are solved around a design
    this.since = null;
  }

  // The design from which differences count; its figures are kept by what loads the pins, which must be alike.
  from(name, state) {
    this.since = { name, state: JSON.stringify(state), figures: {} };
  }

  show(header, design) {
    const { figures } = header;
    this.onePiece = header.one_piece;
    if (header.label !== "interpolated") this.solving = NaN;
    this.now = JSON.stringify(header.state);
    this.label.textContent = this.labelled(header);
    this.label.dataset.label = figures ? header.label : "none";
    // The figures of the last design stay, with that design, until there are others.
    if (!figures) return;
    this.of.textContent = design;
    if (this.since?.state === JSON.stringify(header.state)) this.since.figures[alike(header)] = figures;
    const before = this.since?.figures[alike(header)] ?? {};
    this.root.replaceChildren(this.mass(figures, before),
      ...MODES.filter(([mode]) => mode !== "bolts" || figures.bolts).map(([mode, name]) => this.card(name, figures[mode], before[mode], figures.governs === mode, mode === "fatigue" ? figures.life : "")));
    const worst = figures[figures.governs], peak = figures.cases.find(({ name }) => name === figures.governing);
    const [what, where] = figures.governs === "bolts" ? [worst.where, ""] : [figures.governs, worst.where && `, ${worst.where}`];
    const stress = peak ? ` Largest stress: ${peak.peak_MPa.toFixed(0)} MPa in ${peak.name}, ${peak.where}.` : "";
    const failed = figures.failed.length ? ` Not to be trusted: failed ${figures.failed.length > 1 ? "checks" : "check"} ${figures.failed.join(", ")}.` : "";
    this.governs.textContent = `${upper(what)} governs${where}.${stress}${failed}`;
    const there = MODES.filter(([mode]) => figures[mode]);
    this.mini.textContent = [`${(1000 * figures.mass_kg).toFixed(0)} g`,
      ...there.map(([mode, name]) => `${name.toLowerCase()} ${two(figures[mode].factor)}`)].join(" · ");
    if (header.label === "interpolated") return;
    const factors = there
      .map(([mode, name]) => `${name.toLowerCase()} ${two(figures[mode].factor)}, ${this.verdict(bounds(figures[mode]))[1]}`);
    this.said.textContent = `${this.label.textContent}: mass ${(1000 * figures.mass_kg).toFixed(0)} grams; ${factors.join("; ")}.`;
  }

  // How exact the answer is, and what loads the bores; while rods around a design are solved, how many are.
  labelled(header) {
    const { label, new_mesh: anew, figures } = header;
    if (!figures) return this.solving < 1 ? `Solving around this design: ${Math.round(100 * this.solving)} %` : "Not solved here";
    return `${KNOWN[label]}${anew && label !== "converged" ? ", new mesh" : ""} · ${loading(header)}`;
  }

  // In words whether a factor suffices; a rod of parts that is solved in one piece says nothing of its joint.
  verdict(factor) {
    const [kind, words] = verdict(factor, this.required);
    return this.onePiece && kind === "holds" ? ["open", "met in one piece"] : [kind, words];
  }

  mass({ mass_kg: mass }, before) {
    return element("div", { class: "card" }, element("h3", {}, "Mass"), element("p", { class: "big" }, `${(1000 * mass).toFixed(1)} g`),
      element("p", { class: "change" }, this.change(1000 * mass, 1000 * before.mass_kg, 1, " g")));
  }

  // The difference in words; empty where there is nothing like it.
  change(now, before, digits, unit = "") {
    const by = (now - before).toFixed(digits);
    if (!Number.isFinite(now - before) || this.now === this.since.state) return "";
    return Number(by) === 0 ? `as ${this.since.name}` : `${by > 0 ? "+" : "−"}${by.replace("-", "")}${unit} from ${this.since.name}`;
  }

  card(name, factor, before, governs, life = "") {
    const head = element("h3", {}, name);
    if (governs) head.append(element("span", { class: "badge" }, "governs"));
    if (!factor) return element("div", { class: "card none" }, head, element("p", { class: "big" }, "…"),
      element("p", { class: "change" }, name === "Fatigue" ? "computed when the slider stops" : "no load case compresses the rod"));
    const own = bounds(factor), [kind, words] = this.verdict(own);
    const bar = factor.interval && ` ${factor.interval}`;
    return element("div", { class: `card ${kind}`, title: factor.where },
      head, element("p", { class: "big" }, two(own.factor), element("small", {}, bar)),
      this.meter(own), element("p", { class: "change" },
        element("b", {}, words), life && ` · lasts ${life}`, [" · ", this.change(own.factor, before?.factor, 2)].filter((_, k, all) => all[1]).join("")));
  }

  // From 0 to three times what is required: the factor, its bar, and the requirement as a line.
  meter({ factor, low, high }) {
    const end = 3 * this.required, at = (value) => `${100 * Math.min(1, value / end)}%`;
    const made = element("div", { class: "meter", "aria-hidden": "true" }), add = (name, style) => {
      const own = element("i", { class: name });
      Object.assign(own.style, style);
      made.append(own);
    };
    add("fill", { width: at(factor) });
    add("bar", { left: at(low), width: `${100 * Math.max(0, Math.min(1, high / end) - Math.min(1, low / end))}%` });
    add("need", { left: at(this.required) });
    return made;
  }
}
