"""Every figure: units at its axes, nothing overlaps, readable in grey, nothing else of matplotlib is changed."""

import itertools
import re
import subprocess
import sys

import matplotlib
import numpy as np
import pytest
from matplotlib.colors import to_rgb

from bristle import figures
from bristle.figures.legibility import illegible_texts, texts_of
from bristle.prediction import drive_table


def draw(name, bench):
    best = bench.identified.best
    curve = drive_table(best, 100)
    return {
        "effort_over_time": lambda: figures.fit.effort_over_time(best),
        "following_error": lambda: figures.following_error(bench.looped),
        "following_error_focus": lambda: figures.following_error(bench.looped, ("feedforward", "compensated")),
        "friction_over_velocity": lambda: figures.friction_over_velocity(best, curve),
        "prediction": lambda: figures.fit.prediction(bench.predicted, best.plant.kind),
        "residuals": lambda: figures.fit.residuals(best),
    }[name]()


NAMES = ("effort_over_time", "following_error", "following_error_focus", "friction_over_velocity", "prediction", "residuals")


@pytest.fixture(params=NAMES)
def figure(request, workbench):
    return draw(request.param, workbench)


@pytest.mark.fast_cases(8)
def test_every_axis_has_a_name_and_a_unit(figure):
    for axes in figure.axes:
        assert axes.get_xlabel()
        assert axes.get_ylabel() or not any(tick.label1.get_visible() for tick in axes.yaxis.get_major_ticks())
        for label in (axes.get_xlabel(), axes.get_ylabel()):
            assert not label or re.search(r"\[[^\]]+\]$", label), label


@pytest.mark.fast_cases(1)
def test_texts_neither_overlap_nor_leave_the_figure(figure):
    assert_legible(figure)


def assert_legible(figure):
    assert len(texts_of(figure)) > 4
    assert illegible_texts(figure) == []


def test_lines_with_a_name_differ_without_colour(figure):
    for axes in figure.axes:
        named = [line for line in axes.get_lines() if not line.get_label().startswith("_")]
        for line, other in itertools.combinations(named, 2):
            lightness = [np.dot(to_rgb(line.get_color()), (0.299, 0.587, 0.114)) for line in (line, other)]
            shapes = [(line.get_linestyle(), str(line.get_marker()), line.get_fillstyle()) for line in (line, other)]
            assert abs(lightness[0] - lightness[1]) > 0.2 or shapes[0] != shapes[1]


@pytest.mark.parametrize("name", NAMES)
def test_a_rotational_axis_is_labelled_torque_and_angle(name, workbenches):
    labels = {kind: " ".join(ax.get_xlabel() + ax.get_ylabel() for ax in draw(name, bench).axes) for kind, bench in workbenches.items()}
    assert not re.search(r"rad|N·m|Torque|Angle", labels["translational"], re.IGNORECASE)
    assert not re.search(r"\[[kmµ]?N\]|m/s|\[[mµn]?m\]|Force|Position", labels["rotational"])


def test_drawing_does_not_change_the_settings_of_matplotlib(stage):
    before = dict(matplotlib.rcParams)
    for name in NAMES:
        draw(name, stage)
    assert dict(matplotlib.rcParams) == before


def test_the_stateful_interface_is_never_loaded():
    code = "import bristle.figures, sys; sys.exit('matplotlib.pyplot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
