// The map of limits: the factors under the pointer, and the place on the rod that governs there.

class LimitsMap {
  constructor(viewer) {
    this.viewer = viewer; // a promise; of null where the rod cannot be drawn
    this.data = JSON.parse(document.getElementById("map-data").textContent);
    this.field = document.querySelector(".field");
    this.mark = this.field.querySelector(".at");
    this.under = document.getElementById("under");
    this.modes = Object.keys(this.data.factors);
    const { rpm, peak } = this.data;
    this.point = [rpm[Math.floor(rpm.length / 2)], peak[Math.floor(peak.length / 2)]];
    this.field.addEventListener("pointermove", (event) => this.at(event));
    this.field.addEventListener("pointerdown", (event) => this.at(event));
    this.field.addEventListener("keydown", (event) => this.step(event));
  }

  at(event) {
    const { box: [left, right, top, bottom], rpm, peak } = this.data, seen = this.field.getBoundingClientRect();
    const across = ((event.clientX - seen.left) / seen.width - left) / (right - left);
    const up = (bottom - (event.clientY - seen.top) / seen.height) / (bottom - top);
    if (across < 0 || across > 1 || up < 0 || up > 1) return;
    this.say(rpm[0] + across * (rpm[rpm.length - 1] - rpm[0]), up * peak[peak.length - 1]);
  }

  step(event) {
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] }[event.key];
    if (!way) return;
    event.preventDefault();
    const [rpm, peak] = [this.data.rpm, this.data.peak].map((list, k) => {
      const low = list[0], high = list[list.length - 1];
      return Math.min(high, Math.max(low, this.point[k] + (way[k] * (high - low)) / 100));
    });
    this.say(rpm, peak);
  }

  // A table of the map at a point: its values are linear between points in what `way` makes of them.
  between(table, rpm, peak, way) {
    const share = (list, value) => {
      const k = Math.max(1, list.findIndex((each) => each >= value));
      return [k - 1, Math.min(1, Math.max(0, (value - list[k - 1]) / (list[k] - list[k - 1])))];
    };
    const [i, s] = share(this.data.rpm, rpm), [j, t] = share(this.data.peak, peak);
    const row = (k) => (1 - s) * way(table[k][i]) + s * way(table[k][i + 1]);
    return (1 - t) * row(j) + t * row(j + 1);
  }

  // The place of a mode's limit on the ray through a point: along it loads are in one proportion.
  place(mode, rpm, peak) {
    const { rpm: speeds, peak: peaks, lines } = this.data;
    const angle = (r, p) => Math.atan2(p / peaks[peaks.length - 1], (r / speeds[speeds.length - 1]) ** 2);
    const away = (point) => Math.abs(angle(point.rpm, point.peak) - angle(rpm, peak));
    return (lines[mode] ?? []).reduce((near, each) => (near && away(near) <= away(each) ? near : each), null);
  }

  say(rpm, peak) {
    this.point = [rpm, peak];
    const { box: [left, right, top, bottom], rpm: speeds, peak: peaks, factors, onsets, unit } = this.data;
    const across = (rpm - speeds[0]) / (speeds[speeds.length - 1] - speeds[0]);
    this.mark.hidden = false;
    this.mark.style.left = `${100 * (left + across * (right - left))}%`;
    this.mark.style.top = `${100 * (bottom - (peak / peaks[peaks.length - 1]) * (bottom - top))}%`;
    const inverse = (value) => 1 / value;
    const found = this.modes.map((mode) => [mode, 1 / this.between(factors[mode], rpm, peak, inverse)]).sort((a, b) => a[1] - b[1]);
    const worst = found.find(([mode]) => !onsets.includes(mode));
    const lead = `${rpm.toFixed(0)} rpm, ${peak.toFixed(0)} ${unit}`;
    if (!worst) {
      this.under.textContent = `${lead}: nothing limits the rod.`;
      return;
    }
    const place = this.place(worst[0], rpm, peak), where = place?.name ? ` (${place.name})` : "";
    const all = found.map(([mode, value]) => `${mode} ${value >= 10 ? "> 10" : value.toFixed(2)}`).join(", ");
    const said = `${lead}: ${worst[1] >= 1 ? "safe" : "not safe"}; governed by ${worst[0]}${where}.`;
    this.under.textContent = `${said} Factors over the required one: ${all}.${this.life(rpm, peak)}`;
    if (place !== this.shown) this.show(place);
  }

  life(rpm, peak) {
    if (!this.data.hours) return "";
    const hours = 10 ** this.between(this.data.hours, rpm, peak, Math.log10);
    if (hours > 1e5) return " It lasts more than 100 000 hours.";
    return hours < 0.1 ? " It lasts less than 6 minutes." : ` It lasts about ${Number(hours.toPrecision(this.data.line ? 1 : 2))} hours${this.data.line && ` ${this.data.line}`}.`;
  }

  // Mark a place on the rod at once, and fly there when the pointer rests.
  async show(place) {
    this.shown = place;
    clearTimeout(this.waiting);
    const viewer = await this.viewer;
    if (!viewer || place !== this.shown) return;
    if (!place?.at) {
      viewer.show({ spot: null });
      return;
    }
    const { last } = viewer.header;
    const apart = ({ angle }) => Math.abs(((angle - place.angle + 1.5 * last) % last) - last / 2);
    const cases = viewer.header.results.filter(({ kind, angle }) => kind === "case" && angle !== null);
    const near = cases.reduce((best, each) => (apart(best) <= apart(each) ? best : each), cases[0]);
    const spot = { at: place.at, result: near?.id ?? viewer.shown.result, field: "von_mises" };
    viewer.show({ result: spot.result, field: spot.field, spot: viewer.surface.nearest(spot.at) });
    this.waiting = setTimeout(() => viewer.fly(spot, 0.3), 350);
  }
}

window.feaLimits = new LimitsMap(window.feaReport);
