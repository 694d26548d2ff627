"""What `fea studio` costs, and a picture of it: `python tests/benchmarks/studio.py [--minutes M] [results]`.

Chromium draws in software, by the processor that also solves. Wall times are those of the machine as it is;
beside them stands the processor time of the processes.
"""

import argparse
import os
import signal
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from browser import browser
from studios import gone, served

KEY, SECONDS = "web_thickness_mm", 20
# Move a slider to and fro for so many seconds; how many events, frames and pictures that were a second.
DRAG = """(async (key, seconds) => {
  const own = document.getElementById(`in-${key}`), item = feaStudio.sliders.items.get(key);
  const begin = performance.now(), painted = feaStudio.stage.painted;
  const hear = feaStudio.on_frame.bind(feaStudio);
  let events = 0, frames = 0, grey = 0;
  feaStudio.on_frame = (message) => {
    frames++;
    if (!message.header.figures) grey++;
    hear(message);
  };
  const share = () => (performance.now() - begin) / 1000 / seconds;
  while (share() < 1) {
    own.value = item.value * (1 + 0.05 * Math.sin((2 * Math.PI * share() * seconds) / 6));
    own.dispatchEvent(new Event("input"));
    events++;
    await new Promise((done) => requestAnimationFrame(done));
  }
  delete feaStudio.on_frame;
  const each = (count) => Math.round((10 * count) / seconds) / 10;
  const pictures = feaStudio.stage.painted - painted;
  return { events: each(events), frames: each(frames), grey: each(grey), pictures: each(pictures) };
})"""

# What a picture costs the page, ms: new places and colours in buffers, and drawing until it is there.
COST = """(() => {
  const { stage } = feaStudio, { painter } = stage, timed = (act) => {
    const begin = performance.now();
    for (let k = 0; k < 10; k++) act();
    return Math.round(performance.now() - begin) / 10;
  };
  const shown = { field: stage.field, scale: 1, mesh: false, ink: [0, 0, 0] }, pixel = new Uint8Array(4);
  return {
    buffers: timed(() => (painter.move(stage.moved), painter.colour(stage.values))),
    drawing: timed(() => {
      painter.draw(stage.camera, shown);
      painter.gl.readPixels(0, 0, 1, 1, painter.gl.RGBA, painter.gl.UNSIGNED_BYTE, pixel);
    }),
  };
})()"""


def processor(pid):
    """Processor time of a process, s."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def memory(pid):
    """Memory of a process, MiB."""
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return next(int(line.split()[1]) // 1024 for line in lines if line.startswith("VmRSS"))


def drag(studio, shown, options, began):
    """Open the page, drag, and let go; say what each of these took."""

    def wait(condition):
        while not shown.run(f"Boolean({condition})"):
            time.sleep(0.05)

    def said(what, since):
        pids = [studio.process.pid, *studio.workers()]
        print(
            f"{what}: {time.monotonic() - since:.1f} s; server and workers: processor "
            f"{', '.join(f'{processor(pid):.1f}' for pid in pids)} s, memory "
            f"{', '.join(str(memory(pid)) for pid in pids)} MiB",
            flush=True,
        )

    def rest(what):
        since = time.monotonic()
        wait("feaStudio.current && feaStudio.shown.label !== 'interpolated'")
        said(f"{what}, exact", since)
        wait("feaStudio.current && feaStudio.shown.label === 'converged'")
        said(f"{what}, converged", since)

    shown.open(studio.address, 1400, 1130)
    wait("feaStudio.shown?.figures")
    said("first picture", began)
    rest("first design")
    shown.run("document.getElementById('variant-name').value = 'as published'")
    shown.run("document.querySelector('#keep button').click()")
    since = time.monotonic()
    shown.run(f"{DRAG}('{KEY}', 1)")
    wait("feaStudio.panel.solving === 1")
    said("sampling", since)
    since = time.monotonic()
    while time.monotonic() - since < 60 * options.minutes:
        pids = [studio.process.pid, *studio.workers()]
        before = [processor(pid) for pid in pids]
        found = shown.run(f"{DRAG}('{KEY}', {SECONDS})")
        used = [processor(pid) - own for pid, own in zip(pids, before, strict=True)]
        each = ", ".join(f"{1e3 * own / max(1, SECONDS * found['frames']):.1f}" for own in used)
        print(f"a second: {found}; an update, ms of server and workers: {each}")
        said("dragging", since)
    shown.run(f"feaStudio.sliders.items.get('{KEY}').range.value = 5.4")
    shown.run(f"document.getElementById('in-{KEY}').dispatchEvent(new Event('change'))")
    rest("another design")
    print("a picture, ms:", shown.run(COST))
    if options.target:
        place = "{ block: 'center', behavior: 'instant' }"
        shown.run(f"document.getElementById('in-{KEY}').scrollIntoView({place})")
        shown.run("scrollTo({ top: 0, behavior: 'instant' })")
        shown.screenshot(options.target / "studio.png")


def main():
    asked = argparse.ArgumentParser()
    asked.add_argument("target", nargs="?", type=Path)
    asked.add_argument("--minutes", type=float, default=0.5)
    asked.add_argument("--study", default="leon-2001")
    options = asked.parse_args()
    began = time.monotonic()
    with (
        tempfile.TemporaryDirectory() as folder,
        served(folder, options.study, "--no-browser", "--tolerance", "5") as studio,
    ):
        with browser("chromium") as shown:
            drag(studio, shown, options, began)
        workers = studio.workers()
        studio.process.send_signal(signal.SIGINT)
        code = studio.process.wait(60)
        print(f"tab closed, then Ctrl-C: code {code}, workers {'' if gone(workers) else 'not '}gone")


main()
