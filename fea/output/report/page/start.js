// Unpack the numbers and start; where that is not possible, say so and keep the still picture.

// The sheet is on the screen before the rod takes its time; a tab in the background paints nothing.
function painted() {
  return new Promise((done) => {
    requestAnimationFrame(() => setTimeout(done));
    setTimeout(done, 300);
  });
}

async function start() {
  const root = document.getElementById("viewer");
  if (!root) return null;
  const why = document.getElementById("no-viewer");
  try {
    await painted();
    if (!("DecompressionStream" in window)) throw new Error("this browser cannot unpack the numbers (no DecompressionStream)");
    const header = JSON.parse(new TextDecoder().decode(await unpacked(document.getElementById("scene").textContent)));
    const numbers = new Numbers(await unpacked(document.getElementById("numbers").textContent), header.arrays);
    root.hidden = false;
    const viewer = new Viewer(root, header, numbers);
    why.hidden = true;
    document.getElementById("still")?.classList.add("for-print");
    return viewer;
  } catch (error) {
    root.hidden = true;
    why.hidden = false;
    const reason = error.message === "no WebGL 2" ? "this browser or this computer offers no WebGL 2" : error.message;
    why.querySelector(".reason").textContent = reason;
    return null;
  }
}

addEventListener("beforeprint", () => {
  for (const details of document.querySelectorAll("details")) details.open = true;
});

// For scripts and tests: the viewer, or null where there is none.
window.feaReport = start();
