(() => {
"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const panel = document.getElementById("study");
const heading = document.getElementById("study-title");
const figures = document.getElementById("study-figures");
const text = document.getElementById("study-text");
const link = document.getElementById("study-file");

const studyOf = (number) => data.studies[number].map((line) => data.lines[line]).join("\n") + "\n";

function show(number) {
  document.querySelectorAll(".chosen").forEach((item) => item.classList.remove("chosen"));
  document.querySelectorAll(`[data-n="${number}"]`).forEach((item) => {
    item.classList.add("chosen");
    item.parentNode.append(item);
  });
  const row = data.rows[number];
  heading.textContent = `Row ${row}`;
  figures.textContent = Object.entries(data.values[number]).map(([name, value]) => `${name} ${value}`).join(" · ");
  text.textContent = studyOf(number);
  link.download = `row-${row}.toml`;
  link.href = `data:application/toml;charset=utf-8,${encodeURIComponent(studyOf(number))}`;
  panel.hidden = false;
}

document.addEventListener("click", (event) => {
  const item = event.target.closest("[data-n]");
  if (item) show(Number(item.dataset.n));
});
document.addEventListener("keydown", (event) => {
  const item = event.target.closest("[data-n]");
  if (item && (event.key === "Enter" || event.key === " ")) {
    event.preventDefault();
    show(Number(item.dataset.n));
  }
});
document.getElementById("study-close").addEventListener("click", () => { panel.hidden = true; });
})();
