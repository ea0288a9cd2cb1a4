"""The whole of it by mouse alone in Debian's Chromium, and the same files as the command line writes, byte for byte."""

import os
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import numpy as np
import pytest
from tests.apps.lab.server.yard import served
from tests.cli.conftest import EXPERIMENT
from tests.examples.data import measured

from bristle.apps.tune.journal import Journal
from bristle.cli.demonstration.axis_simulated import AXIS_FILE, write_log
from bristle.cli.main import main
from bristle.files import NOTE, read_experiment
from bristle.simulation import simulate

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("chromium") is None, reason="needs chromium"),
    pytest.mark.skipif(os.name != "posix", reason="speaks to the browser over pipes of POSIX"),
]


RATED = 250.0  # [N]
EMPS = Path(__file__).parents[4] / "examples" / "emps" / "axis.toml"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two logs of an axis as a drive exports them: in mm and in % of a rated force, which stands above the columns."""
    folder = tmp_path_factory.mktemp("drive")
    for name, frequency in (("log", 0.5), ("other", 0.7)):
        (folder / "experiment.toml").write_text(EXPERIMENT.replace("0.5 Hz", f"{frequency} Hz"))
        run = simulate(read_experiment(folder / "experiment.toml")).variants["none"]
        columns = np.column_stack((run.time, 1e3 * run.measured, 100.0 * run.effort / RATED))
        head = f"Rated force: {RATED:g} N\ntime [s],position [mm],force [%]"
        np.savetxt(
            folder / f"{name}.csv", columns, delimiter=",", header=head, comments="", fmt="%.9g"
        )
    return folder


def archived(file):
    with zipfile.ZipFile(file) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def written(folder):
    """Return what the command line wrote."""
    return {file.name: file.read_bytes() for file in folder.iterdir() if file.name != NOTE}


def test_a_csv_in_mm_and_percent_by_mouse_alone(
    server, folder, tmp_path, monkeypatch, capsys, person_at
):
    person = person_at(server, width=1366, height=900)
    tab = person.tab
    person.chooses(folder / "log.csv")
    person.clicks('input[name="role"][value="held_out"]')
    person.chooses(folder / "other.csv")
    # What is proposed is right; a sign that is turned round is seen in the check, and is turned back.
    person.waits("state.parts.looked && !state.parts.looked.old && byId('check-now')")
    assert tab.run("document.getElementsByName('columns.effort.unit')[0].value") == "%"
    assert tab.run("document.getElementsByName('effort.rated')[0].value") == "250 N"
    # What is asked for while another job begins waits for it, and is not refused.
    tab.run("Promise.all([start('look'), start('look'), look()]).then(() => true)")
    person.clicks('button[name="columns.effort.sign"]')
    person.waits("state.axis.text.includes('sign = -1') && state.job.state === 'done'")
    person.clicks('button[name="columns.effort.sign"][aria-pressed="true"]')
    person.waits("!state.axis.text.includes('sign') && state.job.state === 'done'")
    person.identifies("coulomb_viscous")
    person.waits("state.parts.predicted && byId('predicted').textContent.includes('other.csv')")
    assert "model error" in tab.run("byId('predicted').textContent")
    person.waits("document.querySelector('iframe')")
    results = archived(person.loads("#results", "results.zip"))
    person.clicks('input[name="target"][value="c"]')
    person.clicks("#export")
    export = archived(person.loads("#download-export", "axis_x_c.zip"))
    assert {address.split("/")[2] for address in tab.asked_for() if address.startswith("http")} == {
        f"127.0.0.1:{server.port}"
    }
    # The same at a terminal, with the files as they are called there.
    shutil.copy(folder / "log.csv", tmp_path / "log.csv")
    monkeypatch.chdir(tmp_path)
    assert main(["log", "log.csv", "--write", "axis.toml"]) == 0
    line = [
        "identify",
        "log.csv",
        "--axis",
        "axis.toml",
        "--model",
        "coulomb_viscous",
        "--out",
        "results",
    ]
    assert main(line) == 0
    assert results == written(tmp_path / "results")
    line = [
        "export",
        "results",
        "--to",
        "c",
        "--out",
        "axis_x_c",
        "--name",
        "axis_x",
        "--axis",
        "axis.toml",
    ]
    assert main(line) == 0
    assert export == written(tmp_path / "axis_x_c")
    capsys.readouterr()


def test_from_the_log_of_the_demonstration_to_a_compensated_loop_without_a_text_file(
    server, tmp_path, person_at
):
    write_log(tmp_path / "log.csv", 1)
    known = tomllib.loads(AXIS_FILE.read_text(encoding="utf-8"))
    person = person_at(server, width=1366, height=768)
    tab = person.tab
    person.chooses(tmp_path / "log.csv")
    person.waits("document.getElementsByName('effort.constant').length")
    person.types("effort.constant", "61.2")
    person.waits("byId('columns').textContent.includes('Add the unit: N/A or N*m/A')")
    person.types("effort.constant", known["effort"]["force_constant"])
    person.waits("state.parts.looked.ready && state.job.state === 'done'")
    person.clicks("#drive-fields summary")
    person.types("encoder.resolution", known["encoder"]["resolution"])
    person.waits("state.axis.text.includes('resolution') && state.job.state === 'done'")
    assert known["effort"]["held"]
    person.types("effort.hold", "zero")
    person.waits(
        "state.axis.text.includes('hold') && state.parts.looked.ready && state.job.state === 'done'"
    )
    person.identifies()
    assert tab.run("state.parts.identified.model") == "lugre+asymmetry"
    assert tab.run("byId('ruling').textContent") == "Usable"
    # The page went to the verdict.
    assert tab.run("Math.abs(byId('step-5').getBoundingClientRect().top) < 40")
    person.clicks("#compensate-now")
    person.waits("byId('compensate-failed').textContent.includes('controller is missing')")
    person.selects("controller.model", known["controller"].pop("model"))
    for name, value in known["controller"].items():
        person.types(f"controller.{name}", value)
    person.types("effort.limit", known["effort"]["limit"])
    person.clicks("#compensate-now")
    person.waits("byId('gain')")
    assert not tab.run("state.parts.identified.old")
    # Seven tenths of the friction are fed forward, as by `bristle demo`.
    assert float(tab.run("byId('gain').textContent").rpartition("×")[2]) == pytest.approx(
        3.4, abs=0.1
    )
    assert "Friction forward, F+" in tab.run("byId('compensate').textContent")
    person.clicks("#compensate .copied button")
    person.waits("document.querySelector('#compensate .copied button').textContent === 'Copied'")
    person.clicks("#export")
    export = archived(person.loads("#download-export", "axis_x_table.zip"))
    assert any(name.endswith(".csv") for name in export), sorted(export)


def test_reload_two_tabs_and_cancel(server, folder, tmp_path, person_at):
    person = person_at(server, complains=True, width=360, height=740, dark=True)
    tab = person.tab
    person.chooses(folder / "log.csv")
    person.clicks("#check-now")
    person.waits("!byId('step-4').classList.contains('locked')")
    assert tab.run("document.documentElement.scrollWidth <= innerWidth")
    address = tab.run("location.href")
    # A second tab of the same analysis shows it, one of the printed address begins another.
    first = tab.session
    sessions = {}
    for name, where in (("same", address), ("own", server.address)):
        tab.session = None
        target = tab.call("Target.createTarget", url=where)["targetId"]
        tab.session = sessions[name] = tab.call(
            "Target.attachToTarget", targetId=target, flatten=True
        )["sessionId"]
        tab.waits("state !== null")
    assert tab.run("state.files.length") == 0
    assert tab.run("location.href") != address
    tab.session = first
    tab.call("Page.bringToFront")  # the browser slows down a tab that nobody sees
    person.ticks(
        "model", "coulomb_viscous", "lugre", "elastoplastic", "gms", "leuven", "preisach_lugre"
    )
    person.clicks("#identify")
    person.waits("state.job.task === 'identify' && state.job.state === 'runs'")
    tab.session = sessions["same"]
    tab.waits("state.job.task === 'identify'")
    tab.waits("!byId('job').hidden")
    # The page is loaded again while the job runs, and then it is cancelled: the best so far stays.
    tab.session = first
    tab.reload()
    person.waits("state && state.job && state.job.state === 'runs'")
    person.waits("/, [1-9].* models fitted/.test(state.job.text)", 120)  # there is a best so far
    person.clicks("#cancel")
    person.waits("state.job.state !== 'runs'", 120)
    assert tab.run("[state.job.state, state.job.cancelled]") == ["done", True]
    person.waits("byId('verdict').textContent.includes('Unfinished')")
    assert "interrupted" in tab.run("state.parts.identified.unfinished")
    tab.session = sessions["same"]
    tab.waits("byId('verdict').textContent.includes('Unfinished')")


def test_a_motion_is_designed_and_a_damaged_log_is_reported(server, tmp_path, person_at):
    (tmp_path / "damaged.mat").write_bytes(b"MATLAB 5.0 MAT-file" + bytes(range(256)) * 3)
    (tmp_path / "axis.toml").write_text(
        'schema = 1\nkind = "translational"\n[limits]\nvelocity = "0.2 m/s"\nacceleration = "4 m/s^2"\n'
        'stroke = ["0 mm", "200 mm"]\n'
        '[effort]\nlimit = "200 N"\n[plant]\nmass = "12 kg"\npresliding = "20 um"\n[encoder]\nresolution = "0.1 um"\n'
    )
    person = person_at(server, complains=True)
    tab = person.tab
    person.chooses(tmp_path / "damaged.mat")
    person.waits("!byId('failed').hidden")
    assert "damaged.mat" in tab.run("byId('failed').textContent")
    person.clicks("#logs li button:last-child")
    person.waits("state.files.length === 0")
    person.chooses(tmp_path / "axis.toml")
    person.clicks("#to-excite")
    for purpose in ("break-away", "damping", "presliding"):
        person.clicks(f'#excitation input[value="{purpose}"]')
    person.clicks("#design")
    person.waits("state.parts.excited && byId('excited').querySelector('iframe')", 300)
    motion = archived(person.loads("#excited .tools button", "motion.zip"))
    assert {
        "motion.csv",
        "moves.csv",
        "motion.nc",
        "axis.toml",
        "report.html",
        "summary.json",
    } == set(motion)
    assert motion["motion.csv"].count(b"\n") > 1000


@pytest.mark.measured
def test_emps_by_mouse_alone(server, tmp_path, monkeypatch, capsys, person_at):
    shutil.copy(measured("emps", "DATA_EMPS.mat"), tmp_path / "DATA_EMPS.mat")
    shutil.copy(EMPS, tmp_path / "axis.toml")
    person = person_at(server)
    person.chooses(tmp_path / "DATA_EMPS.mat", tmp_path / "axis.toml")
    person.waits(
        "state.files.length && state.axis.text && state.parts.looked && !state.parts.looked.old"
    )
    person.identifies("coulomb_viscous", by_direction=True)
    results = archived(person.loads("#results", "results.zip"))
    monkeypatch.chdir(tmp_path)
    models = "coulomb_viscous,coulomb_viscous+asymmetry"
    line = [
        "identify",
        "DATA_EMPS.mat",
        "--axis",
        "axis.toml",
        "--model",
        models,
        "--out",
        "results",
    ]
    assert main(line) == 0
    expected = written(tmp_path / "results")
    assert results == expected
    capsys.readouterr()


# --- A simulated machine is tuned by mouse: plan, stop with a restored machine, a kept run, undo, a run in a terminal


EXAMPLE = Path(__file__).parents[4] / "examples" / "tune"
STEPS = "[...document.querySelectorAll('#run-steps li')]"


@pytest.fixture
def machine_folder(tmp_path, monkeypatch):
    """A simulated machine in the folder where the lab is started."""
    monkeypatch.setenv("BRISTLE_STATE_DIR", str(tmp_path / "state"))
    shutil.copytree(EXAMPLE, tmp_path / "machine")
    monkeypatch.chdir(tmp_path / "machine")
    return tmp_path / "machine"


@pytest.fixture
def machine_server(machine_folder):
    with served() as machine_server:
        yield machine_server


def test_plan_stop_run_report_and_undo(machine_server, machine_folder, tmp_path, person_at):
    person = person_at(machine_server, width=390, height=844, dark=True)
    tab = person.tab
    person.clicks('#views button[value="tune"]')
    person.types("run-folder", "tuned")
    person.clicks("#plan")
    person.waits("state.parts.planned && byId('planned').textContent.includes('40 s')")
    assert not (machine_folder / "tuned" / "journal.jsonl").exists()
    assert tab.run("document.documentElement.scrollWidth <= innerWidth")

    person.clicks("#move")
    person.waits(f"{STEPS}[6]?.className === 'is-running'", 120)
    assert tab.run(f"{STEPS}[6].textContent.includes('s left')")
    assert tab.run("byId('run-plots').querySelectorAll('canvas').length") == 3
    person.clicks("#stop")
    person.waits("run?.outcome === 'restored'", 180)
    journal = Journal(machine_folder / "tuned")
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
    assert Journal(machine_folder / "tuned").last("restored")["cause"] == "undo"


def test_a_run_in_a_terminal_is_shown_live(machine_server, machine_folder, tmp_path, person_at):
    code = "import sys; from bristle.cli.main import main; sys.exit(main(sys.argv[1:]))"
    person = person_at(machine_server)
    tab = person.tab
    person.clicks('#views button[value="tune"]')
    person.clicks("#open-run")
    person.waits("state.machine")
    assert tab.run("byId('run-view').hidden")
    with subprocess.Popen(
        [sys.executable, "-c", code, "tune", "machine.toml", "--out", "tuned", "--move", "--quiet"]
    ) as process:
        person.waits(
            f"{STEPS}.some((step) => step.className === 'is-running' && step.textContent.includes('last entry'))"
        )
        person.waits("byId('run-plots').querySelector('canvas')")
        assert process.poll() is None
        person.clicks("#plan")  # the machine is in use
        person.waits("byId('plan-failed').textContent.includes('used by another run')")
        assert process.wait(240) == 0
    person.waits("run?.outcome === 'kept'")
