"""The report in real browsers: it draws, turns, tells values, prints, and asks for nothing."""

import re
from contextlib import suppress
from io import BytesIO
from itertools import pairwise

import numpy as np
import pytest
from browser import browser, missing
from PIL import Image
from reports import HOSTILE, reported_rod
from scipy.spatial import KDTree

from fea.analysis.result import WhatIf
from fea.solid.stress import von_mises

READY = "window.feaReport.then((own) => { window.viewer = own; return own && own.surface.count; })"
DRAWN = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))"
# What the label at the pointer says, once it is shown.
PROBED = """(async (probe) => {
  for (let frame = 0; probe.hidden && frame < 100; frame++)
    await new Promise((done) => requestAnimationFrame(done));
  return probe.textContent;
})(viewer.part('probe'))"""
# Colours of the canvas that are exactly those of the legend, by the share of pixels that have them.
COLOURS = """(() => {
  const gl = viewer.painter.gl, { width, height } = viewer.canvas;
  const pixels = new Uint8Array(4 * width * height), counts = {};
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  let drawn = 0;
  for (let i = 0; i < pixels.length; i += 4) {
    if (pixels[i + 3] < 255) continue;
    drawn++;
    const colour = "#" + [0, 1, 2].map((k) => pixels[i + k].toString(16).padStart(2, "0")).join("");
    counts[colour] = (counts[colour] ?? 0) + 1;
  }
  return [drawn / (width * height), viewer.field.colours.map((colour) => (counts[colour] ?? 0) / drawn)];
})()"""
# Nothing glides, so that a test need not wait.
STILL = """() => {
  const ask = window.matchMedia;
  window.matchMedia = (query) => query.includes("reduce") ? { matches: true } : ask.call(window, query);
}"""
AS_OPENED = """(viewer.choose("tension"), viewer.show({ field: "von_mises", mesh: false, loads: true }),
  viewer.home())"""
UNNAMED = """Array.from(document.querySelectorAll("button, select, input, canvas, svg, img, [role=region]"))
  .filter((one) => !(one.textContent.trim() || one.alt || one.labels?.length || one.ariaLabel))
  .map((one) => one.outerHTML.slice(0, 80))"""
BARE_TABLES = """Array.from(document.querySelectorAll("table"))
  .filter((one) => !one.caption || one.querySelector("th:not([scope])")).length"""


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    _, result, _, _ = reported_rod()
    drawn = BytesIO()  # in place of a picture that takes seconds
    Image.linear_gradient("L").resize((1200, 750)).save(drawn, "PNG")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("fea.output.report.page.still", lambda *_: drawn.getvalue())
        patch.setattr("fea.apps.what_if.solve.what_if", lambda _run, _clock: WhatIf())
        return result.write(tmp_path_factory.mktemp("browser") / "run", report=True) / "report.html"


@pytest.fixture(scope="module", params=["chromium", "firefox"])
def shown(request, report):
    if why := missing(request.param):
        pytest.skip(f"no {request.param}: {why}")
    with browser(request.param) as found:
        found.call("script.addPreloadScript", functionDeclaration=STILL)
        found.open(report)
        assert found.run(READY) == len(reported_rod()[1].motion.nodes)
        yield found
        assert found.complaints() == []  # of all that the tests did


@pytest.fixture(autouse=True)
def as_opened(shown):
    """Each test begins with the load case that the report opens with."""
    shown.run(AS_OPENED)


def test_it_draws_the_colours_of_its_legend(shown):
    shown.run("viewer.show({ loads: false })")
    shown.run(DRAWN)
    drawn, colours = shown.run(COLOURS)
    assert drawn > 0.1
    assert sum(colours) > 0.25  # the rest is shaded, or an edge
    assert sum(share > 1e-3 for share in colours) >= 5


def test_nothing_is_asked_of_any_network_and_no_foreign_script_runs(shown, report):
    asked = {url.partition(",")[0].partition(";")[0] for url in shown.requests()}
    assert asked <= {report.as_uri(), "data:image/png", "data:", "data:font/woff2"}
    assert shown.run("window.hacked ?? null") is None
    assert shown.run("document.querySelector('h1').textContent").startswith(HOSTILE)
    # What the policy forbids is refused even to a script of the page.
    assert shown.run("fetch('data:text/plain,x').then(() => 'got it', () => 'refused')") == "refused"
    with suppress(ValueError):
        shown.events[:] = [event for event in shown.events if "data:text/plain" not in str(event)]


def test_the_slider_gives_the_directly_solved_stress(shown):
    _, result, degrees, (stress, moved) = reported_rod()
    places = np.array(shown.run("Array.from(viewer.surface.positions)")).reshape(-1, 3)
    apart, node = KDTree(result.mesh.points).query(places)
    assert apart.max() < 0.01
    peak = max(float(von_mises(stress[..., k]).max()) for k in range(len(degrees)))
    for k, angle in enumerate(degrees):
        slide = f"slider.value = {angle}, slider.dispatchEvent(new Event('input'))"
        values = "Array.from(viewer.values, (value) => Math.round(1000 * value))"
        turn = f"((slider) => ({slide}, {values}))(document.getElementById('angle'))"
        found = np.array(shown.run(turn)) / 1000
        assert np.abs(found - von_mises(stress[node][..., k])).max() < 2e-3 * peak, angle
    u = np.array(shown.run("Array.from(viewer.moved)")).reshape(-1, 3)
    assert np.abs(u - moved[node][..., -1]).max() < 3e-3 * np.abs(moved).max()
    assert shown.run("document.querySelector('#chart-axial .now-value').textContent").startswith(
        f" {degrees[-1]}°: "
    )


@pytest.mark.parametrize("case", ["tension", "bending"])
def test_the_value_at_a_node_is_that_of_the_run(shown, case):
    _, result, _, _ = reported_rod()
    figures, found = result.summary.results[case], result.cases[case]
    shown.run(f"viewer.fly(viewer.header.spots.find((spot) => spot.result === '{case}'))")
    shown.run(DRAWN)
    assert shown.run("viewer.values[viewer.shown.spot]") == pytest.approx(figures.max_von_mises_MPa, rel=1e-3)
    picked = shown.run("viewer.valueAt(viewer.camera.seen(viewer.placeOf(viewer.shown.spot)))")
    assert picked["value"] == pytest.approx(figures.max_von_mises_MPa, rel=1e-3)
    assert picked["place"] == pytest.approx(figures.at_mm, abs=0.05)
    nodes = KDTree(result.mesh.points)
    for field, values in found.point_data().items():
        if field not in {"von_mises", "principal_1", "principal_2", "principal_3", "safety_factor_node"}:
            continue
        shown.run(f"viewer.show({{ field: '{field}' }})")
        value, place = shown.run(
            "[viewer.values[viewer.shown.spot], viewer.surface.place(viewer.shown.spot)]"
        )
        assert value == pytest.approx(values[nodes.query(place)[1]], abs=1e-3 * np.abs(values).max()), field


def test_the_pointer_tells_the_value(shown):
    shown.run("viewer.canvas.scrollIntoView({ behavior: 'instant', block: 'center' })")
    shown.run(DRAWN)
    x, y = shown.run("""((box, [x, y]) => [box.left + x * box.width, box.top + y * box.height])(
        viewer.canvas.getBoundingClientRect(),
        viewer.camera.seen(viewer.placeOf(viewer.surface.nearest([70, 0, 4]))))""")
    move = [{"type": "pointerMove", "x": round(x), "y": round(y)}]
    source = {"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}, "actions": move}
    shown.call("input.performActions", context=shown.page, actions=[source])
    said = shown.run(PROBED)
    assert re.fullmatch(r"[\d.]+ MPa at [−\d.]+, [−\d.]+, [−\d.]+ mm", said)
    before = shown.run("viewer.camera.towards")
    shown.drag((round(x), round(y)), (round(x) + 120, round(y) + 40))
    assert np.abs(np.array(shown.run("viewer.camera.towards")) - before).max() > 0.1


def test_keys_turn_zoom_and_return(shown):
    state = "viewer.camera.state()"
    shown.run("viewer.canvas.focus()")
    home = shown.run(state)
    shown.keys("\ue012", "\ue013", "+")  # left, up
    moved = shown.run(state)
    assert np.abs(np.subtract(moved["right"], home["right"])).max() > 0.1
    assert moved["half"] == pytest.approx(home["half"] / 1.25)
    shown.keys("-", "\ue011")  # Home
    again = shown.run(state)
    assert again["right"] == pytest.approx(home["right"], abs=1e-6)
    assert again["half"] == pytest.approx(home["half"])


def test_the_choices_work(shown):
    for label in ("Compression", "Worst of the cycle", "Crank cycle"):
        labels = "Array.from(document.querySelectorAll('.choices label'), (own) => own)"
        shown.run(f"{labels}.find((own) => own.textContent.trim() === '{label}').click()")
        assert shown.run("viewer.part('caption').textContent").startswith(label)
    fields = shown.run("Array.from(viewer.part('field').options, (option) => option.value)")
    assert fields[:4] == ["von_mises", "principal_1", "principal_2", "principal_3"]
    shown.run("viewer.part('play').click()")
    shown.run("new Promise((done) => setTimeout(done, 300))")
    shown.run("viewer.part('play').click()")
    assert shown.run("viewer.shown.angle") > 0
    assert shown.run("viewer.part('play').textContent") == "Play"


def test_it_reads_well_without_sight_and_fits_a_phone(shown):
    levels = shown.run("Array.from(document.querySelectorAll('h1, h2, h3'), (h) => Number(h.tagName[1]))")
    assert levels[0] == 1
    assert all(after - before <= 1 for before, after in pairwise(levels))
    assert shown.run(UNNAMED) == []
    assert shown.run(BARE_TABLES) == 0
    assert "von Mises stress" in shown.run("viewer.canvas.getAttribute('aria-label')")
    shown.size(390, 844)
    try:
        assert shown.run("document.documentElement.scrollWidth") <= 390
    finally:
        shown.size(1440, 900)


def test_it_prints_with_a_picture_in_place_of_the_rod(shown):
    pdf = shown.print()
    assert pdf.startswith(b"%PDF")
    assert b"/Image" in pdf
    assert shown.run("getComputedStyle(document.getElementById('still')).display") == "none"


def test_without_webgl_it_says_so_and_shows_a_picture(shown, report):
    hide = "() => { HTMLCanvasElement.prototype.getContext = () => null; }"
    script = shown.call("script.addPreloadScript", functionDeclaration=hide)["script"]
    try:
        shown.open(report)
        assert shown.run("window.feaReport") is None
        note = shown.run("document.getElementById('no-viewer').innerText")
        assert shown.run("document.getElementById('no-viewer').checkVisibility()")
        assert "no WebGL 2" in note
        assert "picture shows the worst load case" in note
        assert shown.run("document.querySelector('#still img').naturalWidth") > 1000
        assert shown.run("getComputedStyle(document.getElementById('still')).display") == "block"
    finally:
        shown.call("script.removePreloadScript", script=script)
        shown.open(report)
        shown.run(READY)
