"""A model, an identification and a log at the end of a cell: HTML, picture, widget, and fallbacks."""

import re
import subprocess
import sys
from dataclasses import replace
from types import SimpleNamespace as Some
from xml.etree import ElementTree

import numpy as np
import pytest
from tests.report.known import columns

import bristle as br
from bristle.core.contracts import example_of
from bristle.models.friction import MODELS
from bristle.report import cards, page

VIEW = "application/vnd.jupyter.widget-view+json"


@pytest.fixture(scope="module")
def found():
    return br.identify(columns(), "coulomb_viscous", draws=20)


@pytest.fixture
def kernel(monkeypatch):
    from bristle.apps.lab import Widget  # noqa: F401  (loads what itself asks for the shell)

    monkeypatch.setattr("IPython.get_ipython", lambda: Some(kernel=True))


def text_of(html):
    return re.sub(r"<[^>]*>", " ", re.sub(r"<style>.*?</style>", "", html, flags=re.DOTALL))


@pytest.mark.fast_cases(6)
@pytest.mark.parametrize("name", MODELS)
def test_a_friction_model_shows_its_equations_its_loops_and_its_parameters(name):
    model = example_of(MODELS[name])
    html = model._repr_html_()
    formulas = [
        "".join(ElementTree.fromstring(formula).itertext())
        for formula in re.findall(r"<math.*?</math>", html)
    ]
    for letters, latex in zip(formulas, model.component.latex, strict=True):
        assert "\\" not in letters
        assert {"F", "f"} & set(letters) or "F" not in latex
    assert (html.count("<svg"), html.count("<tr>")) == (1, 1 + len(model.values))
    assert model.component.description[1:] in text_of(html)
    assert repr(model).startswith(f"{name}(")


def test_parameters_of_a_model_have_readable_units():
    model = br.friction.maxwell_slip(F_C="20 N", k_i=[5e6, 2e6], nu_i=[0.25, 0.75], sigma_2=3.0)
    html = model._repr_html_()
    assert all(
        f">{text}</td>" in html for text in ("20 N", "5000, 2000 kN/m", "0.25, 0.75", "3 N·s/m")
    )


def test_equations_are_text_without_latex2mathml(monkeypatch):
    monkeypatch.setitem(sys.modules, "latex2mathml.converter", None)
    html = br.friction.coulomb(F_C=3.0)._repr_html_()
    assert "<math" not in html
    assert "<div>F = F_C sgn v</div>" in html


def test_the_cards_are_those_of_the_report(found):
    html = found._repr_html_()
    for card in cards.cards_of(found.best, None, usable=True):
        assert all(part in html for part in (f"<strong>{card.value}</strong>", card.remark))


def test_an_identification_shows_verdict_gain_warnings_and_report(found, monkeypatch):
    html = found._repr_html_()
    for part in (
        '<span class="pill usable">Usable</span>',
        "Not simulated: the axis file has no controller",
        '.report("report.html")',
    ):
        assert part in html
    assert html.count("<svg") == 1
    monkeypatch.setattr("bristle.report.messages.warnings_of", lambda fit: ("a <b>doubt</b>",))
    for module in ("brief", "judgement"):
        monkeypatch.setattr(
            f"bristle.report.{module}.ruling_of",
            lambda *a: page.Ruling("measure_again", "Measure again", ("<i>why</i>",)),
        )
    html = found._repr_html_()
    parts = (
        '<span class="pill measure_again">Measure again</span>',
        "a &lt;b&gt;doubt&lt;/b&gt;",
        "&lt;i&gt;why&lt;/i&gt;",
        "Not simulated",
    )
    assert [part in html for part in parts] == [True, True, True, False]


@pytest.mark.usefixtures("undrawn")
def test_a_saved_identification_shows_its_saved_verdict(found, tmp_path):
    found.save(tmp_path / "results")
    html = br.load(tmp_path / "results")._repr_html_()
    assert '<span class="pill usable">Usable</span>' in html
    assert html.count("<svg") == 1


def test_a_bar_is_as_wide_as_its_interval_and_empty_without_it():
    card = page.macro("card")
    for half, style in ((6.0, "left:40.0%;width:20.0%"), (80.0, "left:0.0%;width:100.0%")):
        assert f'style="{style}"' in card(cards.Card("a", "b", "c", half), None)
    assert re.search(
        r'<span class="bar"[^>]*></span>', card(cards.Card("a", "b", "c", open=True), None)
    )
    assert "<b>" not in card(cards.Card("<b>", "<b>", "<b>"), None)


def test_names_of_a_user_are_escaped():
    component = replace(MODELS["coulomb"], name="<b>mine</b>", description="<script>x</script>")
    html = replace(br.friction.coulomb(F_C=3.0), component=component)._repr_html_()
    assert [part in html for part in ("<b>mine", "<script", "&lt;b&gt;mine")] == [
        False,
        False,
        True,
    ]


def test_colours_follow_the_notebook():
    html = br.friction.coulomb(F_C=3.0)._repr_html_()
    parts = (
        "--ink:light-dark(#1b2430,#e8ecf1);",
        '[data-jp-theme-light="false"]',
        "var(--with,#0b3c6f)",
        "stroke: #0b3c6f",
    )
    assert [part in html for part in parts] == [True, True, True, False]


def test_a_kernel_gets_the_widget_with_html_beside_it(kernel):
    shown = br.friction.lugre(F_C=20.0, F_S=28.0, v_S=2e-3, sigma_0=1e7)
    data = shown._repr_mimebundle_()
    assert set(data) == {VIEW, "text/html", "text/plain"}
    assert data[VIEW]["model_id"]
    assert data["text/plain"] == repr(shown)
    assert set(br.plants.inertia(M=3.0)._repr_mimebundle_()) == {"text/html", "text/plain"}


def test_the_widget_has_the_card_above_its_sliders(found, kernel, monkeypatch):
    made = []
    monkeypatch.setattr(
        "bristle.report.model_in_hand.ModelInHand.widget",
        lambda self: made.append(Some(_repr_mimebundle_=dict)) or made[0],
    )
    found._repr_mimebundle_()
    assert [part in made[0]._card for part in ("Usable", "All parameters", "<style>")] == [
        True,
        False,
        False,
    ]


def test_a_terminal_gets_text_and_another_frontend_html(monkeypatch):
    model = br.friction.coulomb(F_C=3.0)
    for shell, kinds in ((Some, {"text/plain"}), (lambda: None, {"text/html", "text/plain"})):
        monkeypatch.setitem(sys.modules, "IPython", Some(get_ipython=shell))
        assert set(model._repr_mimebundle_()) == kinds


def test_html_remains_without_anywidget(kernel, monkeypatch):
    monkeypatch.setitem(sys.modules, "anywidget", None)
    monkeypatch.delitem(sys.modules, "bristle.apps.lab.widget", raising=False)
    assert set(br.friction.coulomb(F_C=3.0)._repr_mimebundle_()) == {"text/html", "text/plain"}


def test_html_remains_without_matplotlib(monkeypatch):
    def absent(*_):
        raise ImportError

    monkeypatch.setattr("bristle.report.figures.files.notebook_svg", absent)
    html = br.friction.coulomb(F_C=3.0)._repr_html_()
    assert [part in html for part in ("<math", "3 N", "<style", "<svg")] == [
        True,
        True,
        True,
        False,
    ]


@pytest.mark.slow
def test_a_model_is_shown_where_matplotlib_is_not_installed():
    code = (
        "import sys; sys.modules['matplotlib'] = None\nimport bristle as br\n"
        "assert '<math' in br.friction.coulomb(F_C=3.0)._repr_html_()"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_log_plots_position_velocity_and_effort():
    log = br.Log.from_columns(columns())
    figure = log.plot()
    assert [axes.get_ylabel().split(" [")[0] for axes in figure.axes] == [
        "Position",
        "Velocity",
        "Force",
    ]
    x, y = figure.axes[1].lines[0].get_data()
    t = np.asarray(x)
    expected = 1e3 * (0.06 * np.cos(3.0 * t) + 0.11 * np.cos(11.0 * t))
    assert np.nanmax(np.abs(y - expected)) < 2e-3 * 170.0
    assert figure.axes[1].get_title(loc="right") == "slope of the position"
    recorded = br.Log.from_columns(
        columns() | {"velocity": np.full(2500, 0.1) + 1e-3 * np.arange(2500)}
    )
    assert recorded.plot().axes[1].get_title(loc="right") == ""


def test_a_derived_velocity_stops_at_a_gap():
    t = np.concatenate([np.arange(500) * 1e-3, 5.0 + np.arange(500) * 1e-3])
    log = br.Log(
        time=t,
        position=np.where(t < 1.0, t, 100.0 + t),
        effort=t,
        sample_time=1e-3,
        segments=(slice(0, 500), slice(500, 1000)),
    )
    assert np.nanmax(log.plot().axes[1].lines[0].get_ydata()) < 1.1
