"""Every figure: units at its axes, nothing overlaps, readable in grey, nothing else of matplotlib is changed."""

import itertools
import re
import subprocess
import sys
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib.colors import to_rgb

from bristle import figures
from bristle.core.variable import KINDS
from bristle.prediction import drive_table
from bristle.report.figures import fit, legibility

DRAW = {
    "effort_over_time": lambda bench: fit.effort_over_time(bench.identified.best),
    "following_error": lambda bench: figures.following_error(bench.looped),
    "following_error_focus": lambda bench: figures.following_error(
        bench.looped, ("feedforward", "compensated")
    ),
    "friction_over_velocity": lambda bench: figures.friction_over_velocity(
        bench.identified.best, drive_table(bench.identified.best, 100)
    ),
    "prediction": lambda bench: fit.prediction(bench.predicted, bench.axis.kind),
    "residuals": lambda bench: fit.residuals(bench.identified.best),
}


@pytest.fixture(scope="module")
def drawn(workbenches):
    """Each figure of each kind of axis."""
    return {(kind, name): DRAW[name](workbenches[kind]) for kind in KINDS for name in DRAW}


@pytest.fixture(params=itertools.product(KINDS, DRAW), ids="-".join)
def figure(request, drawn):
    return drawn[request.param]


def test_every_axis_has_a_name_and_a_unit(figure):
    assert legibility.unlabelled_axes(figure) == []


@pytest.mark.fast_cases(1)
def test_texts_neither_overlap_nor_leave_the_figure(figure):
    assert_legible(figure)


def assert_legible(figure):
    assert len(legibility.texts_of(figure)) > 4
    assert legibility.illegible_texts(figure) == []


def test_lines_with_a_name_differ_without_colour(figure):
    for axes in figure.axes:
        named = [line for line in axes.get_lines() if not line.get_label().startswith("_")]
        for line, other in itertools.combinations(named, 2):
            lightness = [
                np.dot(to_rgb(line.get_color()), (0.299, 0.587, 0.114)) for line in (line, other)
            ]
            shapes = [
                (line.get_linestyle(), str(line.get_marker()), line.get_fillstyle())
                for line in (line, other)
            ]
            assert abs(lightness[0] - lightness[1]) > 0.2 or shapes[0] != shapes[1]


FOREIGN = {
    "translational": r"(?i:rad|N·m|Torque|Angle)",
    "rotational": r"\[[kmµ]?N\]|m/s|\[[mµn]?m\]|Force|Position",
}


@pytest.mark.parametrize("name", DRAW)
def test_a_rotational_axis_is_labelled_torque_and_angle(name, drawn):
    for kind, words in FOREIGN.items():
        assert not re.search(
            words, " ".join(ax.get_xlabel() + ax.get_ylabel() for ax in drawn[kind, name].axes)
        )


def test_drawing_does_not_change_the_settings_of_matplotlib(stage):
    before = dict(matplotlib.rcParams)
    DRAW["residuals"](stage)
    assert dict(matplotlib.rcParams) == before


def test_no_file_of_figures_imports_the_stateful_interface():
    files = list(Path(figures.__file__).parent.glob("*.py"))
    assert len(files) > 20
    assert not [
        file.name
        for file in files
        if re.search(r"import .*pyplot|pyplot import", file.read_text(encoding="utf-8"))
    ]


@pytest.mark.slow
def test_the_stateful_interface_is_never_loaded():
    code = "import bristle.report.figures, sys; sys.exit('matplotlib.pyplot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
