// The bands of a field with their colours.

function drawLegend(box, field) {
  const title = document.createElement("span");
  title.className = "legend-title";
  title.textContent = field.unit ? `${field.label}, ${field.unit}` : field.label;
  const bar = document.createElement("span");
  bar.className = "legend-bar";
  field.colours.forEach((colour, k) => {
    const band = document.createElement("span");
    band.style.background = colour;
    band.dataset.low = field.labels[k].replace("-", "−");
    if (k === field.colours.length - 1) band.dataset.high = field.labels[k + 1].replace("-", "−") + (field.above ? "+" : "");
    bar.append(band);
  });
  box.replaceChildren(title, bar);
  const ends = `${field.labels[0]} to ${field.labels[field.labels.length - 1]} ${field.unit}`;
  box.setAttribute("aria-label", `Legend: ${field.label}, ${field.colours.length} bands from ${ends}`);
}
