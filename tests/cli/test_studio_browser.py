"""The page of `fea studio` in real browsers: drag, undo, compare, save, reload, a worker that dies."""

import time
from urllib.parse import urlsplit

import pytest
from browser import browser, missing
from studios import end, served

pytestmark = pytest.mark.slow


PATIENCE = 120  # seconds: several processes start
ANSWERED = "feaStudio.current && feaStudio.shown.label === 'converged'"
WEB = "document.getElementById('in-web_thickness_mm')"
SLIDER = f"""((own) => {{
  own.scrollIntoView({{ block: "center", behavior: "instant" }});  // the page scrolls smoothly by itself
  const box = own.getBoundingClientRect();
  return [box.left + 8, box.width - 16, box.top + box.height / 2];
}})({WEB})"""
CARDS = "Array.from(document.querySelectorAll('.card .big'), (own) => own.textContent)"
UNNAMED = """Array.from(document.querySelectorAll("button, select, input, canvas"))
  .filter((one) => !(one.textContent.trim() || one.labels?.length || one.ariaLabel))
  .map((one) => one.outerHTML.slice(0, 80))"""
WHY = "document.getElementById('in-web_thickness_mm-why')"
ROWS = "Array.from(document.querySelectorAll('#compare tbody tr'), (row) => row.innerText)"
NUMBER = f"Number({WEB}.value)"
# Random events of a slider; what the page shows after each frame must be of the frame's own design.
FLOOD = """(async (key, events, seed) => {
  const own = document.getElementById(`in-${key}`), hear = feaStudio.on_frame.bind(feaStudio), mixed = [];
  let frames = 0;
  const random = () => (seed = (16807 * seed) % 2147483647) / 2147483647;
  feaStudio.on_frame = (message) => {
    const { dropped } = feaStudio, { state, serial } = message.header;
    hear(message);
    if (feaStudio.dropped > dropped) return;
    frames++;
    const web = state.design[key] ?? 5, of = document.getElementById("of").textContent;
    const mass = document.querySelector(".card .big").textContent, stress = feaStudio.stage.values[0];
    const same = mass === `${(100 * web).toFixed(1)} g` && Math.abs(stress - (106 + 7 * web)) < 1e-3;
    const told = of.includes(key in state.design ? web.toFixed(2) : "as it is");
    if (!same || !told || feaStudio.shown.serial !== serial) mixed.push({ web, mass, stress, of, serial });
  };
  for (let k = 0; k <= events; k++) {
    own.value = 4 + 2 * random();
    own.dispatchEvent(new Event(k === events || random() < 0.002 ? "change" : "input"));
    if (k % 250 === 0) await new Promise(requestAnimationFrame);
  }
  delete feaStudio.on_frame;
  return { frames, mixed };
})"""


def wait(shown, condition):
    end = time.monotonic() + PATIENCE
    while not shown.run(f"Boolean({condition})"):
        assert time.monotonic() < end, condition
        time.sleep(0.05)


def click(shown, selector):
    shown.run(f"document.querySelector('{selector}').click()")


def outlives_its_worker(shown, studio):
    """Save, a worker that dies, and a reload."""
    click(shown, "[data-export=study]")
    wait(shown, "document.querySelector('#message a')?.download === 'study.toml'")
    end(studio.workers()[0])
    shown.run(f"{WEB}.focus()")
    shown.keys("\ue012")
    wait(shown, "document.getElementById('message').textContent.includes('SIGKILL')")
    wait(shown, ANSWERED)
    before = shown.run(f"[{NUMBER}, {CARDS}]")
    assert shown.complaints() == []
    shown.open(studio.address)
    wait(shown, ANSWERED)
    assert shown.run(f"[{NUMBER}, {CARDS}]") == before
    assert shown.run("Object.keys(feaStudio.session.variants)") == ["thick"]


@pytest.mark.parametrize("name", ["chromium", "firefox"])
def test_a_design_from_a_drag_to_a_reload(name, tmp_path):
    if why := missing(name):
        pytest.skip(f"no {name}: {why}")
    with served(tmp_path) as studio, browser(name) as shown:
        shown.open(studio.address)
        wait(shown, ANSWERED)
        first = shown.run(CARDS)
        assert first[0] == "500.0 g"

        # A drag: figures follow, and are exact where it ends.
        left, width, y = shown.run(SLIDER)
        low, high = shown.run(f"((own) => [Number(own.min), Number(own.max)])({WEB})")
        at = left + width * (5.0 - low) / (high - low)
        shown.drag((round(at), round(y)), (round(left + width), round(y)))
        wait(shown, f"{NUMBER} === 6 && {ANSWERED}")  # where the rule ends it
        assert shown.run(f"{WHY}.textContent").endswith("too thick")
        assert shown.run(CARDS)[0] == "600.0 g"
        assert "+100.0 g" in shown.run("document.querySelector('.card .change').textContent")
        assert "web thickness 6.00 mm" in shown.run("document.getElementById('of').textContent")
        assert "600 grams" in shown.run("document.getElementById('said').textContent")

        # Compare, with the keyboard for another design.
        shown.run("document.getElementById('variant-name').value = 'thick'")
        click(shown, "#keep button")
        wait(shown, "'thick' in feaStudio.session.variants")
        shown.run(f"{WEB}.focus()")
        shown.keys("\ue012", "\ue012")  # left
        wait(shown, f"{NUMBER} < 6 && {ANSWERED}")
        table = shown.run(ROWS)
        assert any(row.startswith("Web thickness, mm") and "6.00" in row for row in table)
        click(shown, "#undo")
        wait(shown, f"{NUMBER} === 6 && {ANSWERED}")
        click(shown, "#redo")
        wait(shown, f"{NUMBER} < 6 && {ANSWERED}")

        found = [shown.run(f"{FLOOD}('web_thickness_mm', 1000, {seed})") for seed in (1, 2)]
        assert [mixed for each in found for mixed in each["mixed"]] == []
        assert sum(each["frames"] for each in found) > 3
        wait(shown, ANSWERED)
        assert shown.run(CARDS)[0] == f"{100 * shown.run(NUMBER):.1f} g"

        if name == "chromium":  # what follows is of the server, whatever the browser
            outlives_its_worker(shown, studio)
        asked = {url for url in shown.requests() if not url.startswith("data:")}
        assert {urlsplit(url)[1:3] for url in asked} <= {
            (studio.url.netloc, "/"),
            (studio.url.netloc, "/socket"),
        }
        assert shown.run(UNNAMED) == []
        shown.run("document.getElementById('even').click()")  # each band lighter than the one before
        light = [sum(bytes.fromhex(one[1:])) for one in shown.run("feaStudio.stage.field.colours")]
        assert light == sorted(light)
        shown.size(390, 844)
        assert shown.run("document.documentElement.scrollWidth") <= 390
        assert shown.complaints() == []
