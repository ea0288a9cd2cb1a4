"""What is kept of a run is what ``simulate`` returns of it; which runs are made many at once; progress is told in words."""

import sys
from types import SimpleNamespace as Some
from unittest.mock import Mock

import numpy as np
import pytest
from tests.apps.study.conftest import STUDY, content, same

import bristle as br
from bristle.apps.study import block as blocks, run, run_study
from bristle.apps.study.block import FAILED, Simulator, Varied, _overridden, fits_a_batch, row_of
from bristle.apps.study.command import exit_code
from bristle.apps.study.plan import METRICS, Block
from bristle.apps.study.run import Ran, in_words, repeat_run, run_within, values_of, worst_runs
from bristle.apps.study.store import Runs
from bristle.apps.study.workers import Cluster, Here, OwnCluster
from bristle.core import MissingExtraError
from bristle.engine.batch import _Batch
from bristle.files.summary import as_json
from bristle.report.simulation import simulation_summary

EVERY = STUDY[: STUDY.index("metrics")] + f"metrics = {list(METRICS)!r}\n".replace("'", '"')
LOOPS = """
schema = 1
experiment = "loop.toml"
runs = 3
seed = 1
[vary]
"controller.k_p" = { uniform = ["60 1/s", "100 1/s"] }
"friction.F_C" = { uniform = ["6 N", "10 N"] }
"plant.M" = { uniform = ["19 kg", "21 kg"] }
[grid]
"reference.frequency" = ["1 Hz", "2 Hz"]
"""


def test_runs_in_a_batch_have_the_bits_of_runs_one_by_one(bench):
    study = bench.study(EVERY)
    batch, serial = Simulator(study), Simulator(study, batches=False)
    assert batch.in_batches
    assert not serial.in_batches
    block = Block(1, 9)
    first, second = batch.columns(block), serial.columns(block)
    assert same(first, second)
    assert len(set(first["motion.std"])) == 8
    assert np.all(np.isnan(first["following_error.rms"]))


@pytest.mark.slow
def test_runs_in_lanes_have_the_bits_of_runs_one_by_one(bench, monkeypatch):
    monkeypatch.setattr("bristle.apps.study.block.WORTH_LANES", 0)
    bench.rig(substeps=1)
    study = bench.study(EVERY, runs=("runs = 12", "runs = 64"), block=("block = 4", "block = 40"))
    in_lanes = []
    monkeypatch.setattr(
        "bristle.engine.batch._Batch.in_lanes",
        lambda *a, of=_Batch.in_lanes: in_lanes.append(a) or of(*a),
    )
    block = Block(1, 41)
    assert same(Simulator(study).columns(block), Simulator(study, batches=False).columns(block))
    assert len(in_lanes) == 1


@pytest.mark.slow
@pytest.mark.parametrize(("text", "blocks"), [(EVERY, 3), (LOOPS, 6)])  # in batches, and one by one
def test_any_number_of_processes_and_of_threads_writes_the_same_bytes(
    bench, monkeypatch, text, blocks
):
    study = bench.study(text)
    for name, count in (("alone", 1), ("two", 2), ("four", 4)):
        run_study(study, bench.folder / name, workers=count)
    monkeypatch.setattr(
        "bristle.apps.study.run.OwnCluster",
        Mock(side_effect=MissingExtraError("without the extra")),
    )
    with pytest.warns(br.core.InputWarning, match="threads of one process do the work"):
        run_study(study, bench.folder / "threads", workers=3)
    run_study(study, bench.folder / "as many as cores")
    for name in ("threads", "as many as cores"):
        assert (
            content(bench.folder / name)
            == content(bench.folder / "two")
            == content(bench.folder / "four")
        )
    assert content(bench.folder / "four") == content(bench.folder / "alone")
    assert len(content(bench.folder / "alone")) == len(study.blocks) == blocks


@pytest.mark.parametrize(("model", "drawn"), [("lugre", "0.2 N"), ("elastoplastic", "0.8 N")])
def test_only_draws_out_of_range_leave_the_batch(bench, model, drawn):
    rig = (bench.folder / "rig.toml").read_text()
    if model == "elastoplastic":  # whose sigma_0 z_ba must be below F_C
        rig = rig.replace('model = "lugre"', 'model = "elastoplastic"\nz_ba = "8 um"')
    (bench.folder / "rig.toml").write_text(rig)
    study = bench.study(normal=('["1 N", "0.1 N"]', f'["{drawn}", "0.2 N"]'))  # F_C may be negative
    block = Block(0, 12)
    values, varied = study.values(block), Varied(study)
    models = varied.models_by_place(values, study.seeds(block), ("plant", "friction"))
    refused = set()
    for place in range(12):
        try:
            alone = varied.models(
                row_of(values, place), study.seeds(block)[place], ("plant", "friction")
            )
        except br.core.InputError:
            refused.add(place)
        else:
            assert models[place] == alone
    assert refused
    assert set(models) == set(range(12)) - refused


def test_values_set_in_models_make_the_experiment_that_the_file_would(bench):
    study = bench.study(LOOPS)
    direct, by_tables = Varied(study), Varied(study)
    by_tables._direct = None
    assert direct.is_direct
    for number in range(study.count):
        block = Block(number, number + 1)
        values, seed = row_of(study.values(block), 0), study.seeds(block)[0]
        first, second = (br.simulate(way.experiment(values, seed)) for way in (direct, by_tables))
        for name in ("plain", "stiff"):
            assert (
                first.variants[name].measured.tobytes() == second.variants[name].measured.tobytes()
            )


def test_a_variant_keeps_its_overridden_value(bench):
    study = bench.study(LOOPS)
    values = row_of(study.values(Block(0, 1)), 0)
    plain, stiff = Varied(study).experiment(values, 1).variants
    assert plain.controller.values["k_p"] == values["controller.k_p"]
    assert stiff.controller.values["k_p"] == 120.0
    assert stiff.friction.values["F_C"] == values["friction.F_C"]


def test_values_that_reach_further_than_one_model_go_through_the_tables(bench):
    study = bench.study(
        LOOPS.replace('"reference.frequency" = ["1 Hz", "2 Hz"]', '"run.delay" = [0, 1]')
    )
    varied = Varied(study)
    assert not varied.is_direct
    experiment = varied.experiment(row_of(study.values(Block(1, 2)), 0), 1)
    assert [variant.run.delay for variant in experiment.variants] == [1, 1]
    assert [variant.run.seeds for variant in experiment.variants] == [1, 1]


def test_gravity_that_is_fed_forward_is_that_of_the_plant_of_the_run(bench):
    loop = (bench.folder / "loop.toml").read_text()
    loop = loop.replace(
        '[plant]\nM = "20 kg"', '[plant]\nmodel = "inertia+gravity"\nM = "20 kg"\ng_sin = "100 N"'
    )
    loop = loop.replace("[sensor]", '[controller.feedforward]\nplant = "own"\n[sensor]')
    (bench.folder / "loop.toml").write_text(loop)
    varied = Varied(bench.study(LOOPS))
    values = row_of(varied.study.values(Block(0, 1)), 0)
    assert not varied.is_direct
    assert (
        varied.experiment(values, 1).variants[0].feedforward.plant.values["M"] == values["plant.M"]
    )


def test_the_seed_of_a_run_is_added_to_those_of_the_file(bench):
    study = bench.study(LOOPS)
    values = row_of(study.values(Block(0, 1)), 0)
    first, second = (
        Varied(study).experiment(values, seed).variants[0].sensor.values["seed"] for seed in (0, 40)
    )
    assert (first, second) == (5, 45)


def test_a_run_repeated_has_the_numbers_that_were_kept(bench):
    study = bench.study(LOOPS)
    kept = Simulator(study).columns(Block(0, study.count))
    result = repeat_run(study, 4)
    assert kept["stiff.effort.rms"][4] == result.variants["stiff"].effort_rms
    assert kept["controller.k_p"][4] == values_of(study, 4)["controller.k_p"]
    with pytest.raises(br.core.InputError, match="0 to 5"):
        repeat_run(study, 6)


def test_a_diverged_loop_has_no_numbers(bench):
    loop = (
        (bench.folder / "loop.toml")
        .read_text()
        .replace('limit = "300 N"\n', "")
        .replace('"0.2 s"', '"2 s"')
    )
    (bench.folder / "loop.toml").write_text(loop)
    fast = LOOPS.replace('["60 1/s", "100 1/s"]', '["6e5 1/s", "7e5 1/s"]')
    study = bench.study(fast.replace("[grid]", '[grid]\n"run.delay" = [20]'))
    columns = Simulator(study).columns(Block(0, 1))
    assert columns["status"] == ["not_finite"]
    assert np.isnan(columns["plain.effort.rms"][0])
    assert "plain" in columns["reason"][0]


def test_every_metric_is_a_number_of_bristle_run(bench):
    result = br.simulate(bench.folder / "loop.toml")
    variant = simulation_summary(result, files={}, provenance={})["variants"]["plain"]
    assert as_json(variant)
    for name in METRICS:
        entry = variant
        for key in name.split("."):
            entry = entry[key]
        assert isinstance(entry, float)


# --- blocks ----------------------------------------------------------------------------------------------------------


def test_a_run_is_made_with_plain_numbers():
    values = {"a": np.array([1.0, 2.0]), "b": np.array(["x", "y"]), "c": np.array([[1, 2], [3, 4]])}
    row = row_of(values, 1)
    assert row == {"a": 2.0, "b": "y", "c": [3, 4]}
    assert [type(row["a"]), type(row["b"]), type(row["c"][0])] == [float, str, int]


@pytest.mark.parametrize(
    ("override", "keys", "own"),
    [
        ({}, ("friction", "F_C"), False),
        ({"friction": {"F_C": 1.0}}, ("friction", "F_C"), True),
        ({"friction": {"F_v": 1.0}}, ("friction", "F_C"), False),
        ({"friction": {"model": "dahl"}}, ("friction", "F_C"), True),
        ({"friction": {"file": "a.toml"}}, ("friction", "F_C"), True),
        ({"friction": "none"}, ("friction", "F_C"), False),
        ({"friction": {"model": "dahl"}}, ("plant", "M"), False),
    ],
)
def test_a_variant_keeps_values_under_keys_of_the_variant(override, keys, own):
    assert _overridden(override, keys) is own


def test_runs_that_failed_have_no_numbers():
    assert FAILED == ("not_finite", "refused", "raised")


def loop_of(**changes):
    run = Some(tolerance=0.0, delay=0, current_lag=0.0)
    known = {
        "run": run,
        "friction": br.friction.lugre(F_C=1.0, F_S=1.5, v_S=1e-3, sigma_0=1e5),
        "effort": 1,
        "disturbance": None,
        "start": None,
    }
    known |= {"plant": Some(component=Some(screw=None))}
    return Some(**known | changes)


@pytest.mark.parametrize(
    ("changes", "fits"),
    [
        ({}, True),
        ({"effort": None}, False),
        ({"plant": Some(component=Some(screw=1))}, False),
        ({"disturbance": 1}, False),
        ({"start": 1}, False),
        ({"run": Some(tolerance=1e-9, delay=0, current_lag=0.0)}, False),
        ({"run": Some(tolerance=0.0, delay=1, current_lag=0.0)}, False),
        ({"run": Some(tolerance=0.0, delay=0, current_lag=1e-3)}, False),
        ({"friction": br.friction.maxwell_slip(F_C=1.0, k_i=[1e5, 2e5], nu_i=[0.4, 0.6])}, False),
    ],
)
def test_runs_in_a_batch_have_a_single_mass_under_a_given_effort(changes, fits):
    assert fits_a_batch(Some(variants=[loop_of(**changes)])) is fits
    assert fits_a_batch(Some(variants=[loop_of(), loop_of(**changes)])) is fits


def test_a_block_has_a_row_for_each_of_the_runs(bench):
    columns = Simulator(bench.study()).columns(Block(4, 7))
    assert columns["run"].tolist() == [4, 5, 6]
    assert list(columns["seed"]) == bench.study().seeds(Block(4, 7))
    assert columns["status"] == ["ok"] * 3
    assert columns["reason"] == [""] * 3
    assert {len(column) for column in columns.values()} == {3}


def test_a_list_that_was_drawn_is_a_column_for_each_element(bench, monkeypatch):
    simulator = Simulator(bench.study())
    drawn = {"friction.K": np.arange(4.0).reshape(2, 2)}
    study = Some(values=lambda block: drawn, seeds=lambda block: [0, 0], metrics=())
    simulator.study, simulator.in_batches = study, False
    monkeypatch.setattr(simulator, "_serial", lambda *a: ("refused", "why"))
    columns = simulator.columns(Block(0, 2))
    assert columns["friction.K[0]"].tolist() == [0.0, 2.0]
    assert columns["friction.K[1]"].tolist() == [1.0, 3.0]
    assert "friction.K" not in columns
    assert (columns["status"], columns["reason"]) == (["refused"] * 2, ["why"] * 2)


@pytest.mark.parametrize(
    ("error", "status", "reason"),
    [
        (br.core.InputError("is wrong"), "refused", "is wrong"),
        (ValueError("x" * 400), "raised", "ValueError: xxx"),
    ],
)
def test_a_run_that_fails_is_reported_with_the_reason_in_short(
    bench, monkeypatch, error, status, reason
):
    simulator = Simulator(bench.study(), batches=False)

    def fails(experiment):
        raise error

    monkeypatch.setattr(blocks, "simulate", fails)
    columns = simulator.columns(Block(0, 1))
    assert columns["status"] == [status]
    assert reason in columns["reason"][0]
    assert len(columns["reason"][0]) <= 300
    assert np.isnan(columns["effort.rms"][0])


def test_no_memory_is_no_reason_of_a_run(bench, monkeypatch):
    simulator = Simulator(bench.study(), batches=False)

    def fails(experiment):
        raise MemoryError

    monkeypatch.setattr(blocks, "simulate", fails)
    with pytest.raises(MemoryError):
        simulator.columns(Block(0, 1))


def test_the_worst_variant_sets_the_status_of_a_run(bench, monkeypatch):
    study = bench.study(LOOPS)
    simulator, ends = (
        Simulator(study),
        {"plain": br.core.Status.OK, "stiff": br.core.Status.TOLERANCE_MISSED},
    )
    result = Some(variants={name: Some(name=name, status=status) for name, status in ends.items()})
    monkeypatch.setattr(blocks, "simulate", lambda experiment: result)
    simulator.study = Some(metrics=())
    row = row_of(study.values(Block(0, 1)), 0)
    assert simulator._serial(0, row, 1, {}) == (
        "tolerance_missed",
        f"stiff: {br.core.Status.TOLERANCE_MISSED.sentence}",
    )
    del result.variants["plain"]
    assert simulator._serial(0, row, 1, {}) == (
        "tolerance_missed",
        br.core.Status.TOLERANCE_MISSED.sentence,
    )
    result.variants["stiff"].status = br.core.Status.OK
    assert simulator._serial(0, row, 1, {}) == ("ok", "")


def test_a_fed_forward_model_and_another_variant_are_placed_apart(bench):
    (sections,) = blocks._placed(bench.study())
    assert sections == {"friction": {"friction.F_C": "F_C"}, "plant": {"plant.M": "M"}}
    plain, stiff = blocks._placed(
        bench.study(LOOPS.replace('"friction.F_C"', '"compare.stiff.friction.F_C"'))
    )
    assert "friction" not in plain
    assert stiff["friction"] == {"compare.stiff.friction.F_C": "F_C"}
    assert "controller" not in stiff  # whose gain is its own


@pytest.mark.parametrize(("number", "is_direct"), [(0, False), (5, True), (11, False)])
def test_the_first_and_the_last_run_decide_whether_values_are_set_directly(
    bench, monkeypatch, number, is_direct
):
    study = bench.study()
    changed = row_of(study.values(Block(number, number + 1)), 0)
    models = Varied.models

    def heavier(self, values, *further):
        return models(
            self,
            values | {"plant.M": 2.0 * values["plant.M"]} if values == changed else values,
            *further,
        )

    monkeypatch.setattr(Varied, "models", heavier)
    assert Varied(study).is_direct is is_direct


# --- what is missing is simulated, here or in other processes --------------------------------------------------------


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (0.0, "1 s"),
        (1.6, "2 s"),
        (89.0, "89 s"),
        (90.0, "2 min"),
        (5399.0, "90 min"),
        (5400.0, "1.5 h"),
        (36_000.0, "10.0 h"),
    ],
)
def test_a_time_is_reported_in_words(seconds, words):
    assert in_words(seconds) == words


class Kept:
    """A folder of which the first block is there."""

    def __init__(self, present=(0,)):
        self.present, self.written = set(present), []
        blocks = tuple(Block(4 * k, 4 * k + 4) for k in range(4))
        self.study = Some(blocks=blocks, count=16)

    def blocks_present(self):
        return self.present

    def write(self, block, columns):
        self.written.append((block.first, columns))


def test_progress_counts_present_runs_and_the_remaining_time(monkeypatch):
    now = iter([0.0, 10.0, 40.0, 100.0])
    monkeypatch.setattr(run, "time", Some(monotonic=lambda: next(now)))
    reported, kept = [], Kept()
    ran = run_within(
        kept,
        workers=1,
        progress=lambda share, words: reported.append((share, words)),
        simulator=lambda study: Some(columns=lambda block: block.count),
    )
    assert ran == Ran(1, ())
    assert kept.written == [(4, 4), (8, 4), (12, 4)]
    # Thirty seconds for the second block leave as much for the last one.
    assert reported == [
        (0.25, "4 of 16 runs"),
        (0.5, "8 of 16 runs"),
        (0.75, "12 of 16 runs, 30 s left"),
        (1.0, "16 of 16 runs, 1 s left"),
    ]


def test_a_complete_study_starts_no_worker(monkeypatch):
    kept = Kept((0, 4, 8, 12))
    monkeypatch.setattr(run, "Simulator", None)
    assert run_within(kept) == Ran(4, ())
    assert kept.written == []


def simulator(in_batches):
    return lambda study: Some(in_batches=in_batches, columns=len)


@pytest.mark.parametrize(
    ("missing", "workers", "in_batches", "kind", "count"),
    [
        (3, 1, True, Here, 1),
        (3, 2, True, OwnCluster, 2),
        (3, 8, True, OwnCluster, 3),
        (3, None, True, Here, 6),
        (3, None, False, OwnCluster, 3),
        (1, None, False, Here, 1),
    ],
)
def test_the_crew_follows_the_missing_blocks(
    missing, workers, in_batches, kind, count, monkeypatch
):
    monkeypatch.setattr(run, "Simulator", simulator(in_batches))
    monkeypatch.setattr(run, "core_count", lambda: 6)
    crew = run._crew(None, missing, workers, None, run.Simulator)
    assert (type(crew), crew.workers) == (kind, count)


@pytest.mark.parametrize(("lost", "code"), [((), 0), ((Block(4, 8),), 1)])
def test_runs_whose_processes_crashed_are_named(capsys, lost, code):
    assert exit_code(Ran(0, lost), {"statuses": {"ok": 8}}) == code
    assert (
        "runs 4 to 7 are missing: every process that simulated them crashed"
        in capsys.readouterr().err
    ) is bool(lost)


@pytest.mark.parametrize("library", ["distributed", "cryptography"])
def test_without_a_library_of_the_extra_threads_do_the_work(library, monkeypatch):
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.warns(
        br.core.InputWarning,
        match=r"^--workers needs .* Until then, threads of one process do the work",
    ):
        crew = run._crew(None, 3, 2, None, simulator(False))
    assert (type(crew), crew.workers, crew.simulate) == (Here, 2, len)
    monkeypatch.setattr(run, "core_count", lambda: 6)
    assert run._crew(None, 3, None, None, simulator(False)).workers == 3  # nobody asked: no warning


def test_workers_and_a_scheduler_are_not_asked_for_together(monkeypatch):
    pytest.importorskip("distributed")
    with pytest.raises(
        br.core.InputError, match=r"workers: cannot be chosen together with a scheduler"
    ):
        run_within(Kept(()), workers=2, scheduler="tcp://a:1")
    assert isinstance(run._crew(None, 3, None, "tcp://a:1", None), Cluster)


def test_of_equally_bad_runs_the_earlier_comes_first():
    columns = {"run": np.arange(10, 16), "m": np.array([1.0, 3.0, np.nan, 3.0, 9.0, 2.0])}
    columns["status"] = np.array(["ok", "ok", "ok", "tolerance_missed", "refused", "ok"])
    assert worst_runs(Runs({"metrics": ["m", "n"]}, columns), 3) == [11, 13, 15]
    assert worst_runs(Runs({"metrics": ["m"]}, columns), 9) == [11, 13, 15, 10]
