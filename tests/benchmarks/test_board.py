"""The score board: splits, leakage, faulty competitors, scores with known answers, and resumed runs."""

import pickle
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from benchmarks.board import simulated
from benchmarks.board.board import board, failures, page, ranks
from benchmarks.board.child import SLOW, Fault, Orders, answered, answers
from benchmarks.board.competitors import adaptive_hysteresis, bristle_all, stops
from benchmarks.board.loop import following_error
from benchmarks.board.record import Data, Record, log_of
from benchmarks.board.run import Bench, competitors_named
from benchmarks.board.scores import OK, reversals_of, scored
from benchmarks.board.task import SCORES, TASKS, tasks_named

from bristle import controllers, friction, hysteresis, plants
from bristle.apps.arm import identify
from bristle.core import Axis, Experiment, InputError, content_of
from bristle.engine import response
from bristle.files import axes_in, growing_folder
from bristle.logs import Log
from bristle.prediction import effort_of_motion
from bristle.simulation import compensation_experiment, simulate

AXIS = Axis(kind="translational", cutoff=40.0)
TIME = 1e-3 * np.arange(4000)


def record(frequency, secret=0.0):
    """A mass of 3 kg with 5 N of dry and 20 N*s/m of viscous friction."""
    position = 0.02 * np.sin(2.0 * np.pi * frequency * TIME)
    moved = Record.of(TIME, position, None, AXIS)
    effort = (
        3.0 * moved.acceleration + 5.0 * np.sign(moved.velocity) + 20.0 * moved.velocity + secret
    )
    return Record.of(TIME, position, effort, AXIS)


@pytest.fixture
def data():
    return Data([record(1.0)], [record(1.3)], truth={"M": 3.0, "F_C": 5.0})


def competitor(tmp_path, text, name="own"):
    file = tmp_path / f"{name}.py"
    file.write_text(text)
    return str(file)


def replies(tmp_path, text, data, names=("predict",)):
    return dict(answered(Orders.of(content_of(competitor(tmp_path, text)), names, data)))


def test_a_record_becomes_a_log_with_or_without_its_effort():
    recorded = record(1.0)
    assert (len(log_of(recorded)), log_of(recorded.motion).effort) == (4000, None)


LEAST = "import numpy as np\ndef fit(train): return None\ndef predict(fitted, motion): return {}\n"


def test_a_competitor_receives_no_effort_of_a_test(tmp_path):
    secret = 123456.789
    data = Data([record(1.0)], [record(1.3, secret)], record(1.3).motion, np.full(4000, secret))
    sent = pickle.dumps(
        Orders.of(content_of(competitor(tmp_path, LEAST)), ("predict", "loop"), data)
    )
    assert data.test[0].effort.tobytes() not in sent
    assert data.followed.tobytes() not in sent
    assert data.train[0].effort.tobytes() in sent


def test_a_competitor_finds_the_board_and_does_not_learn_the_folder_of_the_logs(
    tmp_path, monkeypatch, data
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("BRISTLE_DATA", str(tmp_path))
    text = "import os\nfrom benchmarks.board import log_of\ndef fit(train): return None\n"
    text += (
        "def predict(fitted, motion): raise ValueError(os.environ.get('BRISTLE_DATA', 'absent'))"
    )
    orders = Orders.of(content_of(competitor(tmp_path, text)), ("predict",), data)
    assert answers(orders, 60.0)["predict"].reason == "line 4: ValueError: absent"


@pytest.mark.parametrize(
    ("result", "status"),
    [
        ("1 / 0", "raised"),
        ("np.full(motion.time.size, np.nan)", "not finite"),
        ("np.zeros(3)", "wrong shape"),
        ("'force'", "raised"),
    ],
)
def test_a_faulty_answer_becomes_a_status(tmp_path, data, result, status):
    fault = replies(tmp_path, LEAST.format(result), data)["predict"]
    assert (fault.status, bool(fault.reason)) == (status, True)


def test_a_fault_names_the_line_in_which_it_arises(tmp_path, data):
    text = "def fit(train): return 2\ndef predict(fitted, motion):\n    return scaled(fitted)\ndef scaled(value):\n    return value['mass']"
    assert replies(tmp_path, text, data)["predict"].reason.startswith("line 5: TypeError")


def test_a_failed_fit_is_the_answer_to_all(tmp_path, data):
    assert (
        replies(tmp_path, "def fit(train): raise RuntimeError('no')", data)["fit"].reason
        == "line 1: RuntimeError: no"
    )


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    ("body", "status"), [("import os; os._exit(3)", "crashed"), ("while True: pass", "too slow")]
)
def test_a_slow_or_crashing_process_becomes_a_status(tmp_path, data, body, status):
    text = f"def fit(train): return None\ndef parameters(fitted): return {{'M': 3.0}}\ndef predict(fitted, motion):\n    {body}"
    found = answers(
        Orders.of(content_of(competitor(tmp_path, text)), ("parameters", "predict"), data), 0.5
    )
    assert found["parameters"] == {"M": 3.0}  # the answers before it are kept
    assert found["predict"].status == status


def test_a_perfect_prediction_has_no_error_and_a_missing_force_all(data):
    (test,) = data.test
    assert scored(["force"], {"predict": [test.effort]}, data, 1)["force"].value == 0.0
    half = scored(["force", "reversals"], {"predict": [0.5 * test.effort]}, data, 1)
    assert half["force"].value == pytest.approx(50.0)
    assert half["force"].lower <= 50.0 + 1e-9
    assert half["force"].upper >= 50.0 - 1e-9
    assert half["reversals"].value > 0.0


def test_an_error_at_reversals_alone_weighs_more_there(data):
    (test,) = data.test
    bent = test.effort.copy()
    for sample in reversals_of(test):
        bent[max(sample - 50, 0) : sample + 50] += 2.0
    result = scored(["force", "reversals"], {"predict": [bent]}, data, 1)
    assert result["reversals"].value > 1.2 * result["force"].value
    assert len(reversals_of(test)) == 10  # 4 s of 1.3 Hz


def test_a_missing_parameter_counts_as_wrong(data):
    values = [
        scored(["parameters"], {"parameters": answer}, data, 1)["parameters"].value
        for answer in ({"M": 3.0, "F_C": 5.5}, {"M": 3.0})
    ]
    assert values == pytest.approx([5.0, 50.0])


def test_least_squares_finds_the_axis(data):
    (entered,) = competitors_named(["least_squares"])
    found = dict(answered(Orders.of(entered.content, ("predict", "parameters"), data)))
    assert found["parameters"]["M"] == pytest.approx(3.0, rel=0.01)
    assert found["parameters"]["F_C"] == pytest.approx(5.0, rel=0.02)
    assert scored(["force"], found, data, 1)["force"].value < 1.0


def test_the_loop_of_the_true_axis_follows_as_simulated():
    law = controllers.cascade(k_p=100.0, k_v=600.0)
    axis = Axis(kind="translational", cutoff=200.0, controller=law)
    reference = Record.of(TIME, 0.02 * np.sin(2.0 * TIME) ** 2, None, axis)
    truth = friction.find("viscous")(F_v=60.0)
    loops = compensation_experiment(
        plants.inertia(M=3.0), truth, truth, law, reference.position, 1e-3
    )
    true = (
        reference.position
        - simulate(Experiment("loop", "translational", loops.variants[:1]))
        .variants["as_recorded"]
        .measured
    )
    # The mass that the iteration begins with is not that of the axis.
    error = following_error(
        lambda motion: 3.0 * motion.acceleration + 60.0 * motion.velocity, reference, 4.0
    )
    assert np.max(np.abs(error - true)[100:-100]) < 0.01 * np.max(np.abs(true))


@pytest.mark.parametrize("name", TASKS)
def test_a_task_has_scores_and_a_split(name):
    (task,) = tasks_named((name,))
    assert set(task.scores) <= set(SCORES)
    table = task.table
    if "train" in table:
        assert table["train"][1] <= table["test"][0]
    if "train_tables" in table:
        assert not set(table["train_tables"]) & set(table["test_tables"])


def test_missing_logs_skip_a_task_with_the_remedy(monkeypatch, tmp_path):
    monkeypatch.delenv("BRISTLE_DATA", raising=False)
    bench = Bench(tasks_named(("emps",)), competitors_named(["least_squares"]), "2026-01-01")
    assert "set it to the folder" in bench.skipped["task emps"]
    assert bench.units == []
    monkeypatch.setenv("BRISTLE_DATA", str(tmp_path))
    assert "has no emps/DATA_EMPS.mat" in bench.skipped["task emps"]


def test_an_unknown_name_suggests_a_similar_one():
    with pytest.raises(InputError, match="lugre"):
        competitors_named(["lugree"])
    with pytest.raises(InputError, match="emps"):
        tasks_named(("emp",))


def test_files_alone_meet_all_and_a_file_needs_fit(tmp_path):
    own = competitor(tmp_path, LEAST.format("0"))
    assert len(competitors_named([own])) > 5
    assert [entered.name for entered in competitors_named([own, "lugre"])] == ["own", "lugre"]
    for text, lacking in {
        "x = 1": "fit",
        "def fit(train): return None": "predict, feedforward or parameters",
    }.items():
        with pytest.raises(InputError, match=f"defines no function {lacking}"):
            competitors_named([competitor(tmp_path, text, "empty")])
    (lacking,) = (
        entered
        for entered in competitors_named(
            [competitor(tmp_path, "NEEDS = ('no_such_library',)\nfit = predict = 1", "lacking")]
        )
        if entered.name == "lacking"
    )
    assert lacking.missing == "no_such_library is not installed"


def test_a_run_continues_and_a_changed_competitor_runs_again(tmp_path, monkeypatch, data):
    monkeypatch.setattr("benchmarks.board.run._data", lambda *_: data)
    monkeypatch.setattr("benchmarks.board.task.Task.missing", "")
    calls = []
    monkeypatch.setattr(
        "benchmarks.board.run.answers",
        lambda orders, limit: calls.append(orders) or dict(answered(orders)),
    )

    def run(text):
        entered = [
            one for one in competitors_named([competitor(tmp_path, text)]) if one.name == "own"
        ]
        bench = Bench(tasks_named(("emps",)), tuple(entered), "2026-01-01")
        with growing_folder(tmp_path / "out", "score board") as (folder, _):
            return bench, bench.run(folder, 1)

    bench, finished = run(LEAST.format("0.5 * motion.acceleration"))
    assert run(LEAST.format("0.5 * motion.acceleration"))[1] == finished
    assert len(calls) == 1
    run(LEAST.format("0.6 * motion.acceleration"))
    assert len(calls) == 2
    summary = board(bench, finished, provenance={"command": "python -m benchmarks board own.py"})
    assert summary["scores"]["force"]["tasks"]["emps"]["own"]["status"] == OK
    assert "| own |" in page(summary)


def test_a_slow_competitor_does_not_try_the_other_axes_of_a_task(tmp_path, monkeypatch, data):
    monkeypatch.setattr("benchmarks.board.run._data", lambda *_: data)
    calls = []
    monkeypatch.setattr(
        "benchmarks.board.run.answers",
        lambda orders, limit: calls.append(1) or {"predict": Fault(SLOW, "used more than 1 s")},
    )
    own = next(
        one for one in competitors_named([competitor(tmp_path, LEAST.format("0"))]) if one.is_file
    )
    bench = Bench(tasks_named(("known_axis",)), (own,), "2026-01-01")
    with growing_folder(tmp_path / "out", "score board") as (folder, _):
        finished = bench.run(folder, 1)
        rest = replace(bench, competitors=()).further(folder)
    assert (len(calls), len(finished), rest) == (1, 6, 6)
    (text,) = failures(
        board(bench, finished, provenance={"command": "python -m benchmarks board own.py"})
    )
    assert text == "`own`, force on known_axis, reversals on known_axis: used more than 1 s"


def test_a_failure_ranks_last():
    tasks = {
        "a": {
            "x": {"status": OK, "value": 3.0},
            "y": {"status": OK, "value": 2.0},
            "z": {"status": "raised", "value": None},
        }
    }
    assert ranks(tasks) == {"y": 1.0, "x": 2.0, "z": 3.0}


@pytest.mark.slow
def test_the_date_draws_the_axes():
    (task,) = tasks_named(("known_axis",))
    first, again, later = (task.data("1", seed).truth for seed in (20260101, 20260101, 20260102))
    assert first == again != later


@pytest.mark.slow
def test_the_true_friction_of_a_known_axis_has_small_scores():
    """The contact is stiffer than the loop: passes without mixing diverge. A coarse encoder would let LuGre creep unseen."""
    (task,) = tasks_named(("known_axis",))
    data = task.data("1", 20260101)
    mass, values = (
        data.truth["M"],
        {name: value for name, value in data.truth.items() if name != "M"},
    )
    contact, plant = friction.find("lugre")(**values, sigma_1=0.0), plants.inertia(M=mass)

    def predict(motion):
        effort = effort_of_motion(
            plant, contact, {"time": motion.time, "position": motion.position}, motion.axis, {}
        )
        inside = np.flatnonzero(np.isfinite(effort))
        return np.interp(np.arange(effort.size), inside, effort[inside])

    answers = {
        "predict": [predict(data.test[0])],
        "loop": following_error(predict, data.reference, data.loop_mass),
    }
    scores = scored(["force", "reversals", "loop"], answers, data, 1)
    # Without the damping of the contact, which the table of the task does not list.
    assert all(
        scores[name].value < most
        for name, most in {"force": 5.0, "reversals": 10.0, "loop": 5.0}.items()
    )


def test_the_loop_without_friction_is_a_hundred_percent_wrong():
    axis = Axis(
        kind="translational", cutoff=40.0, controller=controllers.cascade(k_p=20.0, k_v=120.0)
    )
    reference = Record.of(TIME, record(1.0).position, None, axis)
    free = following_error(lambda motion: 3.0 * motion.acceleration, reference, 3.0)
    followed = free + 1e-4 * np.sign(reference.velocity)
    data = Data([record(1.0)], reference=reference, followed=followed, loop_mass=3.0)
    values = [
        scored(["loop"], {"loop": answer}, data, 1)["loop"].value
        for answer in (free, followed, 0.5 * (free + followed))
    ]
    assert values == pytest.approx([100.0, 0.0, 50.0], abs=1e-9)


LAW = controllers.sliding_mode(J=3.0, lambda_=100.0, K_1=80.0, cutoff=300.0)
CONTACT = {"F_C": 5.0, "F_S": 6.0, "v_S": 1e-3, "sigma_0": 2e6, "sigma_2": 20.0}


@pytest.mark.parametrize("answer", ["law, effort", "law", "effort"])
def test_a_feedforward_is_an_effort_or_a_controller_or_both(tmp_path, answer):
    text = f"""import numpy as np
from bristle import controllers
def fit(train): return None
def feedforward(fitted, reference):
    law, effort = controllers.disturbance_observer(J=3.0, lambda_=100.0, K_1=80.0, g=30.0), 7.0 * np.ones(reference.time.size)
    return {answer}
"""
    law, effort = replies(
        tmp_path, text, Data([record(1.0)], reference=record(1.3).motion), ("feedforward",)
    )["feedforward"]
    assert (law is not None, effort is not None) == ("law" in answer, "effort" in answer)
    assert law is None or law.name == "disturbance_observer"
    assert effort is None or np.all(effort == 7.0)


@pytest.mark.parametrize(
    "name",
    ["disturbance_observer", "asymptotic_observer", "predictive_reversal", "adaptive_hysteresis"],
)
def test_a_law_keeps_inertia_gains_and_cut_off_of_the_loop(name):
    competitor = import_module(f"benchmarks.board.competitors.{name}")
    reference = replace(record(1.3).motion, axis=replace(AXIS, controller=LAW, resolution=1e-7))
    fitted = competitor.fit([record(1.0)]) if name == "adaptive_hysteresis" else CONTACT
    law = competitor.feedforward(fitted, reference)
    kept = ("J", "lambda_", "K_1", "cutoff")
    assert {key: law.values[key] for key in kept} == {key: LAW.values[key] for key in kept}
    if name == "predictive_reversal":
        assert 1.0 < law.values["lead"] / reference.sample_time < 5.0
    if name == "asymptotic_observer":
        assert (law.values["g_2"] - law.values["g_1"]) ** 2 > 8.0 * CONTACT[
            "sigma_0"
        ] / 3.0  # real eigenvalues for each stiffness


def learning_law(axis):
    reference = replace(record(1.3).motion, axis=axis)
    fitted = stops.fit([record(1.0)])
    return (
        reference,
        stops.feedforward(fitted, reference),
        adaptive_hysteresis.feedforward(fitted, reference),
    )


def test_the_first_weights_of_the_learning_law_are_the_feedforward_of_the_stops():
    reference, fed, law = learning_law(replace(AXIS, controller=LAW, resolution=1e-7))
    weights = [law.values[f"w_{number}"] for number in range(7)]
    assert max(weights) > 1.0
    thresholds = law.values["reach"] / 6.0 * np.arange(1, 7)
    stops = hysteresis.prandtl_ishlinskii(thresholds=thresholds, weights=weights[1:] / thresholds)
    assert weights[0] + response(
        stops, reference.position - reference.position[0]
    ) == pytest.approx(fed, abs=1e-9)


def test_the_learning_law_learns_a_constant_force_within_an_eighth_of_a_second():
    _, _, law = learning_law(replace(AXIS, controller=LAW, resolution=1e-9))
    force, still = law.values["w_0"] + 2.0, friction.coulomb(F_C=0.0)
    disturbance = np.full(126, force)
    loops = compensation_experiment(
        plants.inertia(M=3.0), still, still, law, np.zeros(126), 1e-3, disturbance=disturbance
    )
    learned = (
        simulate(Experiment("loop", "translational", loops.variants[:1]))
        .variants[loops.variants[0].name]
        .controller
    )
    assert learned.values["w_0"] - law.values["w_0"] == pytest.approx(
        2.0 * (1.0 - np.exp(-1.0)), rel=0.1
    )


def test_a_feedforward_acts_without_the_delay_of_the_loop(monkeypatch):
    log, seen = record(1.0), []
    monkeypatch.setattr(
        simulated,
        "log_of",
        lambda truth: (
            Log.from_columns({"time": TIME, "position": log.position, "effort": log.effort}),
            AXIS,
        ),
    )
    monkeypatch.setattr(
        simulated, "peak_to_peak", lambda variant, number: seen.append(variant) or 4.0 / len(seen)
    )
    (task,) = tasks_named(("unknown_axis",))
    data = task.data(task.cases[0], 5)
    effort = np.arange(data.reference.time.size, dtype=float)
    assert (data.left(None, effort), data.left(LAW, None)) == (1.0 / 2.0, 1.0 / 3.0)
    plain, fed, led = seen  # the loop without compensation once for all competitors
    delay = fed.run.delay
    assert delay > 0
    assert np.array_equal(fed.injected[:-delay], effort[delay:])
    assert plain.controller is fed.controller is data.reference.axis.controller
    assert led.controller is LAW
    assert plain.injected is led.injected is None


def test_the_stops_feed_forward_all_but_the_inertia():
    position = 1e-4 * np.sin(2.0 * np.pi * TIME) * np.cos(0.4 * np.pi * TIME)
    moved = Record.of(TIME, position, None, AXIS)
    effort = 3.0 * moved.acceleration - 0.7 + np.tanh(moved.velocity / 1e-4)
    fitted = stops.fit([Record.of(TIME, position, effort, AXIS)])
    left = stops.predict(fitted, moved) - stops.feedforward(fitted, moved)
    mass = left @ moved.acceleration / (moved.acceleration @ moved.acceleration)
    assert left == pytest.approx(mass * moved.acceleration, abs=1e-9)
    assert np.mean(stops.feedforward(fitted, moved)) == pytest.approx(-0.7, abs=0.1)


def test_the_log_of_an_arm_has_the_columns_of_its_axis_file(monkeypatch):
    class ReachedError(Exception):
        pass

    def caught(log, robot, axis):
        raise ReachedError(log, axis)

    monkeypatch.setattr(bristle_all, "identify_arm", caught)
    part, time = record(1.0), 1e-3 * np.arange(4000)
    both = np.column_stack([part.position, -2.0 * part.position])
    axis = Axis(kind="rotational", cutoff=40.0)
    with pytest.raises(ReachedError) as reached:
        bristle_all.fit_arm(
            [Record.of(time, both, np.column_stack([part.effort, part.effort]), axis, "robot")]
        )
    log, described = reached.value.args
    logs, motion = identify.read_joints(log, axes_in(described))
    assert len(logs) == 2
    assert motion.position[:, 1] == pytest.approx(-2.0 * motion.position[:, 0], abs=1e-6)
