// The pressure of an oil film as a relief over the unrolled bore, and the orbit of the pin in it.

class FilmMap {
  constructor(described, numbers, length) {
    Object.assign(this, described);
    this.length = length;
    this.root = document.querySelector(`[data-film="${this.id}"]`);
    this.canvas = this.root.querySelector("canvas");
    this.cells = numbers.values(this.id, chain(this.orbit.length));
    // Places along the width: the middle of each cell, and the ends, where the pressure is that of the surroundings.
    const { edges } = this, own = edges.slice(1).map((edge, k) => ({ z: (edge + edges[k]) / 2, cell: k }));
    const far = { z: edges[edges.length - 1], cell: -1 };
    const other = this.halved ? [...own, far].map(({ z, cell }) => ({ z: -z, cell })).reverse() : [{ z: edges[0], cell: -1 }];
    this.along = [...other, ...own, far];
    this.across = own.length;
    this.largest = this.field.limits[this.field.limits.length - 1];
    drawLegend(this.root.querySelector(".legend"), this.field);
    new ResizeObserver(() => this.at(this.angle ?? 0)).observe(this.canvas);
  }

  pressure(around, { cell }, step) {
    return cell < 0 ? 0 : this.cells[(around % this.angles) * this.across + cell][step];
  }

  step(angle) {
    return Math.round((angle / this.last) * this.orbit.length) % this.orbit.length;
  }

  // The mean along the width in each direction, as `Loads.arc` describes pressures.
  around(angle) {
    const { angles, across } = this, step = this.step(angle);
    const means = Array.from({ length: angles }, (_, k) => {
      const own = Array.from({ length: across }, (_, cell) => this.pressure(k, { cell }, step) * (this.edges[cell + 1] - this.edges[cell]));
      return own.reduce((sum, p) => sum + p, 0) / (this.edges[across] - this.edges[0]);
    });
    const share = (away) => Math.max(0, means[Math.round((away / (2 * Math.PI) + 1) * angles) % angles] / this.largest);
    return { middle: 0, width: 2 * Math.PI, height: HEIGHT, share };
  }

  at(angle) {
    this.angle = angle;
    const { canvas } = this, ratio = Math.min(window.devicePixelRatio || 1, 2);
    canvas.width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    canvas.height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    const pen = canvas.getContext("2d"), style = getComputedStyle(canvas);
    const step = this.step(angle);
    pen.scale(ratio, ratio);
    const [ink, accent] = ["--soft", "--accent"].map((name) => style.getPropertyValue(name));
    const wide = canvas.clientWidth, high = canvas.clientHeight, split = wide > 480 ? 0.66 * wide : wide;
    pen.font = `11px ${style.fontFamily}`;
    const most = this.relief(pen, step, split, split < wide ? high : 0.58 * high, ink);
    if (split < wide) this.path(pen, step, [split, 0, wide - split, high], ink, accent);
    else this.path(pen, step, [0, 0.6 * high, wide, 0.4 * high], ink, accent);
    const { unit, factor } = this.field;
    this.root.querySelector(".now-value").textContent = ` ${Math.round(angle)}°: at most ${signed(factor * most)} ${unit}`;
  }

  // Draw the relief from its far side to the near one; return the largest pressure.
  relief(pen, step, wide, high, ink) {
    const { angles, along, largest } = this, reach = along[along.length - 1].z;
    const slant = 0.2 * wide, deep = 0.26 * high, top = 0.58 * high, left = 34, width = wide - slant - left - 16;
    const place = (k, { z }, p) => {
      const back = (z / reach + 1) / 2;
      return [left + (width * k) / angles + slant * back, high - 34 - deep * back - (top * p) / largest];
    };
    let most = 0;
    const values = along.map((row) => Array.from({ length: angles + 1 }, (_, k) => {
      const p = this.pressure(k + angles / 2, row, step);
      most = Math.max(most, p);
      return p;
    }));
    const { limits, colours } = this.field;
    for (let row = along.length - 1; row > 0; row--) {
      for (let k = 0; k < angles; k++) {
        const corners = [[k, row], [k + 1, row], [k + 1, row - 1], [k, row - 1]];
        const mean = corners.reduce((sum, [i, j]) => sum + values[j][i] / 4, 0);
        const band = limits.findIndex((limit) => mean < limit);
        pen.fillStyle = pen.strokeStyle = colours[band < 0 ? colours.length - 1 : Math.max(0, band - 1)];
        pen.beginPath();
        corners.forEach(([i, j], n) => pen[n ? "lineTo" : "moveTo"](...place(i, along[j], values[j][i])));
        pen.closePath();
        pen.fill();
        pen.stroke();
      }
    }
    pen.fillStyle = ink;
    pen.textAlign = "center";
    for (let degrees = -180; degrees <= 180; degrees += 90) {
      const [x, y] = place((angles * (degrees + 180)) / 360, along[0], 0);
      pen.fillText(`${degrees}°`.replace("-", "−"), x, y + 16);
    }
    const { factor, digits, unit } = this.length, [x, y] = place(angles, { z: 0 }, 0);
    pen.textAlign = "left";
    pen.fillText(`${fixed(2 * factor * reach, digits)} ${unit}`, Math.min(x + 6, wide - 52), y + 14);
    return most;
  }

  path(pen, step, [x, y, wide, high], ink, accent) {
    const far = Math.max(1, ...this.orbit.flat().map(Math.abs)), half = Math.min(wide, high) / 2 - 22;
    const at = ([along, across]) => [x + wide / 2 + (half * along) / far, y + high / 2 - (half * across) / far];
    const line = (colour, width, draw) => {
      Object.assign(pen, { strokeStyle: colour, lineWidth: width });
      pen.beginPath();
      draw();
      pen.stroke();
    };
    line(ink, 1, () => pen.arc(...at([0, 0]), half / far, 0, 2 * Math.PI));
    line(accent, 1.5, () => [...this.orbit, this.orbit[0]].forEach((place) => pen.lineTo(...at(place))));
    pen.fillStyle = accent;
    pen.beginPath();
    pen.arc(...at(this.orbit[step]), 5, 0, 2 * Math.PI);
    pen.fill();
    pen.fillStyle = ink;
    pen.textAlign = "center";
    pen.fillText("along the rod →", x + wide / 2, y + high - 6);
  }
}
