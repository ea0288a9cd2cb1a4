"""Every figure, drawn from made-up results in no time, with names as a person might choose them."""

import importlib
from functools import cache
from types import SimpleNamespace as Some

import numpy as np
from tests.apps.design.conftest import loop
from tests.apps.design.laws import rig
from tests.stand_ins import Loop

from bristle import figures, hysteresis
from bristle.apps.design import assess, loop_design
from bristle.apps.paper import rig_layout
from bristle.apps.study import many_runs
from bristle.core import Status
from bristle.identification.estimate import Estimate
from bristle.logs.passages import Passage
from bristle.prediction.comparison import Change, Course, Turn
from bristle.report.figures import loop_rows, preisach, small_multiples
from bristle.report.figures.following_error import open_loop

PLAIN = ("as_recorded", "compensated")
LONG = "axis_of_the_" + "very_" * 60 + "long_machine"

NAMES = (
    "$\\alpha_{1$ \\frac{ %d 100 % ^^ _x_",
    '<script>alert(1)</script> & &amp; ]]> --> " \' d="1.23456" id="x" url(#x)',
    LONG + "_1",
    LONG + "_2",
    "_hidden",
    "",
    " \t ",
    "first\nsecond\r\nthird\x0b\x85\u2028fourth",
    "\x00\x07\x1b[31mred\x7f\x9f \ud800 \udcff \ufffe \uffff \ufdd0 \U0001fffe",
    "ציר ראשי עם שם בעברית",
    "المحور الرئيسي 12",
    "\u202etxet desrever\u202c \u2066isolated",
    "😀 👩‍👩‍👧 轴的名称 축 e\u0301\u0301\u0301 ﷽",
    "{0} {{ x }} {% raw %} %s",
    "nolegend",
    "None",
)
T = 5e-3 * np.arange(801)
X = 2e-2 * np.sin(3.0 * T)
V = np.gradient(X, T)
F = 8.0 * np.tanh(V / 2e-3) + 30.0 * V + 0.3 * np.sin(40.0 * T)

SPREAD = loop_rows.Spread(0.5, 0.4, 0.6, 0.3, 2.0)

for _name in ("bars", "comparison", "first_screen", "fit", "motion", "recorded"):
    importlib.import_module(f"bristle.report.figures.{_name}")  # figures that reports alone have


def fit(names, name):
    """A fit whose parameters and model have these names."""
    estimates = [
        Estimate(item, "N", "a parameter", 8.0 + k, 0.1 * 10.0**k) for k, item in enumerate(names)
    ]
    traces = Some(
        time=T,
        velocity=V,
        acceleration=np.gradient(V, T),
        measured=F,
        predicted=0.97 * F,
        friction=F,
        residual=0.03 * F,
    )
    return Some(
        name=name,
        plant=Some(kind="translational"),
        traces=traces,
        estimates=estimates,
        correlation_names=names,
        correlation=np.linspace(-1.0, 1.0, len(names) ** 2).reshape(len(names), -1),
        held_out=Some(of="time blocks", block_errors_percent=(2.0, 3.0), mean_percent=2.5),
        error_percent=2.2,
        position_error_percent=None,
    )


def simulated(names, moved=1.0):
    """Variants of a loop; how much of its reference it follows."""
    return {
        name: Loop(
            name=name,
            time=T,
            reference=X,
            measured=moved * (X - 1e-5 * (k + 1) * np.tanh(V / 1e-3)),
            effort=F,
            position=X,
            velocity=V,
            friction=F,
            status=Status.OK,
        )
        for k, name in enumerate(names)
    }


def looped(names):
    """The result of an experiment with these variants."""
    run = Some(settle=0.5, sample_time=float(T[1]))
    experiment = Some(kind="translational", variants=[Some(name=name, run=run) for name in names])
    return Some(experiment=experiment, variants=simulated(names))


def compared():
    """Two logs held against each other, with a change that they tell and one that they do not."""
    changes = {
        name: Change(name, quantity, 2e-5, after, (after - 2.4e-5, after - 1.6e-5))
        for name, quantity, after in (
            ("following_error.rms", "length", 1e-5),
            ("friction.level", "force", 2.1e-5),
        )
    }
    turn = Turn(
        "forward_to_backward", T[:90] - T[30], 1e-5 * np.tanh(V[:90]), 8e-6 * np.tanh(V[:90])
    )
    return Some(
        kind="translational",
        changes=changes,
        course=Course(T, X, 1e-5 * np.tanh(V / 1e-3), 8e-6 * V / V.max()),
        turns=(turn,),
        window=0.15,
        friction_curve=[(speed, changes["friction.level"]) for speed in (0.01, 0.05)],
    )


def log():
    """A log with a loop in it, and what it contains."""
    channels = {
        name: Some(values=values)
        for name, values in (("time", T), ("position", X), ("velocity", V), ("effort", F))
    }
    result = [
        Passage("loops", slice(0, 500), 0.0, 2.5, 8),
        Passage("moves", slice(500, 801), 2.5, 4.0),
    ]
    return Some(kind="translational", sample_time=T[1], **channels), result


def motion():
    """A motion with small loops and steady slides."""
    pieces = [Some(purpose="presliding", duration=2.0), Some(purpose="stribeck", duration=2.0)]
    velocity = np.where(T < 2.0, V, np.where(T < 3.0, 2e-2, -5e-3))
    return Some(
        time=T,
        position=X,
        velocity=velocity,
        start=0.0,
        kind="translational",
        pieces=pieces,
        begins=(0.0, 2.0),
    )


def fleet(names):
    """The rows of a fleet whose parameters have these names, and which logs stand apart."""
    value = 8.0 + np.random.default_rng(4).normal(0.0, 0.2, 20)
    value[[3, 9]] = 40.0, np.nan
    columns = {"run": np.arange(20)}
    for name in names:
        columns |= {name: value, f"{name}.lower": value - 0.3, f"{name}.upper": value + 0.3}
        columns[f"{name}.status"] = np.where(np.isfinite(value), "identified", "")
    about = {name: {"unit": "N"} for name in names}
    return (
        Some(columns=columns, count=20, described={"columns": about}),
        names,
        dict.fromkeys(names, np.array([3, 5])),
    )


def circles_of(names):
    angle = np.linspace(0.0, 2.0 * np.pi, 400)
    return [
        Some(variant=name, angle=angle, deviation=1e-6 * (k + np.cos(4.0 * angle)))
        for k, name in enumerate(names)
    ]


def gallery(names=PLAIN, many=None):
    """Return what draws each figure, by name; `many` names, among them the others, where a figure has room for them."""
    many = tuple(many or names)
    item, other, *_ = names
    traces = {name: (1e-3 * X, F + k) for k, name in enumerate(many)}
    shares = dict.fromkeys(many, -0.3)
    exact = hysteresis.preisach(kernel="reformed_dahl_exact", s=1.25e7, f_p=150.0)
    best, planned = fit(many, item), motion()
    spread = np.random.default_rng(3).normal(6e-6, 5e-7, 400)
    loops, recorded = [traces[item], (2e-3 * X, F)], log()
    few, turns = {name: traces[name] for name in names}, {name: [0, 100, 300] for name in names}
    message = {name: f"{name}: 0.5 µm" for name in names}
    by_name = {name: np.full((2, 3), (9.0 - k, 8.0, 10.0)) for k, name in enumerate(names)}
    variant, both = loop(item), {"friction": traces[item], "read": traces[other]}
    return {
        "break_away": lambda: small_multiples.break_away(few, dict.fromkeys(names, 1e-5), 7e-6),
        "circles": lambda: loop_design.circles(circles_of(names), "translational"),
        "closure": lambda: figures.closure(traces, shares),
        "change_at_reversal": lambda: figures.comparison.change_at_reversal(compared()),
        "changes": lambda: figures.comparison.changes(compared()),
        "comparison": lambda: figures.comparison.comparison(compared()),
        "control_effort": lambda: loop_rows.control_effort(simulated(names), 0.5, (1.0, 2.0)),
        "correlations": lambda: figures.bars.correlations(
            [
                {"cause": name, "value": 0.9 - k, "interval": (0.8 - k, 0.95 - k)}
                for k, name in enumerate(names)
            ]
        ),
        "curve_errors": lambda: figures.recorded.curve_errors(
            [(X, F)], [0.97 * F], "translational"
        ),
        "drift": lambda: figures.drift(traces, dict.fromkeys(many, 3e-7)),
        "effort_at_reversal": lambda: figures.first_screen.effort_at_reversal(best),
        "effort_over_velocity": lambda: figures.recorded.effort_over_velocity(recorded[0]),
        "effort_over_time": lambda: figures.fit.effort_over_time(best),
        "error_distribution": lambda: loop_rows.error_distribution(simulated(names, 0.0), 0.5, 0.0),
        "error_over": lambda: loop_rows.error_over(
            [2, 4], by_name, {"scatter of the rig": 1.0}, "Loops", "Error [%]", counted=True
        ),
        "error_over_a_level": lambda: loop_rows.error_over(
            [1.0, 2.0, 4.0],
            {"found": np.array([(0.7, 0.68, 0.72), (0.6, 0.59, 0.61), (0.5, 0.5, 0.5)])},
            {item: 0.65, other: 0.4},
            "Level [N]",
            "Error [µm]",
        ),
        "errors_by_loop": lambda: loop_rows.errors_by_loop(
            {item: 1.47, other: 0.61},
            {item: 0.04, other: 0.01},
            {"as published": 1.46},
            "Error [µm]",
        ),
        "errors_by_truth": lambda: loop_rows.errors_by_truth(
            {
                "Set A": {item: {"both": SPREAD}, other: {"both": SPREAD}},
                "Set C": {item: {"both": SPREAD}},
            },
            0.5,
            "Error [µm]",
            "0.5 µm",
        ),
        "expected": lambda: figures.motion.expected(planned, F),
        "fleet_parameter": lambda: many_runs.fleet_parameter(
            fleet(names)[0], item, np.array([3, 5]), [f"log {k}" for k in range(20)]
        ),
        "fleet_parameters": lambda: many_runs.fleet_parameters(*fleet(names)),
        "following_error": lambda: figures.following_error(looped(many)),
        "following_error_focus": lambda: figures.following_error(looped((*many, "wild")), many),
        "friction_after_reversals": lambda: figures.friction_after_reversals(best, 1e-3),
        "friction_over_speed": lambda: figures.comparison.friction_over_speed(compared()),
        "friction_over_velocity": lambda: figures.friction_over_velocity(
            best, [(-0.1, -9.0), (0.1, 9.0)]
        ),
        "gain_at_reversal": lambda: figures.gain_at_reversal(looped(names), names[:2]),
        "log_over_time": lambda: figures.log_over_time(recorded[0]),
        "loop_family": lambda: small_multiples.loop_family(
            {item: {item: loops, other: loops}, other: {item: loops}}
        ),
        "loops_of_log": lambda: figures.recorded.loops_of_log(*recorded),
        "loops_proposed": lambda: loop_design.loops_proposed(
            many,
            [3e-6 / (k + 1) for k in range(len(many))],
            [None] * len(many),
            [50.0] * len(many),
            30.0,
        ),
        "margins": lambda: loop_design.margins(assess(rig(1))),
        "marked_path": lambda: small_multiples.marked_path(few, turns, "abc", message),
        "minor_loops": lambda: figures.minor_loops(traces),
        "motion": lambda: figures.motion.motion(planned),
        "named_bars": lambda: figures.bars.named_bars(
            many, [1e-6 * (k + 1) for k in range(len(many))], "translational", [True] * len(many)
        ),
        "open_loop": lambda: open_loop(looped(many)),
        "passages": lambda: figures.recorded.passages(*recorded),
        "prediction": lambda: figures.fit.prediction(predicted()),
        "prediction_error": lambda: figures.fit.prediction_error(predicted()),
        "preisach_plane": lambda: figures.preisach_plane(exact, [4e-5, -3e-5, 1e-5]),
        "preisach_stages": lambda: preisach.preisach_stages(
            exact, -6e-5, [4e-5, -3e-5, 2e-5, -1e-5]
        ),
        "recorded_curves": lambda: figures.recorded.recorded_curves(
            [(X, F)], [0.97 * F], "translational"
        ),
        "residuals": lambda: figures.fit.residuals(best),
        "marked_path_beneath": lambda: small_multiples.marked_path(
            few,
            turns,
            "abc",
            message,
            beneath=dict.fromkeys(names, (2e-3 * X, F + 3.0)),
            names=("friction", "read"),
        ),
        "rig_layout": lambda: rig_layout.rig_layout(
            rig_layout.Mechanics(5e-3, 4e-4, 2.5e-4, 200.0, 1.25e-7), variant
        ),
        "ripple": lambda: small_multiples.ripple(T, F, few, 200, message),
        "ripple_close_up": lambda: small_multiples.ripple(
            T, F, few, 200, message, close_up=(other, both)
        ),
        "study_spread": lambda: many_runs.study_spread(
            {name: {"1 Hz": spread, "2 Hz": 1.1 * spread} for name in (item, other)}, ["m", "N"]
        ),
        "tracking": lambda: loop_rows.tracking(simulated(names), 0.5, (1.0, 2.0)),
        "tracking_error": lambda: loop_rows.tracking_error(simulated(names), 0.5),
    }


def predicted():
    return Some(
        time=T,
        effort=F,
        effort_predicted=0.97 * F,
        half_width=np.full(T.size, 0.2),
        position=X,
        position_predicted=0.99 * X,
        position_half_width=None,
    )


def lines(axes):
    """The lines of a panel by their labels."""
    return {line.get_label(): line for line in axes.get_lines()}


@cache
def figure_of(name):
    """Return a figure, drawn once for all tests that only read it."""
    return gallery()[name]()


def drawn(names=PLAIN, many=None):
    """Return every figure as SVG, by name."""
    return {
        name: figures.inline_svg(draw(), name.replace("_", "-"), name)
        for name, draw in gallery(names, many).items()
    }
