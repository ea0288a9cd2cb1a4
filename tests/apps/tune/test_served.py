"""A run in the lab: the plan, the stop, the state of a run from its journal, and the paths that a page may name."""

from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace as Some

import numpy as np
import pytest
from starlette.testclient import TestClient
from tests.apps.lab.server.yard import TOKEN, begun, settled
from tests.apps.tune.conftest import OPTIONS
from tests.apps.tune.machine import Faults

from bristle.apps.lab.server import tune as served
from bristle.apps.lab.server.application import application
from bristle.apps.lab.server.cases import Part
from bristle.apps.lab.server.errand import Errand
from bristle.apps.lab.server.limits import Limits
from bristle.apps.tune import tune, undo
from bristle.apps.tune.journal import NAME, Journal
from bristle.apps.tune.status import run_status
from bristle.apps.tune.tuning import _only_run
from bristle.core import InputError
from bristle.files import read_machine

INITIAL = {"guard": None, "model": None, "gain": 0.0}
PORT = 8765


def states(folder):
    return [step["state"] for step in run_status(folder, "translational")["steps"]]


def in_metres(text):
    value, unit = text.split()
    return float(value) * {"µm": 1e-6, "nm": 1e-9}[unit]


@pytest.fixture
def machine(identified, monkeypatch):
    """Connect every machine file to the bench of a run that was interrupted behind its identification."""
    make, folder = identified
    bench = make()
    monkeypatch.setattr("bristle.apps.tune.tuning.connected", lambda *_, **__: bench)
    monkeypatch.setattr("bristle.apps.tune.tuning.Options", lambda: OPTIONS)
    return bench, folder


def errand(folder, report=lambda *_: None, is_cancelled=lambda: False, out="out"):
    options = {"file": str(folder / "machine.toml"), "folder": str(folder / out)}
    return Errand(folder, (), "", "", options, 0, None, report, nullcontext, is_cancelled)


@pytest.fixture
def client(identified, tmp_path, monkeypatch):
    """A lab that was started in the folder of the machine file."""
    monkeypatch.chdir(identified[1])
    app = application(tmp_path / "lab", TOKEN, PORT, Limits())
    (tmp_path / "lab").mkdir()
    with TestClient(
        app, base_url=f"http://127.0.0.1:{PORT}", headers={"x-bristle-token": TOKEN}
    ) as client:
        client.cases = app.state.cases
        yield client


def chosen(client, file="machine.toml", folder="out"):
    case = begun(client)
    return case, client.post(f"{case}/machine", json={"file": file, "folder": folder})


@pytest.fixture
def case(client):
    """A case of the lab with the machine and its folder."""
    return chosen(client)[0]


# --- the state of a run -----------------------------------------------------------------------------------------------


def test_a_kept_run_shows_each_step_with_its_fact_and_the_change(finished):
    _, folder, result = finished
    status = run_status(folder / "out", "translational")
    assert status["outcome"] == "kept"
    assert states(folder / "out") == ["passed"] * 11
    change = result.facts["comparison"]["changes"]["following_error.rms"]
    assert [in_metres(text) for text in status["change"]] == pytest.approx(
        [change["before"], change["after"]], rel=5e-3
    )
    assert status["steps"][6]["text"].startswith("dahl")
    assert status["undo"].endswith(str(folder / "out"))
    assert any("95 % interval" in sentence for sentence in status["sentences"])
    assert status["report"]


def test_the_state_of_a_run_follows_its_journal_while_another_process_writes_it(identified):
    folder = identified[1] / "out"
    assert states(folder) == ["passed"] * 7 + ["waiting"] * 4
    with (folder / NAME).open("ab") as file:
        file.write(b'{"n": 99, "step": "stages", "ev')
    before = (folder / NAME).read_bytes()
    status = run_status(folder, "translational")
    assert (folder / NAME).read_bytes() == before  # the other process completes its line
    assert (status["outcome"], status["sentences"], status["report"]) == ("running", [], False)
    assert 0.0 <= status["age"] < 60.0
    Journal(folder).write("stages", "begun")
    assert states(folder)[7:] == ["running", "waiting", "waiting", "waiting"]


def test_a_folder_without_a_journal_has_no_run(tmp_path):
    assert run_status(tmp_path, "translational") is None


@pytest.mark.slow
def test_a_refused_step_states_its_reason_and_a_later_run_begins_again(identified):
    make, folder = identified
    file, out = folder / "machine.toml", folder / "out"
    result = tune(file, out, move=True, machine=make(Faults(ignores_effort=True)), options=OPTIONS)
    status = run_status(out, "translational")
    assert (status["outcome"], status["undo"]) == ("restored", "")
    assert states(out) == [
        "passed",
        "passed",
        "refused",
        "waiting",
        *3 * ["passed"],
        *4 * ["waiting"],
    ]
    assert status["steps"][2]["text"] == result.reason
    Journal(out).write("identity", "begun", file=str(file))
    assert states(out)[:4] == ["running", "waiting", "waiting", "waiting"]
    assert run_status(out, "translational")["outcome"] == "running"


def test_a_machine_refused_before_the_first_write_is_not_running(tmp_path):
    journal = Journal(tmp_path)
    journal.write("identity", "begun", file="machine.toml")
    journal.write("identity", "stopped", code="identity_changed", reason="the machine differs")
    status = run_status(tmp_path, "translational")
    assert (status["outcome"], status["steps"][0]["text"], status["undo"]) == (
        "restored",
        "the machine differs",
        "",
    )


def test_an_interrupted_and_restored_run_is_not_running(identified):
    make, folder = identified
    out = folder / "out"
    journal = Journal(out)
    journal.write("stages", "begun", file=str(folder / "machine.toml"))
    journal.write("stages", "write", what="set", gain=0.5)
    assert run_status(out, "translational")["undo"]
    undo(out, machine=make())
    Journal(out).write("save", "removed")  # later entries do not change the outcome
    status = run_status(out, "translational")
    assert (status["outcome"], status["undo"], status["steps"][7]["state"]) == (
        "undone",
        "",
        "refused",
    )


def test_a_machine_that_could_not_be_restored_is_named_and_can_be_undone(identified):
    out = identified[1] / "out"
    journal = Journal(out)
    journal.write("stages", "stopped", code="worse", reason="the error rises")
    journal.write(
        "stages", "restored", cause="worse", identical=False, different={"gain": [0.0, 0.5]}
    )
    status = run_status(out, "translational")
    assert status["outcome"] == "not_restored"
    assert "NOT RESTORED" in status["sentences"][0]
    assert status["undo"]


# --- the jobs ---------------------------------------------------------------------------------------------------------


def test_the_plan_moves_and_writes_nothing(machine, monkeypatch):
    bench, folder = machine
    monkeypatch.setattr(bench, "_write", lambda **_: pytest.fail("a write on the machine"))
    _, data = served.plan(errand(folder, out="new"))
    assert bench.records == []
    assert bench.state() == INITIAL
    titles = [step["title"] for step in run_status(folder / "out", "translational")["steps"]]
    assert [row[0] for row in data["table"]["rows"]] == titles
    assert len(data["seconds"]) == len(titles)
    assert min(data["seconds"]) > 0.0


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("gain", [0.5, 0.0, 1.0])
def test_a_stop_of_the_operator_restores_the_machine(machine, gain):
    bench, folder = machine
    facts, _ = served.tune(
        errand(
            folder,
            is_cancelled=lambda: bench.feedforward is not None and bench.state()["gain"] >= gain,
        )
    )
    assert facts == {"outcome": "restored", "code": "operator"}
    assert bench.state() == INITIAL
    assert bench.bench.guard.gain == 0.0
    journal = Journal(folder / "out")
    assert journal.last("restored")["identical"]
    assert max(entry.get("gain", 0.0) for entry in journal.with_events("write")) == gain
    assert "Operator: stopped in the lab" in (folder / "out" / "report.html").read_text()


def test_two_runs_on_a_machine_are_refused_wherever_they_were_started(machine, monkeypatch):
    _, folder = machine
    monkeypatch.chdir(folder)
    with (
        _only_run(read_machine("machine.toml"), folder / "out", notes=True),
        pytest.raises(InputError, match="used by another run"),
    ):
        served.plan(errand(folder))


@pytest.mark.slow
def test_a_run_from_a_terminal_can_be_undone_in_another_folder(
    identified, tmp_path_factory, monkeypatch
):
    make, folder = identified
    monkeypatch.chdir(folder)
    tune(
        "machine.toml", "out", move=True, machine=make(Faults(ignores_effort=True)), options=OPTIONS
    )
    monkeypatch.chdir(tmp_path_factory.mktemp("elsewhere"))
    assert undo(folder / "out", machine=make()).outcome == "undone"


# --- the routes -------------------------------------------------------------------------------------------------------


def test_a_journal_of_another_process_is_shown_as_it_grows(client, identified):
    out = identified[1] / "out"
    case, answer = chosen(client)
    assert answer.status_code == 200
    assert answer.json()["machine"] == {"file": "machine.toml", "folder": "out"}
    first = client.get(f"{case}/machine").json()
    assert first["run"]["steps"][7]["state"] == "waiting"
    Journal(out).write("stages", "begun")
    assert client.get(f"{case}/machine").json()["run"]["steps"][7]["state"] == "running"


def test_the_folder_alone_shows_its_run(client, identified):
    # Its journal names the machine file of another folder.
    assert chosen(client, file="")[1].status_code == 403
    Journal(identified[1] / "out").write(
        "stages", "begun", file=str(identified[1] / "machine.toml")
    )
    case, answer = chosen(client, file="")
    assert answer.status_code == 200, answer.text
    assert client.get(f"{case}/machine").json()["run"]


def test_the_latest_complete_record_of_a_motion_is_drawn(client, identified, monkeypatch):
    records = identified[1] / "out" / "records"
    (records / "excitation.csv").touch()
    (records / "test_effort.csv").touch()
    case, _ = chosen(client)
    monkeypatch.setattr(served, "COMPLETE", -1.0)
    record = client.get(f"{case}/machine").json()["record"]
    assert record["name"] == "excitation"
    motion, error, effort = client.get(f"{case}/machine/records/excitation").json()
    # Time, position, effort, reference; [um]
    table = np.loadtxt(records / "excitation.csv", delimiter=",", skiprows=1)
    assert max(error["curves"][1]) == pytest.approx(
        1e-6 * np.max(table[:, 3] - table[:, 1]), rel=1e-5
    )
    assert (motion["keys"], error["unit"], effort["unit"]) == (["measured", "reference"], "m", "N")
    monkeypatch.setattr(served, "COMPLETE", 3600.0)
    assert client.get(f"{case}/machine").json()["record"] is None
    assert client.get(f"{case}/machine/records/..%2Fjournal").status_code == 404
    assert client.get(f"{case}/machine/records/stage_7").status_code == 404


def test_the_comparison_is_drawn_without_and_with_the_feedforward(finished):
    folder = finished[1]
    axis = read_machine(folder / "machine.toml").axis
    _, error, _ = served.TunedMachine(folder / "machine.toml", folder / "out", {}, axis).record(
        "after_2"
    )
    without, fed = (np.std(curve) for curve in error["curves"][1:])
    assert error["keys"] == ["without", "with"]
    assert fed < 0.5 * without


def test_a_record_of_an_earlier_comparison_is_not_compared(client, identified):
    assert (identified[1] / "out" / "records" / "after_2.csv").exists()
    case, _ = chosen(client)
    _, error, _ = client.get(f"{case}/machine/records/before_2").json()
    assert (error["keys"], len(error["curves"])) == ([], 2)


@pytest.mark.parametrize(
    ("file", "folder", "status", "words"),
    [
        ("/etc/hostname", "out", 403, "outside the folder of this server"),
        ("machine.toml", "..", 403, "outside the folder of this server"),
        ("machine.toml", ".", 403, "outside the folder of this server"),
        ("link.toml", "out", 403, "outside the folder of this server"),
        ("gone.toml", "out", 404, "machine file: does not exist"),
        ("axis.toml", "out", 400, "machine"),
        ("machine.toml", "", 400, "folder of the run: is missing"),
        ("", "new", 400, "machine file: is missing"),
        ("machine.toml", 3, 400, "folder of the run: is missing"),
        ("machine\0.toml", "out", 400, "machine file: cannot be read"),
        ("machine.toml", 300 * "x", 400, "folder of the run: cannot be read"),
        ("loop.toml", "out", 400, "machine file: cannot be read"),
    ],
)
def test_a_wrong_path_is_refused_with_its_reason(
    client, identified, tmp_path_factory, file, folder, status, words
):
    target = tmp_path_factory.mktemp("elsewhere") / "machine.toml"
    target.write_text("schema = 1\n")
    (identified[1] / "link.toml").symlink_to(target)
    (identified[1] / "loop.toml").symlink_to(identified[1] / "loop.toml")
    case, answer = chosen(client, file, folder)
    assert (answer.status_code, words in answer.json()["message"]) == (status, True), answer.text
    assert client.get(f"{case}/machine").status_code == 404


def test_a_changed_journal_is_refused_with_its_line(client, case, identified):
    journal = identified[1] / "out" / NAME
    lines = journal.read_text().splitlines(keepends=True)
    journal.write_text("".join(lines[:1] + lines[2:]))
    answer = client.get(f"{case}/machine")
    assert (answer.status_code, "line 2: was changed" in answer.json()["message"]) == (400, True)


def test_the_axis_moves_only_after_its_plan(client, case, identified):
    opened = client.cases[case.rpartition("/")[2]]
    for paths in (None, {"file": "machine.toml", "folder": "other"}):
        answer = client.post(f"{case}/jobs", json={"task": "tune"})
        assert (answer.status_code, answer.json()["message"]) == (
            409,
            "run: needs its plan. Show the plan first",
        )
        opened.keep(
            "planned", Part(1, Path(opened.folder) / "job-1", {}, opened.inputs_of("planned"))
        )
        if paths is None:
            client.post(f"{case}/machine", json={"file": "machine.toml", "folder": "other"})
    bare = begun(client)
    assert (
        client.post(f"{bare}/jobs", json={"task": "plan"})
        .json()["message"]
        .startswith("machine file: is missing")
    )


def test_a_page_does_not_choose_the_paths_of_a_job(client, case, identified, monkeypatch):
    requests = []

    async def run(self, request):
        requests.append(request["options"])
        self.state = "failed"
        return False

    monkeypatch.setattr("bristle.apps.lab.server.cases.Job.run", run)
    client.post(
        f"{case}/jobs",
        json={"task": "plan", "options": {"file": "/etc/hostname", "folder": "/tmp"}},
    )
    settled(client, case)
    assert requests == [
        {"file": str(identified[1] / "machine.toml"), "folder": str(identified[1] / "out")}
    ]


def test_the_machine_of_a_running_job_stays(client, case, identified):
    client.cases[case.rpartition("/")[2]].job = Some(
        runs=True, restores=True, task="tune", as_data=dict, kill=lambda: None
    )
    answer = client.post(f"{case}/machine", json={"file": "machine.toml", "folder": "other"})
    assert (answer.status_code, "in use by the running job" in answer.json()["message"]) == (
        409,
        True,
    )


def test_the_report_of_a_run_is_shown_once(client, case, identified):
    (identified[1] / "out" / "report.html").write_text("<p>tuned</p>")
    address = client.post(f"{case}/machine/ticket").json()["address"]
    assert client.get(address).text == "<p>tuned</p>"
    assert client.get(address).status_code == 404
