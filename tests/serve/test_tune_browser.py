"""A simulated machine is tuned by mouse in Chromium: plan, stop with a restored machine, a kept run, undo, a run in a terminal."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from tests.serve.yard import served

from bristle.tune.journal import Journal

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("chromium") is None, reason="needs chromium"),
    pytest.mark.skipif(os.name != "posix", reason="speaks to the browser over pipes of POSIX"),
]
EXAMPLE = Path(__file__).parents[2] / "examples" / "tune"
STEPS = "[...document.querySelectorAll('#run-steps li')]"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A simulated machine in the folder where the lab is started."""
    monkeypatch.setenv("BRISTLE_STATE_DIR", str(tmp_path / "state"))
    shutil.copytree(EXAMPLE, tmp_path / "machine")
    monkeypatch.chdir(tmp_path / "machine")
    return tmp_path / "machine"


@pytest.fixture
def server(folder):
    with served() as server:
        yield server


def test_plan_stop_run_report_and_undo(server, folder, tmp_path, person_at):
    person = person_at(server, width=390, height=844, dark=True)
    tab = person.tab
    person.clicks('#views button[value="tune"]')
    person.types("run-folder", "tuned")
    person.clicks("#plan")
    person.waits("state.parts.planned && byId('planned').textContent.includes('40 s')")
    assert not (folder / "tuned" / "journal.jsonl").exists()
    assert tab.run("document.documentElement.scrollWidth <= innerWidth")

    person.clicks("#move")
    person.waits(f"{STEPS}[6]?.className === 'is-running'", 120)
    assert tab.run(f"{STEPS}[6].textContent.includes('s left')")
    assert tab.run("byId('run-plots').querySelectorAll('canvas').length") == 3
    person.clicks("#stop")
    person.waits("run?.outcome === 'restored'", 180)
    journal = Journal(folder / "tuned")
    assert journal.last("stopped")["code"] == "operator"
    assert journal.last("restored")["identical"]
    assert "stopped in the lab" in tab.run("byId('run-outcome').textContent")

    person.clicks("#move")
    person.waits("run?.outcome === 'kept' && state.job.state === 'done'", 240)
    assert "Kept: 148 µm → 4" in tab.run("byId('outcome').textContent")
    assert "95 % interval" in tab.run("byId('run-outcome').textContent")
    assert tab.run(f"{STEPS}.every(({{ className }}) => className === 'is-passed')")
    person.waits("byId('run-plots').textContent.includes('without and with the feedforward')")
    person.clicks("#run-report")
    person.waits("byId('run-shown').querySelector('iframe')")
    tab.reload()
    person.waits("typeof state !== 'undefined' && run?.outcome === 'kept' && !byId('tune').hidden")
    assert tab.run("byId('run-folder').value") == "tuned"
    tab.run("window.confirm = () => true")
    person.clicks("#undo")
    person.waits("run?.outcome === 'undone'")
    assert Journal(folder / "tuned").last("restored")["cause"] == "undo"


def test_a_run_in_a_terminal_is_shown_live(server, folder, tmp_path, person_at):
    code = "import sys; from bristle.cli.main import main; sys.exit(main(sys.argv[1:]))"
    person = person_at(server)
    tab = person.tab
    person.clicks('#views button[value="tune"]')
    person.clicks("#open-run")
    person.waits("state.machine")
    assert tab.run("byId('run-view').hidden")
    with subprocess.Popen([sys.executable, "-c", code, "tune", "machine.toml", "--out", "tuned", "--move", "--quiet"]) as process:
        person.waits(f"{STEPS}.some((step) => step.className === 'is-running' && step.textContent.includes('last entry'))")
        person.waits("byId('run-plots').querySelector('canvas')")
        assert process.poll() is None
        person.clicks("#plan")  # the machine is in use
        person.waits("byId('plan-failed').textContent.includes('used by another run')")
        assert process.wait(240) == 0
    person.waits("run?.outcome === 'kept'")
