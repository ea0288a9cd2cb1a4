"""A run on an axis that is simulated without bristle: kept if better, restored in every other case."""

from dataclasses import replace

import numpy as np
import pytest
from tests.apps.tune.bench import Bench, Motion, drawn
from tests.apps.tune.conftest import OPTIONS, SEED, begun, killed
from tests.apps.tune.machine import BenchMachine, Faults, written

from bristle.apps.tune import MachineRefusedError, tune, undo
from bristle.apps.tune.journal import NAME, Journal
from bristle.core import InputError


def rms(motion: Motion, feed, *, gain: float, truth: bool = False) -> float:
    """Return the rms of the true error of the axis with a feedforward [m]."""
    bench = Bench(drawn(SEED)[0], SEED)
    bench.guard.gain = gain
    played = motion.played(8)
    rows, _, why = bench.play(played, feed(played), feed_is_truth=truth)
    assert why == 0
    return float(np.std((played - rows[:, 2])[200 + 2 * motion.cycle.size : -200]))


def test_the_feedforward_stays_and_gives_most_of_the_reduction_that_the_true_friction_gives(
    finished,
):
    machine, _, result = finished
    assert result.outcome == "kept", result.reason
    assert machine.kept
    motion, plant = drawn(SEED)[1], machine.bench.plant
    without = rms(motion, np.zeros_like, gain=0.0)
    fed = rms(
        motion,
        lambda played: machine.feedforward.along(played, plant.sample_time),
        gain=result.facts["comparison"]["gain"],
    )
    true = rms(motion, np.zeros_like, gain=1.0, truth=True)
    assert (without - fed) / (without - true) > 0.85


def test_the_claimed_change_is_that_of_the_records(finished):
    _, folder, result = finished
    change = result.facts["comparison"]["changes"]["following_error.rms"]
    low, high = change["interval_percent"]
    assert low < change["change_percent"] < high < 0.0
    sides = {}
    for side in ("before", "after"):
        tables = [
            np.loadtxt(file, delimiter=",", skiprows=1)
            for file in (folder / "out/records").glob(f"{side}_?.csv")
        ]
        assert len(tables) == 4
        # columns: time, position, effort, reference
        sides[side] = np.sqrt(
            np.mean([np.mean((table[:, 3] - table[:, 1]) ** 2) for table in tables])
        )
    assert 100.0 * (sides["after"] / sides["before"] - 1.0) == pytest.approx(
        change["change_percent"], abs=0.5
    )


def test_the_excitation_and_the_motion_are_repeated_with_the_feedforward(finished):
    """The second model is that of a record in which the axis follows its reference better."""
    _, folder, result = finished
    records = folder / "out/records"
    first, again = (
        np.loadtxt(records / f"{name}.csv", delimiter=",", skiprows=1)
        for name in ("excitation", "refinement")
    )
    motion = np.loadtxt(records / "stage_0.csv", delimiter=",", skiprows=1)
    assert again[:, 3].tolist() == [*first[:, 3], *motion[:, 3]]
    without, fed = (
        np.std(table[: len(first), 3] - table[: len(first), 1]) for table in (first, again)
    )
    assert fed < 0.2 * without
    assert result.facts["refinement"]["gain"] > 0.0


def test_a_report_names_the_change_and_how_to_undo_it(finished):
    page = (finished[1] / "out/report.html").read_text()
    assert "bristle tune --undo" in page
    assert "Kept" in page
    assert "Values written" in page


def test_every_write_is_on_the_allow_list_and_in_the_journal(finished):
    entries = Journal(finished[1] / "out").entries
    assert {entry["what"] for entry in entries if entry["event"] == "write"} == {
        "arm",
        "set",
        "load",
    }
    gains = [
        entry["gain"] for entry in entries if entry["event"] == "write" and entry["what"] == "set"
    ]
    assert max(gains) <= 1.0


def test_progress_rises_by_planned_time_to_the_end(finished):
    shares = finished[0].shares
    assert shares == sorted(shares)
    assert 0.9 < shares[-1] <= 1.0


def test_undo_restores_the_machine(finished, tmp_path):
    make, folder = _copied(finished, tmp_path)
    machine = make()
    assert undo(folder / "out", machine=machine).outcome == "undone"
    assert machine.state() == {"guard": None, "model": None, "gain": 0.0}


def _copied(finished, tmp_path):
    make, folder = begun(finished[1], tmp_path)
    (folder / "memory.json").write_text((finished[1] / "memory.json").read_text())
    return make, folder


REFUSALS = {
    "drive ignores the effort": ("no_effect", Faults(ignores_effort=True)),
    "guard that never trips": ("guard_fails", Faults(guard_fails=True)),
    "lost samples": ("lost_samples", Faults(lost={"6": 3})),
    "stopped by the operator": ("operator", Faults(stops_at=4)),
    "feedforward of wrong sign": ("worse", Faults(feed_sign=-1.0)),
    "reversed effort": ("worse", Faults(sign=-1.0, feed_sign=-1.0)),
    "encoder fails in a motion": ("worse", Faults(encoder_fails_at=4)),
}


@pytest.mark.fast_cases(5)
@pytest.mark.parametrize("fault", REFUSALS)
def test_a_faulty_machine_is_refused_by_name_and_restored(identified, fault):
    code, faults = REFUSALS[fault]
    make, folder = identified
    machine = make(faults)
    result = tune(
        folder / "machine.toml", folder / "out", move=True, machine=machine, options=OPTIONS
    )
    assert (result.outcome, result.code, result.restored) == ("restored", code, True), result.reason
    assert machine.state() == {"guard": None, "model": None, "gain": 0.0}
    page = (folder / "out/report.html").read_text()
    assert result.reason[1:] in page
    assert code != "lost_samples" or result.reason.startswith("lost samples: 3 of ")
    assert "bristle tune machine.toml --out out --move" in page
    assert "--undo" not in page
    assert ("Mend the cause" in page) == (code != "operator")


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("place", [0.5, 0.2, 0.8])
def test_a_killed_run_is_restored_at_the_next_start(identified, place):
    make, folder = identified
    before = len(Journal(folder / "out").entries)
    entry = before + int(place * 20)
    assert killed(
        entry,
        lambda: tune(
            folder / "machine.toml", folder / "out", move=True, machine=make(), options=OPTIONS
        ),
    )
    machine = make()
    changed = machine.state()
    plan = tune(folder / "machine.toml", folder / "out", machine=machine, options=OPTIONS)
    assert machine.state() == changed  # without --move nothing is written
    was_written = Journal(folder / "out").has_written
    assert [
        remark.endswith(f"bristle tune --undo {folder / 'out'}") for remark in plan.remarks
    ] == [True] * was_written
    machine = make(Faults(stops_at=0))
    tune(folder / "machine.toml", folder / "out", move=True, machine=machine, options=OPTIONS)
    assert machine.state() == {"guard": None, "model": None, "gain": 0.0}
    last, *earlier = Journal(folder / "out").with_events("restored")
    assert last["identical"]
    assert not was_written or (earlier[0]["cause"], earlier[0]["identical"]) == (
        "a run that was interrupted",
        True,
    )


def test_without_move_nothing_moves_and_nothing_is_written(tmp_path):
    file, bench, _ = written(tmp_path, SEED)
    machine = BenchMachine(bench)
    result = tune(file, tmp_path / "out", machine=machine)
    assert (result.outcome, machine.records) == ("planned", [])
    assert machine.state() == {"guard": None, "model": None, "gain": 0.0}
    assert [name for name, facts in result.facts.items() if facts.get("seconds")] == [
        "check", "warm_up", "before", "excitation", "stages", "refinement", "comparison",
    ]  # fmt: skip


def test_the_plan_states_the_motion_of_the_comparison(finished, tmp_path):
    machine, _, _ = finished
    file, bench, _ = written(tmp_path, SEED, 6)
    planned = tune(file, tmp_path / "out", machine=BenchMachine(bench)).facts["comparison"][
        "seconds"
    ]
    *_, records = np.split(np.array(machine.records, int), [-8])
    # each of the eight records has a rest of a second before and behind its motion
    assert planned == pytest.approx(np.sum(records) * machine.sample_time - 8 * 2.0, abs=0.1)


def test_a_model_is_known_before_anything_moves(tmp_path):
    machine = BenchMachine(Bench(drawn(SEED)[0], SEED))
    file, _, _ = written(tmp_path, SEED)
    assert (
        tune(
            file, tmp_path / "out", machine=machine, options=replace(OPTIONS, models="all")
        ).outcome
        == "planned"
    )
    with pytest.raises(InputError, match="no such friction model; found 'typo'"):
        tune(
            file,
            tmp_path / "out",
            move=True,
            machine=machine,
            options=replace(OPTIONS, models="dahl,typo"),
        )
    assert (machine.records, (tmp_path / "out").exists()) == ([], False)


def test_a_folder_with_other_files_is_refused(tmp_path):
    file, bench, _ = written(tmp_path, SEED)
    with pytest.raises(InputError, match="not of a run of tune"):
        tune(file, tmp_path, machine=BenchMachine(bench))


def test_a_changed_machine_is_refused(identified):
    make, folder = identified
    machine = make()
    machine.bench.seed = 99
    result = tune(
        folder / "machine.toml", folder / "out", move=True, machine=machine, options=OPTIONS
    )
    assert result.code == "identity_changed"


def test_a_finished_run_is_undone_before_the_next_one(finished, tmp_path):
    make, folder = _copied(finished, tmp_path)
    journal = (finished[1] / "out" / NAME).read_text()
    (folder / "out" / NAME).write_text(journal)
    before = make().state()
    with pytest.raises(InputError, match=r"finished run.*--undo"):
        tune(folder / "machine.toml", folder / "out", move=True, machine=make(), options=OPTIONS)
    with pytest.raises(InputError, match="keeps the feedforward of a run in another folder"):
        tune(folder / "machine.toml", folder / "other", move=True, machine=make(), options=OPTIONS)
    assert make().state() == before


def test_a_run_does_not_go_on_with_other_options(identified):
    make, folder = identified
    machine = make()
    with pytest.raises(InputError, match=r"models: differs .* found 'lugre', allowed dahl"):
        tune(
            folder / "machine.toml",
            folder / "out",
            move=True,
            machine=machine,
            options=replace(OPTIONS, models="lugre"),
        )
    assert machine.records == []


def test_a_run_does_not_go_on_if_the_machine_cannot_be_restored(identified):
    class Stuck(BenchMachine):
        def restore(self, state):
            self._write(gain=0.5)

    make, folder = identified
    machine = Stuck(make().bench, memory=folder / "memory.json")
    with pytest.raises(MachineRefusedError, match="differs from its backup"):
        tune(folder / "machine.toml", folder / "out", move=True, machine=machine, options=OPTIONS)
    assert machine.records == []
    assert Journal(folder / "out").last("restored")["different"] == {"gain": [0.0, 0.5]}
