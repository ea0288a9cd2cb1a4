"""The first screen of an arm: a row and a picture per joint, the verdict first."""

import re
from types import SimpleNamespace as Some

import numpy as np
from tests.report.pages import Page

from bristle.figures.joints import effort_of_joints
from bristle.report.arm import arm_front, arm_prediction
from bristle.report.page import Front
from bristle.report.table import Table

TIME = np.arange(0.0, 8.0, 0.01)
ANGLE = np.sin(TIME)


def predicted(force, error):
    effort = force * np.sign(np.cos(TIME))
    return Some(time=TIME, position=ANGLE, effort=effort, effort_predicted=effort * (1.0 + error))


def summary(percent, level):
    metrics = {"force_error_percent": percent, "force_rmse": 1.5, "force_unit": "N*m"}
    verdict = {"level": level, "words": level, "reasons": ["a reason"]}
    return {
        "metrics": metrics,
        "inside_band_percent": None,
        "verdict": verdict,
        "completed": True,
        "kind": "rotational",
        "provenance": {"bristle": "0"},
    }


def page_of(names=("A1", "A2")):
    summaries = {name: summary(percent, level) for name, percent, level in zip(names, (4.0, 31.0), ("usable", "with_care"), strict=True)}
    predictions = {name: predicted(10.0 * (place + 1), 0.1) for place, name in enumerate(names)}
    return arm_prediction(summaries, predictions, "arm", "other.csv", "bristle predict")


def test_the_first_screen_has_the_row_of_each_joint_and_the_largest_error():
    data, table, page = page_of()
    assert data["verdict"]["level"] == "with_care"
    assert [row[0] for row in table.rows] == ["A1", "A2"]
    first = page[: page.index('<div class="tabs">')]
    assert re.search(r"Largest prediction error: 31.0\s% of the effort \(A2\)", Page(page).words)
    assert first.count('<th scope="row"') == 2
    assert first.index("The model is valid, with care") < first.index("<figure") < first.index('<th scope="row"')
    assert page[len(first) :].count('<th scope="row">A1') == 0  # each row once
    assert re.search('<figure id="figure-joints"', first)


def test_each_joint_has_a_picture_with_its_measured_and_predicted_effort():
    figure = effort_of_joints({"A1": predicted(10.0, 0.1), "A2": predicted(20.0, 0.2), "A3": predicted(5.0, 0.0)}, "rotational")
    assert len(figure.axes) == 3
    for axes, size, error in zip(figure.axes, (10.0, 20.0, 5.0), (0.1, 0.2, 0.0), strict=True):
        measured, model = axes.get_lines()
        assert np.max(np.abs(measured.get_ydata())) == size
        assert np.max(np.abs(model.get_ydata())) == size * (1.0 + error)
    assert [axes.get_ylabel() for axes in figure.axes] == 3 * ["Torque [N·m]"]


def test_an_identified_arm_names_the_joint_of_the_largest_error():
    table = Table("The axes", ("Axis",), [("A1",)])
    front = arm_front(Front("arm: a fleet", "2 of 2 axes"), table, {"A1": 0.05, "A2": 0.12})
    assert front.heading == "arm: an arm"
    assert front.title == "Largest model error: 12.0\u00a0% (A2)"
    assert front.table is table
    assert front.next.command.startswith("bristle predict arm ")
    assert arm_front(Front("arm: a fleet", ""), table, {}).title == ""
