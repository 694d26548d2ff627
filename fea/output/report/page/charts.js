// The lines over the plots that show the crank angle of the slider, and the values there.

class Charts {
  constructor(described) {
    this.charts = described.map((chart) => {
      const figure = document.getElementById(chart.id);
      return { ...chart, line: figure.querySelector(".now"), said: figure.querySelector(".now-value") };
    });
  }

  at(angle) {
    for (const { left, width, line, said, series, unit, last } of this.charts) {
      const x = left + (width * angle) / last;
      line.setAttribute("x1", x);
      line.setAttribute("x2", x);
      line.classList.add("shown");
      const degree = Math.round(angle);
      const values = series.map((values) => `${signed(values[degree])} ${unit}`);
      said.textContent = ` ${degree}°: ${values.join(" · ")}`;
    }
  }
}

const signed = (value) => (value + 0 === 0 ? 0 : value).toLocaleString("en", { maximumSignificantDigits: 4, useGrouping: false }).replace("-", "−");
const fixed = (value, digits) => (Number(value.toFixed(digits)) + 0).toFixed(digits).replace("-", "−");
