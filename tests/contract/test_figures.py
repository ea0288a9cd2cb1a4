"""What is demanded of a figure of a person's own: each fault is told by the demand that it misses."""

from pathlib import Path

import numpy as np
import pytest

from bristle.contract import check_figure
from bristle.contract.check import UnmetError
from bristle.core.variable import KINDS
from bristle.report.figures import ReportFigure, contract as figures, load_figure_file, style
from bristle.report.figures.contract import EXAMPLES, _experiment, _log, _study, example_facts

EXAMPLE = Path(__file__).parents[2] / "examples" / "own_figure.py"
COUNT = iter(range(1000))


def sound(log):
    figure, ((axes,),) = style.panels(2.0)
    axes.plot([0.0, 1.0], [0.0, 2.0])
    axes.set_xlabel("Time [s]")
    axes.set_ylabel("Share [%]")
    return figure


def changed(change):
    """What draws the same, and then something else."""

    def draw(log):
        figure = sound(log)
        return change(figure, figure.axes[0], log) or figure

    return draw


def figure_of(draw=sound, **parts):
    parts = {
        "title": "Title",
        "caption": "What to see.",
        "alternative": "what it is",
        "takes": "log",
    } | parts
    return ReportFigure(name="mine", draw=draw, **parts)


def unmet(figure):
    return [(check.name, check.detail) for check in check_figure(figure) if not check.passed]


@pytest.mark.slow
def test_a_figure_is_tried_with_the_results_that_it_may_take():
    taken = []

    def draw(log, identification):
        taken.append(identification)
        return sound(log)

    assert unmet(figure_of(draw, may_take=("identification",))) == []
    assert None not in taken


@pytest.mark.slow
def test_the_example_meets_the_contract():
    assert unmet(load_figure_file(EXAMPLE)) == []


@pytest.mark.slow
@pytest.mark.parametrize("takes", EXAMPLES)
def test_each_result_can_be_drawn(takes):
    seen = []

    def draw(result):
        seen.append(result)
        return sound(result)

    assert unmet(figure_of(draw, takes=takes)) == []
    assert [type(result) for result in seen[:2]] == [
        type(example_facts(kind)[takes]) for kind in ("translational", "rotational")
    ]


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    ("figure", "demand", "said"),
    [
        (figure_of(caption="What to see"), "described figure", "the caption is not a sentence"),
        (figure_of(title="Two\nlines"), "described figure", "title has several lines"),
        (
            figure_of(changed(lambda figure, axes, log: 3)),
            "draws each kind",
            "returned a int, not a Figure",
        ),
        (
            figure_of(changed(lambda figure, axes, log: log.nothing)),
            "draws each kind",
            "AttributeError",
        ),
        (
            figure_of(changed(lambda figure, axes, log: axes.lines[0].remove())),
            "shows numbers",
            "the drawing is empty",
        ),
        (
            figure_of(changed(lambda figure, axes, log: axes.set_ylabel("Share") and None)),
            "labelled axes",
            "no unit",
        ),
        (
            figure_of(changed(lambda figure, axes, log: axes.set_xlabel("") and None)),
            "labelled axes",
            "has no label",
        ),
        (
            figure_of(
                changed(
                    lambda figure, axes, log: (
                        axes.text(0.5, -0.9, "a text too low", rotation=3) and None
                    )
                )
            ),
            "legible texts",
            "'a text too low'",
        ),
        (
            figure_of(
                changed(
                    lambda figure, axes, log: axes.plot([0.0, next(COUNT)], [0.0, 1.0]) and None
                )
            ),
            "same figure twice",
            "the second drawing differs",
        ),
    ],
)
def test_each_fault_is_reported(figure, demand, said):
    missed = unmet(figure)
    assert [name for name, _ in missed] == [demand]
    assert said in missed[0][1]


@pytest.mark.slow
def test_changes_of_results_by_a_figure_are_discarded():
    fit = example_facts("translational", ("identification",))["identification"].best
    before = fit.traces.measured.copy()
    zeroed = figure_of(
        changed(lambda figure, axes, result: result.best.traces.measured.fill(0.0)),
        takes="identification",
    )
    assert unmet(zeroed) == []
    assert (fit.traces.measured == before).all()


def test_an_example_log_is_that_of_an_axis_whose_mass_and_friction_are_known():
    log = _log("rotational", 1, 2e-5)
    t, x, reference, effort = (
        getattr(log, name).values for name in ("time", "position", "reference", "effort")
    )
    assert (log.kind, t[-1], t.size) == ("rotational", pytest.approx(5.999), 6000)
    assert 0.02 < np.max(np.abs(reference)) <= 0.03
    velocity = np.gradient(reference, t)
    columns = np.column_stack([np.gradient(velocity, t), np.sign(velocity), velocity])
    found, *_ = np.linalg.lstsq(columns, effort, rcond=None)
    assert found == pytest.approx([12.0, 5.0, 80.0], rel=0.02)
    assert np.std(effort - columns @ found) == pytest.approx(0.2, rel=0.05)
    late = (reference - x) * np.sign(velocity)
    assert (np.mean(late), np.std(late)) == (
        pytest.approx(2e-5, rel=0.01),
        pytest.approx(1e-6, rel=0.05),
    )


# --- the results that figures are tried with --------------------------------------------------------------------------


FED, PLAIN = _experiment("rotational").variants
STUDIES = {kind: _study(kind) for kind in KINDS}
LEVEL, ERROR = (
    np.asarray(STUDIES["rotational"].columns[name])
    for name in ("friction.F_C", "following_error.rms")
)


def units_of(kind):
    return [
        STUDIES[kind].described["columns"][name]["unit"]
        for name in ("friction.F_C", "following_error.rms")
    ]


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        # A loop runs with and without friction feedforward, two periods after half of one in which it settles.
        ((FED.name, PLAIN.name, PLAIN.feedforward.friction), ("base", "uncompensated", None)),
        ((FED.feedforward.friction, PLAIN.friction), (FED.friction, FED.friction)),
        (
            (FED.friction.values["F_C"], FED.friction.values["F_v"], FED.plant.values["M"]),
            (5.0, 80.0, 12.0),
        ),
        (
            (
                FED.controller.values["k_p"],
                FED.controller.values["k_v"],
                FED.sensor.values["resolution"],
            ),
            (40.0, 2000.0, 1e-6),
        ),
        ((FED.reference.values["amplitude"], FED.reference.values["frequency"]), (0.01, 2.0)),
        ((FED.run.duration, FED.run.sample_time, FED.run.settle), (1.25, 1e-3, 0.25)),
        # Runs of a study have an error that grows with friction.
        (
            [(STUDIES[kind].described["kind"], STUDIES[kind].described["runs"]) for kind in KINDS],
            [(kind, 40) for kind in KINDS],
        ),
        (STUDIES["rotational"].described["draws"], 40),
        (
            [units_of(kind) for kind in ("translational", "rotational")],
            [["N", "m"], ["N*m", "rad"]],
        ),
        (ERROR, pytest.approx(1e-6 * LEVEL)),
        (
            (np.mean(LEVEL), np.std(LEVEL)),
            (pytest.approx(5.0, abs=0.25), pytest.approx(0.5, rel=0.3)),
        ),
        (set(STUDIES["rotational"].columns["status"]), {"ok"}),
        (list(STUDIES["rotational"].columns["run"]), list(range(40))),
    ],
)
def test_an_example_is_of_an_axis_that_is_known(found, expected):
    assert found == expected


def test_an_example_comparison_has_a_log_with_twice_the_error(monkeypatch):
    monkeypatch.setattr(figures, "compare", lambda before, after: (before, after))
    ((before, none),), ((after, nothing),) = EXAMPLES["comparison"]("rotational")
    apart = [
        float(np.mean(np.abs(log.reference.values - log.position.values)))
        for log in (before, after)
    ]
    assert apart == pytest.approx([2e-5, 1e-5], rel=0.01)
    assert (before.kind, after.kind, none, nothing) == ("rotational", "rotational", None, None)
    assert before.effort.values.tolist() != after.effort.values.tolist()


def test_a_figure_that_pyplot_keeps_is_closed(monkeypatch):
    from matplotlib import pyplot

    monkeypatch.setattr(figures, "example_facts", lambda kind, takes: {"log": kind})
    before = set(pyplot.get_fignums())
    parts = {"title": "Title", "caption": "A sentence.", "alternative": "lines", "takes": "log"}
    kept, returned = (
        figures._Trial(ReportFigure(name="mine", draw=draw, **parts))
        for draw in (lambda log: pyplot.figure(), print)
    )
    with pytest.raises(UnmetError, match="pyplot keeps the figure"):
        figures.nothing_left_open(kept)
    assert set(pyplot.get_fignums()) == before
    assert figures.nothing_left_open(returned).applies
