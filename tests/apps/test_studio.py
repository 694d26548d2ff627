"""`fea studio` without a browser: who gets in, which frames come, and what is left when a process dies."""

import http.client
import json
import random
import signal
import threading

import pytest
from fake_studio import peak
from program import fea
from studios import Page, end, gone, served
from websockets.exceptions import ConnectionClosed, InvalidStatus

from fea.apps.studio.operating_point import OperatingPoint
from fea.apps.studio.session import Session, session
from fea.study.study import load_study

pytestmark = pytest.mark.slow


EVENTS = 10_000
START = {"design": {}, "operation": {}}


@pytest.fixture(scope="module")
def studio(tmp_path_factory):
    with served(tmp_path_factory.mktemp("studio")) as found:
        yield found


@pytest.fixture
def page(studio):
    with studio.page() as socket:
        found = Page(socket)
        found.serial = found.until("hello")["serial"] + 1
        yield found


def asked(studio, path, **headers):
    """Status, headers and text of a request, with Host and Origin as they are given."""
    connection = http.client.HTTPConnection(studio.url.hostname, studio.url.port, timeout=10)
    connection.putrequest("GET", path, skip_host=True)
    for name, value in ({"Host": studio.url.netloc} | headers).items():
        connection.putheader(name, value)
    connection.endheaders()
    answer = connection.getresponse()
    return answer.status, answer.headers, answer.read().decode()


def test_the_address_gives_the_page_and_a_policy_with_one_socket(studio):
    status, headers, text = asked(studio, f"/?{studio.url.query}")
    assert status == 200
    assert "<title>leon-2001 – fea studio</title>" in text
    policy = headers["Content-Security-Policy"]
    assert f"connect-src ws://{studio.url.netloc}/socket;" in policy
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy


def test_nobody_else_gets_in(studio):
    page = f"/?{studio.url.query}"
    for path, headers in {
        "/": {},
        "/?token=": {},
        "/?token=wrong": {},
        page: {"Host": "localhost:1"},
        f"/{page}": {"Host": f"evil.example:{studio.url.port}"},
        f"{page}&x": {"Origin": "http://evil.example"},
        f"/socket?{studio.url.query}": {},  # without an Origin
    }.items():
        assert asked(studio, path, **headers)[0] == 403, path
    assert asked(studio, f"/../pyproject.toml?{studio.url.query}")[0] == 404
    for refused in ({"origin": "http://evil.example"}, {"origin": "null"}, {"token": "wrong"}):
        with pytest.raises(InvalidStatus, match="403"):
            studio.page(**refused)


def test_random_events_give_no_stale_or_mixed_frame(page):
    operation, sent, events = OperatingPoint.of(load_study("leon-2001")), {}, random.Random(5)  # noqa: S311

    def drag():
        for number in range(EVENTS):
            design = {"web_thickness_mm": round(events.uniform(4, 6), 4)}
            rpm = events.choice([5000.0, 6000.0, 7000.0])
            rests = number == EVENTS - 1 or events.random() < 0.002
            sent[page.serial + 1] = {"design": design, "operation": {"rpm": rpm}}
            page.ask(design, rests=rests, touched="" if rests else "web_thickness_mm", rpm=rpm)

    page.until("frame", label="converged")
    first = page.serial
    thread = threading.Thread(target=drag)
    thread.start()
    before, frames, label = first, 0, ""
    while (before, label) != (first + EVENTS, "converged"):
        kind, told, numbers = page.heard()
        if kind != "frame" or told["serial"] <= first:
            continue
        assert told["serial"] >= before  # never older than one that was sent
        assert told["state"] == sent[told["serial"]]
        design, run = told["state"]["design"], operation.changed(told["state"]["operation"])
        stress = peak(design, run)
        assert told["figures"]["cases"][0]["peak_MPa"] == pytest.approx(stress, rel=1e-5)
        assert numbers[-8:] == pytest.approx([stress] * 8, rel=1e-6)
        before, label, frames = told["serial"], told["label"], frames + 1
    thread.join()
    assert frames > 20


def test_a_variant_gets_the_best_answer_and_undo_returns(page):
    state = page.ask({"web_thickness_mm": 4.5}, rests=True)
    page.until("frame", serial=page.serial, label="converged")
    page.say("keep", name="  light \n web ")
    kept = page.until("session")["variants"]["light web"]
    assert kept["state"] == state
    assert kept["answer"]["label"] == "converged"
    page.ask({"web_thickness_mm": 5.5}, rests=True)
    page.serial += 1
    page.say("move", by=-1, serial=page.serial)
    told = page.until("session", serial=page.serial)
    assert (told["design"], told["redo"]) == (state["design"], True)
    assert page.until("frame", serial=page.serial)["state"] == state


def test_what_is_saved_is_the_design(page, tmp_path):
    page.ask({"web_thickness_mm": 4.25}, rests=True, rpm=6500.0)
    page.say("export", what="study")
    written = page.until("written")
    (tmp_path / "saved.toml").write_text(written["text"])
    study = load_study(tmp_path / "saved.toml")
    assert study.rod.dimensions.web_thickness == 4.25
    assert study.speeds() == (6500.0,)
    page.say("keep", name="b")
    page.say("export", what="table")
    header, *rows = page.until("written")["text"].splitlines()
    assert header.split(",")[:3] == ["variant", "web_thickness_mm", "rpm"]
    assert any(row.startswith("b,4.25,6500.0") for row in rows)


def test_nonsense_from_a_page_is_refused(page):
    for told in ("{", "[]", '{"do": "run"}', '{"do": "__class__"}', '{"do": "export", "what": "x"}'):
        page.socket.send(told)
        page.until("note", bad=True)
    page.ask({"web_thickness_mm": "5"}, rests=False)
    page.until("note", bad=True)
    page.ask({"web_thickness_mm": 5.0}, rests=True, rpm=-1.0)
    assert "-1" in page.until("refused", serial=page.serial)["text"]


def test_another_tab_takes_over(studio, page):
    with studio.page() as second:
        with pytest.raises(ConnectionClosed) as closed:
            page.until("nothing")
        assert closed.value.rcvd.code == 4000
        assert Page(second).until("session")


def test_a_session_goes_on_from_its_journal(tmp_path):
    study, other = load_study("leon-2001"), {"design": {"web_thickness_mm": 5.5}, "operation": {}}
    with session(study, START, tmp_path) as kept:
        kept.change("commit", state=other)
        kept.change("keep", name="a", state=other, answer=None)
        kept.change("commit", state=START)
        kept.change("move", by=-1)
    (journal,) = tmp_path.glob("*.jsonl")
    with journal.open("ab") as file:
        file.write(b'{"kind": "commit", "state": {"desi')  # the disk was full
    for _ in range(2):
        with session(study, START, tmp_path) as kept:
            assert kept.described() == {**other, "undo": True, "redo": True, "variants": kept.variants}
            assert kept.variants == {"a": {"state": other, "answer": None}}
            kept.change("move", by=0)


def test_a_better_answer_replaces_that_of_a_variant():
    kept = Session([START])
    exact, converged = {"label": "exact on a moved mesh"}, {"label": "converged"}
    kept.change("keep", name="a", state=START, answer=None)
    assert kept.answered(START, exact)
    assert kept.answered(START, converged)
    assert not kept.answered(START, exact)
    assert not kept.answered({"design": {"length_mm": 1.0}, "operation": {}}, converged)
    assert kept.variants["a"]["answer"] == converged


def test_a_worker_that_dies_is_replaced_and_a_killed_server_leaves_none(studio, page):
    page.ask({}, rests=True)
    page.until("frame", serial=page.serial, label="converged")
    live, fresh = studio.workers()
    end(live)
    page.ask({"web_thickness_mm": 5.5}, rests=True)
    assert "SIGKILL" in page.until("note")["text"]
    page.until("frame", serial=page.serial, label="exact on a moved mesh")
    workers = studio.workers()
    assert live not in workers
    end(studio.process.pid)  # the last test of this server
    assert gone({*workers, fresh})


def test_a_study_that_cannot_be_solved_is_refused_with_the_reason(tmp_path):
    (tmp_path / "rod.step").write_text("ISO-10303-21;")
    arguments = ("rod.step", "--engine", "toyota-2jz", "--no-browser")
    with served(tmp_path, *arguments) as studio:
        for _ in range(2):  # a page that is loaded again hears it, too
            with studio.page() as socket:
                assert "rod.step" in Page(socket).until("refused")["text"]


def test_a_real_rod_from_the_command_to_a_saved_study(tmp_path):
    flags = ("--size", "14", "--pressure", "cosine-180")  # test_live_rod has pins in contact
    with served(tmp_path, "leon-2001", *flags, "--no-browser") as studio, studio.page() as socket:
        page = Page(socket)
        page.until("frame", label="exact on a moved mesh")
        page.ask({"web_thickness_mm": 5.25}, rests=True)
        exact = page.until("frame", serial=page.serial)
        assert exact["figures"]["failed"] == []
        page.say("export", what="study")
        saved = page.until("written")["path"]
        assert load_study(tmp_path / saved).rod.dimensions.web_thickness == 5.25
        # What is converged is what `fea run` of the saved study finds, which writes six digits.
        converged = page.until("frame", serial=page.serial, label="converged")["figures"]
        run = json.loads(fea("run", saved, "--cycle", "--json", cwd=tmp_path).stdout)
        found, cycle, near = run["results"], run["envelope"], {"rel": 5e-6}
        for case in converged["cases"]:
            assert case["factor"] == pytest.approx(found[case["name"]]["min_safety_factor"], **near)
            assert case["bar_percent"] == pytest.approx(found[case["name"]]["error_percent"], **near)
        assert converged["yielding"]["factor"] == pytest.approx(cycle["min_safety_factor"], **near)
        assert converged["fatigue"]["factor"] == pytest.approx(cycle["min_fatigue_safety_factor"], **near)
        page.say("export", what="step")
        assert (tmp_path / page.until("written")["path"]).read_text().startswith("ISO-10303-21")
        workers = studio.workers()
        studio.process.send_signal(signal.SIGINT)
        assert studio.process.wait(10) == 130
        assert gone(workers)
        assert studio.process.stdout.read() == ""
        assert "resumes its session" in studio.process.stderr.read()
