// Named designs side by side: what differs in their inputs, and their answers.

class Variants {
  constructor(root, { go, remove, save }) {
    Object.assign(this, { root, go, remove, save });
  }

  // `now` is the design at hand with its answer; `items` are the inputs of the page by key.
  show(now, variants, items) {
    const columns = [["now", now], ...Object.entries(variants)];
    if (columns.length === 1) {
      this.root.replaceChildren(element("p", { class: "hint" }, "Keep a design under a name, then change it: both stand here side by side."));
      return;
    }
    const head = element("tr", {}, element("th", { scope: "col" }, ""), ...columns.map(([name]) => this.heading(name)));
    const rows = [...this.inputs(columns, items), ...this.answers(columns)];
    const labels = this.row("Answer", columns.map(([, { answer }]) => (answer ? `${KNOWN[answer.label]}, ${loading(answer)}` : "not solved yet")));
    const table = element("table", {}, element("caption", { class: "sr-only" }, "Variants with what differs, and the difference to the present design"),
      element("thead", {}, head), element("tbody", {}, ...rows, labels));
    this.root.replaceChildren(table);
  }

  heading(name) {
    const cell = element("th", { scope: "col" }, name === "now" ? "Now" : name);
    if (name === "now") return cell;
    const button = (text, act) => {
      const made = element("button", { type: "button", "aria-label": `${text} ${name}` }, text);
      made.addEventListener("click", () => act(name));
      return made;
    };
    cell.append(element("span", { class: "acts" }, button("Open", this.go), button("Save", this.save), button("Remove", this.remove)));
    return cell;
  }

  row(name, cells) {
    return element("tr", {}, element("th", { scope: "row" }, name), ...cells.map((cell) => element("td", {}, cell)));
  }

  inputs(columns, items) {
    const rows = [];
    for (const item of items.values()) {
      const values = columns.map(([, { state }]) => state[item.part][item.key] ?? item.value);
      if (values.every((value) => value === values[0])) continue;
      const name = item.unit ? `${item.label}, ${item.unit}` : item.label;
      rows.push(item.select ? this.row(name, values.map(String)) : this.compared(name, values, item.digits));
    }
    return rows;
  }

  answers(columns) {
    const found = columns.map(([, { answer }]) => answer?.figures);
    // Factors are compared only where the same pins load the rod.
    const like = columns.map(([, { answer }]) => answer && columns[0][1].answer && alike(answer) === alike(columns[0][1].answer));
    const rows = [this.compared("Mass, g", found.map((figures) => figures && 1000 * figures.mass_kg), 1)];
    for (const [mode, name] of MODES) {
      if (found.some((figures) => figures?.[mode])) rows.push(this.compared(`${name}, factor`, found.map((figures) => figures?.[mode]?.factor), 2, like));
    }
    return rows;
  }

  // Numbers with their difference to the first.
  compared(name, values, digits, like = []) {
    return this.row(name, values.map((value, k) => {
      if (value === undefined || value === null) return "–";
      const by = value - values[0], cell = element("span", {}, value.toFixed(digits));
      if (k && like[k] !== false && Number.isFinite(by) && Number(by.toFixed(digits))) {
        cell.append(element("small", {}, ` ${by > 0 ? "+" : "−"}${Math.abs(by).toFixed(digits)}`));
      }
      return cell;
    }));
  }
}
