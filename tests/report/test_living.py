"""The interactive report: its numbers equal those of the report, its loop equals the simulation."""

import base64
import hashlib
import re
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from tests.apps.lab.browser import firefox
from tests.apps.lab.scripts import needs_node, printed
from tests.report.pages import Page
from tests.report.test_pages import identification_page

from bristle import friction
from bristle.apps.lab.living import SHARED, living_part
from bristle.apps.targets.page import rows as rows_module
from bristle.cli.demonstration.run import run
from bristle.core.contracts import Model
from bristle.core.experiment import Start
from bristle.files.results import results_folder
from bristle.prediction.following import following_of
from bristle.simulation import COMPENSATED, compensation_experiment, simulate

MOST = 400_000  # bytes that a report grows by
AGREES, THINNED = 0.01, 0.03  # of the report's own number


def living_of(bench, simulation=None):
    following = None if simulation else following_of(bench.log, bench.looped)
    return living_part(bench.identified, bench.axis, simulation or bench.looped, following)


@pytest.fixture(scope="module")
def living(workbenches):
    return living_of(workbenches["translational"])


@pytest.fixture(scope="module")
def plain(workbenches):
    return identification_page(workbenches["translational"])


@pytest.fixture(scope="module")
def report(workbenches, living):
    return identification_page(workbenches["translational"], living=living)


@pytest.fixture(scope="module")
def file(report, tmp_path_factory):
    file = tmp_path_factory.mktemp("living") / "report.html"
    file.write_text(report, encoding="utf-8")
    return file


BEGIN = """
const pair = ({ name, values }) => [name, numbersOf(values)], first = (rows) => Object.fromEntries(rows.map(pair));
const frictionInRows = (contact, rows) => weighed(rows, rows.stretches.map((stretch) => forcesIn(contact, stretch, rows.sampleTime)));
"""


def computed(living, folder, script):
    """Return the output of a script on the data of a report, in node."""
    values = f"const data = {living.data}, say = (v) => console.log(JSON.stringify(v));"
    return printed(
        folder, [*SHARED, "paths.js", "rows.js"], values, BEGIN, f"(async () => {{{script}}})();"
    )


LEFT = """
const rows = await rowsOf(data.rows), contact = await loaded(data.model);
const values = first([...data.model.variables, ...data.plant]);
for (const { name } of data.model.variables) contact.set(name, values[name]);
const friction = frictionInRows(contact, rows), mechanical = mechanicalInRows(rows, values);
const predicted = friction.map((force, k) => force + mechanical[k]), { rms, share } = misfit(rows.measured, predicted);
say([rms, 100 * share, [...rows.t], [...predicted], [...rows.velocity]]);
"""


@needs_node
def test_residual_of_the_page_equals_that_of_the_report(workbench, tmp_path):
    fit = workbench.identified.best
    rms, percent, times, predicted, velocity = computed(living_of(workbench), tmp_path, LEFT)
    assert (rms, percent) == pytest.approx(
        (np.sqrt(np.mean(fit.traces.residual**2)), fit.force_error_percent), rel=AGREES
    )
    assert times == pytest.approx(fit.traces.time.tolist())
    away = np.array(predicted) - fit.traces.predicted
    assert np.sqrt(np.mean(away**2)) < 0.06 * rms
    assert velocity == pytest.approx(
        fit.traces.velocity, abs=0.01 * np.max(np.abs(fit.traces.velocity))
    )


@pytest.mark.slow
@needs_node
def test_thinned_log_keeps_reversals_and_number_of_rows(stage, tmp_path, monkeypatch):
    fit, log = stage.identified.best, stage.log
    whole = rows_module.fitted_rows(fit, log, stage.axis, stage.identified.treatment)
    monkeypatch.setattr(rows_module, "MOST_INTERVALS", 1500)
    rows = rows_module.fitted_rows(fit, log, stage.axis, stage.identified.treatment)
    (stretch,), (all_of_it,) = rows.stretches, whole.stretches
    assert all_of_it.ends.tolist() == list(range(len(log)))
    assert stretch.ends.size < 1500
    turns = rows_module.turns_of(all_of_it.positions, 0.0)
    assert turns.size > 20
    assert {max(turn + k, 0) for turn in turns[1:-1] for k in range(-4, 5)} <= set(stretch.ends)
    _, percent, *_ = computed(living_of(stage), tmp_path, LEFT)
    assert percent == pytest.approx(fit.force_error_percent, rel=THINNED)


RESTS = """
const contact = await loaded(data.model), stretch = { origin: 0, ends: [0, 1, 2, 3], begin: [] };
for (const [name, values] of Object.entries(first(data.model.variables))) contact.set(name, values);
const led = (places) => forcesIn(contact, { ...stretch, places }, 1e-3);
say([led([1e-4, 2e-4, 2e-4, 2e-4]), led([-1e-4, -2e-4, -2e-4, -2e-4])]);
"""


@pytest.mark.slow
@needs_node
def test_rest_keeps_the_force_of_its_approach(stage, tmp_path):
    values = stage.identified.best.friction.values
    forward, backward = computed(living_of(stage), tmp_path, RESTS)
    assert forward[2:] == pytest.approx([values["F_S_pos"] + values["offset"]] * 2)
    assert backward[2:] == pytest.approx([values["offset"] - values["F_S_neg"]] * 2)


def test_long_logs_are_thinned(stage, monkeypatch):
    fit, log = stage.identified.best, stage.log
    monkeypatch.setattr(rows_module, "MOST_ROWS", 200)
    rows = rows_module.fitted_rows(fit, log, stage.axis, stage.identified.treatment)
    (stretch,) = rows.stretches
    assert 150 < stretch.rows.size <= 200
    times = log.sample_time * stretch.rows + stretch.time
    kept = np.searchsorted(fit.traces.time, times - 1e-9)
    assert fit.traces.time[kept] == pytest.approx(times)
    assert rows.measured.step * rows.measured.numbers == pytest.approx(
        fit.traces.measured[kept], abs=rows.measured.step
    )
    # The number of the report is that of all rows.
    assert rows.percent == pytest.approx(fit.force_error_percent)


FOLLOWED = """
const { loop } = data.loop, values = first(data.model.variables), limit = Number(loop.limit);
const { error } = await followedMove({ loop: { ...loop, limit }, model: data.model, values, mass: loop.mass });
say([...error]);
"""


def run_as(bench, **changes):
    """Return the loop of a bench with other run settings."""
    experiment = bench.looped.experiment
    variants = tuple(
        replace(variant, run=replace(variant.run, **changes)) for variant in experiment.variants
    )
    return simulate(replace(experiment, variants=variants))


@pytest.mark.fast_cases(1)
@needs_node
@pytest.mark.parametrize(
    ("changes", "share"),
    [({}, 1.0), ({"delay": 1, "current_lag": 5e-4}, 1.0), ({"effort_limit": 33.0}, 0.95)],
)
def test_loop_of_the_page_equals_the_simulation(changes, share, stage, tmp_path):
    simulation = run_as(stage, **changes) if changes else stage.looped
    result = simulation.variants[COMPENSATED]
    error = np.array(computed(living_of(stage, changes and simulation), tmp_path, FOLLOWED))
    wanted, count = result.reference - result.measured, stage.axis.resolution
    assert error.size == wanted.size
    # A place between two counts may be read as either, and behind a limit the loops part for a while.
    assert np.mean(np.abs(error - wanted) < 1.5 * count) >= share
    judged = slice(round(0.3 / result.time[1]), None)
    # Where both read the same count, the peaks are the same; where they do not, it is the next one.
    same = np.abs(error - wanted)[judged] < 0.5 * count
    assert np.mean(same) >= 0.8 * share
    assert np.ptp(error[judged][same]) == pytest.approx(
        np.ptp(wanted[judged][same]), rel=1e-4, abs=0.01 * count
    )
    assert np.ptp(error[judged]) == pytest.approx(
        result.following_error.peak_to_peak, rel=1e-4, abs=1.01 * count
    )


@needs_node
@pytest.mark.slow
def test_loop_that_begins_in_motion_begins_sliding(stage, tmp_path):
    model = friction.lugre(F_C=8.0, F_S=10.0, v_S=5e-3, sigma_0=1e6, sigma_1=800.0, sigma_2=30.0)
    experiment = stage.looped.experiment
    plant, law = experiment.variants[0].plant, experiment.variants[0].controller
    t = 1e-3 * np.arange(2000)
    simulation = simulate(
        compensation_experiment(
            plant,
            model,
            model,
            law,
            0.02 * np.sin(3.0 * t),
            1e-3,
            resolution=2e-7,
            start=Start(0.0, 0.06, 0.0, 9.0),
        )
    )
    best = replace(stage.identified.best, friction=model)
    bench = replace(stage, identified=replace(stage.identified, fits=(best,)))
    error = np.array(computed(living_of(bench, simulation), tmp_path, FOLLOWED))
    result = simulation.variants[COMPENSATED]
    assert np.max(np.abs(error - (result.reference - result.measured))) < 1.5 * 2e-7
    # A virgin contact would pull it along at first.
    assert np.max(np.abs(error[:20])) < 0.5 * 10.0 / 1e6


def test_models_with_load_are_not_interactive(stage):
    best = stage.identified.best
    component = friction.with_slots(friction.stribeck, ["load", "asymmetry"])
    loaded = replace(best, friction=Model(component, best.friction.parameters, best.friction.kind))
    assert (
        rows_module.fitted_rows(loaded, stage.log, stage.axis, stage.identified.treatment) is None
    )


def test_unrepeatable_treatment_is_not_interactive(stage):
    treatment = stage.identified.treatment | {"decimation": 7.0}
    assert rows_module.fitted_rows(stage.identified.best, stage.log, stage.axis, treatment) is None


@pytest.mark.slow
def test_policy_allows_only_the_scripts_and_report_stays_small(report, plain):
    assert len(report.encode()) - len(plain.encode()) < MOST
    page = Page(report)
    assert page.unbalanced == []
    policy = next(attrs["content"] for attrs in page.named("meta") if "http-equiv" in attrs)
    rules = dict(rule.strip().split(" ", 1) for rule in policy.split(";"))
    assert rules["default-src"] == "'none'"
    scripts = re.findall(r'<script(?: id="shared")?>(.*?)</script>', report, re.DOTALL)
    hashes = {
        f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
        for text in scripts
    }
    assert len(scripts) == 3
    assert set(rules["script-src"].split()) == hashes | {"'wasm-unsafe-eval'"}
    assert not re.search(
        r"https?:|//[a-z]+\.|@import|\bfetch\(|XMLHttp|importScripts|\son[a-z]+=\"", report
    )


@pytest.mark.slow
def test_without_scripts_the_pictures_remain(report, plain):
    section = next(attrs for _, attrs in Page(report).tags if attrs.get("id") == "alive")
    assert "hidden" in section
    assert len(Page(plain).named("script")) == 1
    assert [attrs["id"] for attrs in Page(plain).named("figure")] == [
        attrs["id"] for attrs in Page(report).named("figure")
    ]


SLIDE = """
(async () => {
  const slider = document.querySelector('input[type="range"][name="F_C_pos"]');
  slider.value = Number(slider.value) + 300;
  slider.dispatchEvent(new Event("input"));
  await new Promise((done) => setTimeout(done, 50));
  const told = () => byId("alive-following-told").textContent, wait = (done) => setTimeout(done, 50);
  for (let k = 0; k < 200 && !/with these values/.test(told()); k++) await new Promise(wait);
  const width = ({ error }) => extent(error, 300)[1] - extent(error, 300)[0];
  return [alive.found.rms, alive.start.rms, following.asked.worker !== "none",
    width(following.asked.found), width(following.start)];
})()
"""
READY = """
new Promise((done) => {
  const look = () => (alive.start && following.start ? done(true) : setTimeout(look, 50));
  look();
})
"""
UNFOLD = "document.querySelectorAll('.unfold').forEach((button) => button.click())"
BOX = "(({ x, y, width, height }) => [x, y, width, height])(document.querySelector('#figure-%s svg').getBoundingClientRect())"
PATHS = "[...document.querySelectorAll('#figure-%s [data-curve] path')].map((path) => path.getAttribute('d')).join()"
WHEEL = "new WheelEvent('wheel', { deltaY: -400, ctrlKey: %s, cancelable: true, clientX: %f, clientY: %f })"
VIEW = "plots.get('velocity').panels[0].x.view"


@pytest.mark.slow
@pytest.mark.parametrize("width", [360, 3840])
def test_page_is_interactive_without_errors(file, width, shown):
    tab = shown(file.as_uri(), width=width, height=900)
    tab.run(READY)
    tab.run(UNFOLD)
    before = {name: tab.run(PATHS % name) for name in ("gain", "velocity")}
    moved, identified, in_worker, after, first = tab.run(SLIDE)
    assert moved > 2.0 * identified
    assert in_worker
    assert after > 1.5 * first
    assert {name for name, paths in before.items() if tab.run(PATHS % name) == paths} == set()
    tab.run("document.getElementById('figure-velocity').scrollIntoView({ block: 'center' })")
    x, y, wide, high = tab.run(BOX % "velocity")
    tab.call("Input.dispatchMouseEvent", type="mouseMoved", x=x + 0.6 * wide, y=y + 0.2 * high)
    tab.run("new Promise((done) => setTimeout(done, 100))")
    text = tab.run("document.querySelector('#figure-velocity .reading').textContent")
    assert re.fullmatch(r"Velocity [−\d.]+ mm/s: (measured|model) [−\d.]+ N.*", text)
    tab.drag((x + 0.3 * wide, y + 0.3 * high), (x + 0.5 * wide, y + 0.31 * high))
    low, high_end = tab.run(VIEW)
    assert 0.1 < low < high_end < 0.9
    tab.run(
        "document.querySelector('#figure-velocity svg').dispatchEvent(new MouseEvent('dblclick'))"
    )
    assert tab.run(VIEW) == [0, 1]
    zoom = f"document.querySelector('#figure-velocity svg').dispatchEvent({WHEEL})"
    place = (x + 0.5 * wide, y + 0.5 * high)
    tab.run(zoom % ("false", *place))
    assert tab.run(VIEW) == [0, 1]
    tab.run(zoom % ("true", *place))
    low, high_end = tab.run(VIEW)
    assert 0.0 < low < 0.5 < high_end < 1.0
    tab.run("byId('alive-reset').click()")
    tab.run("new Promise((done) => setTimeout(done, 100))")
    assert tab.run("alive.found === alive.start")
    tab.run("plots.forEach((plot) => plot.all())")
    assert {name: tab.run(PATHS % name) for name in before} == before
    assert tab.run("document.documentElement.scrollWidth <= innerWidth")
    assert {address for address in tab.asked_for() if not address.startswith("blob:null/")} == {
        file.as_uri()
    }


@pytest.mark.slow
def test_the_strip_selects_the_part_of_the_large_picture(file, shown):
    tab = shown(file.as_uri(), width=1366, height=768)
    tab.run(READY)
    at = "(({ x, y }) => [x, y])(((svg, { left, right, top, bottom }) => new DOMPoint(left + %f * (right - left), 0.5 * (top + bottom))"
    at += (
        ".matrixTransform(svg.getScreenCTM()))(plots.get('gain').svg, plots.get('gain').panels[1]))"
    )
    (first, middle), (second, _) = (tab.run(at % share) for share in (0.2, 0.5))
    tab.drag((first, middle), (second, middle))
    low, high_end, span = tab.run(
        "(([main, strip]) => [main.x.valueAt(main.left), main.x.valueAt(main.right), strip.facts.x.ends])(plots.get('gain').panels)"
    )
    wanted = [span[0] + share * (span[1] - span[0]) for share in (0.2, 0.5)]
    assert [low, high_end] == pytest.approx(wanted, abs=0.02 * (span[1] - span[0]))
    # The large picture has lines there, too.
    assert (
        tab.run(
            "plots.get('gain').panels[0].pointsOf(plots.get('gain').panels[0].curves[1]).length"
        )
        > 500
    )


STIFFER = """
(async () => {
  const slider = document.querySelector('input[type="range"][name="sigma_0"]');
  slider.value = Number(slider.value) + 300;
  slider.dispatchEvent(new Event("input"));
  await new Promise((done) => setTimeout(done, 200));
})()
"""
HEIGHT_AT = """
((part) => {
  const panel = plots.get("reversals").panels[0], points = panel.pointsOf(panel.curves.find(({ name }) => name === "model"));
  const x = panel.left + part * (panel.right - panel.left);
  const close = points.filter((point) => Math.abs(point[0] - x) < 8).map((point) => point[1]);
  return close.reduce((sum, y) => sum + y, 0) / close.length;
})(%f)
"""


@pytest.mark.slow
def test_a_stiffer_contact_builds_up_its_friction_earlier(tmp_path, shown):
    with results_folder(tmp_path / "demo") as folder:
        run(folder, command="bristle demo")
    page = tmp_path / "demo" / "report.html"
    assert len(page.read_bytes()) <= 800_000
    tab = shown(page.as_uri(), width=1366, height=768)
    tab.run(
        "new Promise((done) => { const look = () => (document.body.dataset.alive ? done(true) : setTimeout(look, 50)); look(); })"
    )
    tab.run(UNFOLD)
    shares = (0.05, 0.9)
    before = [tab.run(HEIGHT_AT % share) for share in shares]
    tab.run(STIFFER)
    early, late = (
        old - tab.run(HEIGHT_AT % share) for share, old in zip(shares, before, strict=True)
    )
    assert early > 8.0  # points upwards
    assert abs(late) < 2.0
    tab.run("byId('alive-reset').click()")
    # An instant at which the axis moves backward is marked on the left half of friction over velocity.
    tab.run("markInstant(5.0)")
    marked = "Number(plots.get('%s').marks.querySelector('circle')?.getAttribute('cx'))"
    middle = tab.run("(({ left, right }) => 0.5 * (left + right))(plots.get('velocity').panels[0])")
    assert 0.0 < tab.run(marked % "velocity") < middle
    x, y, wide, high = tab.run(BOX % "gain")
    tab.run("plots.get('velocity').clear()")
    tab.call("Input.dispatchMouseEvent", type="mouseMoved", x=x + 0.5 * wide, y=y + 0.3 * high)
    tab.run("new Promise((done) => setTimeout(done, 100))")
    assert tab.run(marked % "velocity") > 0.0


@pytest.mark.slow
def test_a_link_opens_the_tab_of_its_section(file, shown):
    tab = shown(f"{file.as_uri()}#log", width=1366, height=768)
    assert (
        tab.run("getComputedStyle(document.getElementById('log').parentElement).display") == "block"
    )
    assert (
        tab.run("getComputedStyle(document.getElementById('drive').parentElement).display")
        == "none"
    )


WAIT = """
return (async () => {
  const text = (name) => document.getElementById(name).textContent;
  const wait = (done) => setTimeout(done, 50), ready = () => /Computed/.test(text("alive-following-told"));
  for (let k = 0; k < 600 && !ready(); k++) await new Promise(wait);
  return [text("alive-following-told"), text("alive-told")];
})();
"""


@pytest.mark.slow
def test_printed_page_is_the_static_report(file, shown):
    tab = shown(file.as_uri())
    tab.run(READY)
    tab.call("Emulation.setEmulatedMedia", media="print")
    assert tab.run("getComputedStyle(byId('alive')).display") == "none"
    shown = "[...document.querySelectorAll('h2')].filter((node) => !node.getClientRects().length).map((node) => node.textContent)"
    assert tab.run(shown) == []


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("firefox-esr") is None, reason="needs firefox-esr")
def test_page_has_no_errors_in_firefox(file, tmp_path):
    with firefox(tmp_path / "profile") as tab:
        tab.call("WebDriver:Navigate", url=file.as_uri())
        message = tab.run(WAIT)
        assert "peak to peak, computed on this page" in message[0]
        assert "rms" in message[1]
        assert tab.complaints("report.html") == []
        assert tab.complaints("Content-Security-Policy") == []


# --- The printed report of a browser


MOST_PAGES = 8  # of the identification of a loop, with all of its tabs


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("chromium") is None, reason="needs chromium")
def test_report_of_a_loop_prints_on_eight_pages(stage, tmp_path):
    (tmp_path / "report.html").write_text(identification_page(stage), encoding="utf-8")
    subprocess.run(
        [
            "chromium",
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            f"--user-data-dir={tmp_path / 'profile'}",
            "--no-pdf-header-footer",
            f"--print-to-pdf={tmp_path / 'report.pdf'}",
            (tmp_path / "report.html").as_uri(),
        ],
        check=True,
        capture_output=True,
        timeout=120,
    )
    assert (
        1
        <= len(re.findall(rb"/Type\s*/Page[^s]", (tmp_path / "report.pdf").read_bytes()))
        <= MOST_PAGES
    )
