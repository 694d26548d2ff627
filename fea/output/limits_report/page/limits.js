"use strict";
const d = JSON.parse(document.getElementById("data").textContent);
const canvas = document.getElementById("map"), g = canvas.getContext("2d"), under = document.getElementById("under");
const colors = ["#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b", "#e377c2", "#7f7f7f", "#bcbd22"];
const modes = Object.keys(d.factors), ending = modes.filter((mode) => !d.onsets.includes(mode)), box = { left: 130, right: 1480, top: 30, bottom: 980 };
const last = (list) => list[list.length - 1];
const x = (rpm) => box.left + (rpm / last(d.rpm)) * (box.right - box.left);
const y = (bar) => box.bottom - (bar / last(d.peak)) * (box.bottom - box.top);

function cell(list, value) {
  const k = Math.max(1, list.findIndex((each) => each >= value));
  return [k - 1, Math.min(1, Math.max(0, (value - list[k - 1]) / (list[k] - list[k - 1])))];
}

// Utilisations are linear between points, not their inverses.
function factor(mode, rpm, bar) {
  const [i, s] = cell(d.rpm, rpm), [j, t] = cell(d.peak, bar), f = d.factors[mode];
  const u = (1 - t) * ((1 - s) / f[j][i] + s / f[j][i + 1]) + t * ((1 - s) / f[j + 1][i] + s / f[j + 1][i + 1]);
  return 1 / u;
}

function region() {
  for (let px = box.left; px < box.right; px += 6) {
    for (let py = box.top; py < box.bottom; py += 6) {
      const rpm = ((px + 3 - box.left) / (box.right - box.left)) * last(d.rpm);
      const bar = ((box.bottom - py - 3) / (box.bottom - box.top)) * last(d.peak);
      const beyond = "yield" in d.factors && factor("yield", rpm, bar) * d.elastic < 1;
      const safe = ending.every((mode) => factor(mode, rpm, bar) > 1);
      if (beyond || safe) {
        g.fillStyle = beyond ? "#d9d9d9" : "#d9efd9";
        g.fillRect(px, py, 6, 6);
      }
    }
  }
}

function line(points, color, dashed) {
  g.strokeStyle = color;
  g.lineWidth = 4;
  g.setLineDash(dashed ? [14, 10] : []);
  g.beginPath();
  points.forEach(([rpm, bar], k) => (k ? g.lineTo(x(rpm), y(bar)) : g.moveTo(x(rpm), y(bar))));
  g.stroke();
  g.setLineDash([]);
}

function step(most) {
  const rough = most / 7, size = 10 ** Math.floor(Math.log10(rough));
  return [1, 2, 5, 10].map((m) => m * size).find((each) => each >= rough);
}

function axes() {
  g.font = "26px system-ui, sans-serif";
  g.fillStyle = "#333";
  g.strokeStyle = "#bbb";
  g.lineWidth = 1;
  for (const [most, across] of [[last(d.rpm), true], [last(d.peak), false]]) {
    for (let v = 0; v <= most; v += step(most)) {
      g.beginPath();
      g.moveTo(across ? x(v) : box.left, across ? box.top : y(v));
      g.lineTo(across ? x(v) : box.right, across ? box.bottom : y(v));
      g.stroke();
      g.textAlign = across ? "center" : "right";
      g.fillText(String(v), across ? x(v) : box.left - 12, across ? box.bottom + 34 : y(v) + 9);
    }
  }
  g.textAlign = "center";
  g.fillText("engine speed, rpm", (box.left + box.right) / 2, box.bottom + 78);
  g.save();
  g.translate(36, (box.top + box.bottom) / 2);
  g.rotate(-Math.PI / 2);
  g.fillText(`peak pressure (absolute), ${d.unit}`, 0, 0);
  g.restore();
}

function draw() {
  g.clearRect(0, 0, canvas.width, canvas.height);
  region();
  axes();
  modes.forEach((mode, k) => {
    line(d.lines[mode], colors[k]);
    g.fillStyle = colors[k];
    g.textAlign = "left";
    g.fillText(mode, box.right + 20, box.top + 30 + 38 * k);
  });
  line(d.load[0].map((rpm, k) => [rpm, d.load[1][k]]), "#444", true);
  g.fillStyle = "#1a1a1a";
  for (const [rpm, bar] of d.points) {
    g.beginPath();
    g.arc(x(rpm), y(bar), 10, 0, 2 * Math.PI);
    g.fill();
  }
  if (d.closed) {
    const [cx, cy] = [x(d.closed[0]), y(d.closed[1])];
    g.beginPath();
    g.moveTo(cx - 12, cy - 12);
    g.lineTo(cx + 12, cy - 12);
    g.lineTo(cx, cy + 10);
    g.closePath();
    g.stroke();
  }
}

function place(mode, rpm, bar) {
  const away = ([r, b]) => Math.hypot((r - rpm) / last(d.rpm), (b - bar) / last(d.peak));
  const near = [...d.lines[mode]].sort((a, b) => away(a) - away(b))[0];
  return near && near[2] ? ` (${near[2]})` : "";
}

function told(event) {
  const at = canvas.getBoundingClientRect(), px = ((event.clientX - at.left) / at.width) * canvas.width;
  const py = ((event.clientY - at.top) / at.height) * canvas.height;
  const rpm = ((px - box.left) / (box.right - box.left)) * last(d.rpm);
  const bar = ((box.bottom - py) / (box.bottom - box.top)) * last(d.peak);
  if (rpm < d.rpm[0] || rpm > last(d.rpm) || bar < 0 || bar > last(d.peak)) return;
  const found = modes.map((mode) => [mode, factor(mode, rpm, bar)]).sort((a, b) => a[1] - b[1]);
  const [mode, least] = found.find(([name]) => ending.includes(name));
  const all = found.map(([name, value]) => `${name} ${value >= 10 ? "> 10" : value.toFixed(2)}`).join(", ");
  const lead = `${rpm.toFixed(0)} rpm, ${bar.toFixed(0)} ${d.unit}: ${least >= 1 ? "safe" : "not safe"}`;
  under.textContent = `${lead}; governed by ${mode}${place(mode, rpm, bar)}. Factors: ${all}.`;
}

canvas.addEventListener("pointermove", told);
draw();
