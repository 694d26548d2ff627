// Mouse, touch and keys on the canvas.

const KEY_STEP = Math.PI / 18;

function hands(canvas, camera, { changed, probe, home }) {
  const held = new Map();
  const size = () => Math.min(canvas.clientWidth, canvas.clientHeight);
  const share = (event) => {
    const box = canvas.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  };

  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("pointerdown", (event) => {
    canvas.focus({ preventScroll: true });
    canvas.setPointerCapture(event.pointerId);
    held.set(event.pointerId, { x: event.clientX, y: event.clientY, moved: 0 });
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = held.get(event.pointerId);
    if (!before) {
      probe(share(event));
      return;
    }
    const dx = event.clientX - before.x, dy = event.clientY - before.y;
    const spread = pinch();
    Object.assign(before, { x: event.clientX, y: event.clientY, moved: before.moved + Math.hypot(dx, dy) });
    if (held.size === 2) {
      camera.zoom(pinch() / Math.max(spread, 1));
      camera.pan(dx / canvas.clientHeight, -dy / canvas.clientHeight);
    } else if (event.shiftKey || event.buttons === 2 || event.buttons === 4) {
      camera.pan((2 * dx) / canvas.clientHeight, (-2 * dy) / canvas.clientHeight);
    } else {
      camera.orbit((-3 * dx) / size(), (-3 * dy) / size());
    }
    probe(null);
    changed();
  });
  for (const name of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(name, (event) => {
      const before = held.get(event.pointerId);
      held.delete(event.pointerId);
      if (before && name === "pointerup" && before.moved < 5) probe(share(event));
    });
  }
  canvas.addEventListener("pointerleave", () => probe(null));
  // The wheel scrolls the page until the canvas has the focus.
  canvas.addEventListener("wheel", (event) => {
    if (document.activeElement !== canvas && !event.ctrlKey) return;
    event.preventDefault();
    camera.zoom(Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.05 : 0.0015)));
    changed();
  }, { passive: false });

  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const arrow = arrows[event.key];
    if (arrow && event.shiftKey) camera.pan(-0.1 * arrow[0], -0.1 * arrow[1]);
    else if (arrow) camera.orbit(KEY_STEP * arrow[0], -KEY_STEP * arrow[1]);
    else if (event.key === "+" || event.key === "=") camera.zoom(1.25);
    else if (event.key === "-") camera.zoom(0.8);
    else if (event.key === "Home") home();
    else return;
    event.preventDefault();
    probe(null);
    changed();
  });

  function pinch() {
    const [a, b] = held.values();
    return b ? Math.hypot(a.x - b.x, a.y - b.y) : 1;
  }
}
