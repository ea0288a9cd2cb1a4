"""A figure of a user's own: what its file has to say, on which reports it can stand, and that results stay as they are."""

from types import SimpleNamespace as Some

import pytest

from bristle.core import InputError
from bristle.figures import ReportFigure, own, style

FILE = """
from bristle.figures import ReportFigure, style
def draw(simulation):
    return style.panels(2.0)[0]
FIGURE = ReportFigure(name="{name}", title="{title}", caption="{caption}", alternative="{alternative}", takes={takes}, draw={draw})
"""
USUAL = {"name": "mine", "title": "Mine", "caption": "See.", "alternative": "mine", "takes": '"simulation"', "draw": "draw"}


def written(folder, **changes):
    file = folder / "figure.py"
    file.write_text(FILE.format(**USUAL | changes))
    return file


def test_a_file_defines_a_figure(tmp_path):
    figure = own.load_figure_file(written(tmp_path))
    assert (figure.name, figure.needs) == ("mine", ("simulation",))
    assert own.load_figure_file(written(tmp_path, name="a" + "b" * 40)).name == "a" + "b" * 40
    assert own.load_figure_file(written(tmp_path, takes='("log", "design")')).needs == ("log", "design")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"name": "Mine"}, "an invalid name"),
        ({"name": "1mine"}, "an invalid name"),
        ({"name": "a" + "b" * 41}, "an invalid name"),
        ({"name": "following"}, "an invalid name"),
        ({"title": " "}, "has no title"),
        ({"caption": ""}, "has no caption"),
        ({"alternative": ""}, "has no alternative"),
        ({"draw": "3"}, "has no function `draw`"),
        ({"takes": '"weather"'}, "takes results that no report has.*weather"),
        ({"takes": "()"}, "takes results that no report has"),
        ({"takes": '("log", "weather")'}, "takes results that no report has.*weather"),
    ],
)
def test_an_incomplete_file_is_refused(tmp_path, changes, words):
    with pytest.raises(InputError, match=words):
        own.load_figure_file(written(tmp_path, **changes))


def figure(name="mine", takes="simulation", draw=lambda simulation: style.panels(2.0)[0], **more):
    return ReportFigure(name=name, takes=takes, draw=draw, caption="See.", alternative="mine", **more)


@pytest.mark.parametrize(
    ("takes", "report", "others", "words"),
    [
        ("simulation", "study", 1, r"the report of study lacks.*simulation.*bristle identify or bristle run"),
        (("study", "design"), "study", 0, r"lacks(?!.*Use the figure with)"),
        ("simulation", "run", 2, "another figure has the same name"),
    ],
)
def test_a_figure_is_on_reports_with_its_inputs(takes, report, others, words):
    own.refuse_unfit(figure(), "run", [figure()], "")
    with pytest.raises(InputError, match=words):
        own.refuse_unfit(figure(takes=takes), report, [figure()] * others, "")


def test_figures_are_given_as_objects_or_files(tmp_path):
    first, second = own.figures_named([figure("other"), written(tmp_path)], "run")
    assert (first.name, second.name) == ("other", "mine")
    assert own.figures_named((), "run") == ()
    with pytest.raises(InputError, match="another figure has the same name"):
        own.figures_named([figure(), written(tmp_path)], "run")


def test_a_figure_is_drawn_from_copies():
    facts = {"simulation": {"a": [1]}}

    def draw(simulation):
        simulation["a"].append(2)
        return style.panels(2.0)[0]

    assert own.draw_own(figure(draw=draw), facts).axes
    assert facts == {"simulation": {"a": [1]}}
    with pytest.raises(InputError, match="returned a int, not a Figure"):
        own.draw_own(figure(draw=lambda simulation: 3), facts)


def test_a_figure_is_not_kept_by_the_stateful_interface(monkeypatch):
    closed = []
    monkeypatch.setitem(own.sys.modules, "matplotlib.pyplot", Some(close=closed.append))
    drawing = own.draw_own(figure(), {"simulation": 1})
    assert closed == [drawing]


def test_a_figure_applies_with_all_its_inputs_and_takes_optional_results():
    item = figure(takes=("log", "fit"), may_take=("more",))
    assert item.missing({"log": 1, "fit": None}) == ("fit",)
    assert item.arguments({"log": 1, "fit": 2}) == (1, 2, None)
    assert [item.applies_to(facts) for facts in ({"log": 1, "fit": 2}, {"log": 1})] == [True, False]
    choosy = figure(takes=("log",), applies=lambda log: log > 1)
    assert [choosy.applies_to(facts) for facts in ({"log": 1}, {"log": 2}, {})] == [False, True, False]
