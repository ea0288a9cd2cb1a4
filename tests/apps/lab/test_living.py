"""What a report that moves is told of a loop: which lines it draws, and why there is nothing to move."""

from types import SimpleNamespace
from typing import NamedTuple

import jinja2
import numpy as np
import pytest

from bristle import friction
from bristle.apps.lab import living, page
from bristle.apps.lab.page import PACKAGE
from bristle.apps.targets.page import loop as page_loop
from bristle.apps.targets.page.described import head_of
from bristle.core import FrictionModel, Status
from bristle.models.friction import find
from bristle.report.assets import environment, hash_of, joined, policy
from bristle.simulation import COMPENSATED

TIME = np.arange(4.0)


def every(values):
    return np.arange(values.size)


def simulated(*names, diverged=()):
    """A simulation of variants whose error is their number."""
    variants = [SimpleNamespace(name=name) for name in names]
    results = {
        name: SimpleNamespace(
            name=name,
            time=TIME,
            reference=np.full(4, 5.0),
            measured=np.full(4, 5.0 - number),
            status=Status.NOT_FINITE if name in diverged else Status.OK,
        )
        for number, name in enumerate(names, 1)
    }
    return SimpleNamespace(experiment=SimpleNamespace(variants=variants), variants=results)


def measured(contradiction=None):
    return SimpleNamespace(time=TIME, error=np.full(4, 9.0), contradiction=contradiction)


def lines(simulation, following):
    return [
        (name, error.tolist()[0]) for name, _, error in page_loop._errors(simulation, following)
    ]


@pytest.mark.parametrize(
    ("simulation", "following", "drawn"),
    [
        (simulated("a", "b"), None, [("a", 1.0), ("b", 2.0)]),
        (simulated("a", "b"), measured(), [("measured", 9.0), ("a", 1.0), ("b", 2.0)]),
        (None, measured(), [("measured", 9.0)]),
        (None, None, []),
        # A loop that diverged has no line, and of a contradicted simulation there is the first loop alone.
        (simulated("a", "b", diverged=("a",)), None, [("b", 2.0)]),
        (simulated("a", "b"), measured("it follows otherwise"), [("measured", 9.0), ("a", 1.0)]),
    ],
)
def test_a_line_is_the_reference_minus_the_measurement(simulation, following, drawn):
    assert lines(simulation, following) == drawn


@pytest.mark.parametrize(
    ("simulation", "following", "reason", "moves"),
    [
        (simulated("a", COMPENSATED), measured(), "", True),
        (simulated("a", COMPENSATED), None, "", True),
        (
            simulated("a", COMPENSATED),
            measured("otherwise"),
            "the log contradicts the simulated loop",
            False,
        ),
        (
            simulated("a"),
            measured(),
            "no loop was simulated: the axis file has no controller",
            False,
        ),
        (None, measured(), "no loop was simulated: the axis file has no controller", False),
    ],
)
def test_a_loop_moves_or_gives_a_reason(monkeypatch, simulation, following, reason, moves):
    monkeypatch.setattr(
        page_loop,
        "loop_described",
        lambda variant, friction: ({"of": variant.name, "friction": friction}, ""),
    )
    part = page_loop.followed_described("model", simulation, following, every)
    assert part["reason"] == reason
    assert part["loop"] == ({"of": COMPENSATED, "friction": "model"} if moves else None)
    assert [trace["name"] for trace in part["traces"]] == [
        name for name, _ in lines(simulation, following)
    ]


def test_without_a_following_error_there_is_no_part():
    assert page_loop.followed_described("model", None, None, every) is None
    assert (
        page_loop.followed_described(
            "model", simulated(COMPENSATED, diverged=(COMPENSATED,)), None, every
        )
        is None
    )


def test_each_parameter_has_its_status():
    parameters = {
        "F_C": SimpleNamespace(status="identified", ends=(1.0, 2.0)),
        "F_v": SimpleNamespace(status="at limit", ends=None),
    }
    assert living.uncertainty_of(SimpleNamespace(parameters=parameters)) == {
        "F_C": {"status": "identified", "interval": (1.0, 2.0)},
        "F_v": {"status": "at limit", "interval": None},
    }


@pytest.fixture
def identified(monkeypatch):
    """A function that returns the part of an identification whose rows and model are made up."""
    requested = []
    rows = SimpleNamespace(
        mechanical=[SimpleNamespace(name="M"), SimpleNamespace(name="")],
        as_data=lambda: {"rows": 1},
    )
    model = {"scales": {"force": 3.0}}

    def described(friction, **how):
        requested.append(how)
        return model

    def variables(plant, moved, scale, uncertainty, around):
        requested.append((moved, scale, around))
        return [{"name": "M", "fixed": False}, {"name": "g", "fixed": True}]

    monkeypatch.setattr(page_loop, "fitted_rows", lambda *passed: rows)
    monkeypatch.setattr(page_loop, "model_described", described)
    monkeypatch.setattr(page_loop, "variables_of", variables)
    monkeypatch.setattr(living, "as_json", lambda data: requested.append(data) or "DATA")

    def part(kind="translational", logs=()):
        best = SimpleNamespace(friction="model", plant=SimpleNamespace(kind=kind), parameters={})
        made = living.living_part(
            SimpleNamespace(best=best, log=None, treatment=None, further_logs=logs), None
        )
        return made, requested

    return part


@pytest.mark.parametrize(
    ("kind", "unit", "word"), [("translational", "N", "force"), ("rotational", "N·m", "torque")]
)
def test_a_part_has_the_words_and_the_unit_of_its_axis(identified, kind, unit, word):
    part, (how, variables, data) = identified(kind, ("second", "third"))
    assert (data["effort"], data["word"], data["logs"], data["loop"]) == (unit, word, 3, None)
    assert (how["around"], how["proven"], variables) == (3.0, False, (["M"], 3.0, 3.0))
    assert [row["name"] for row in data["plant"]] == ["M"]
    assert str(part.data) == "DATA"
    assert part.policy == policy([joined(living.SHARED, PACKAGE), joined(living.SCRIPTS, PACKAGE)])


def test_a_model_that_no_page_computes_has_no_part(identified, monkeypatch):
    monkeypatch.setattr(page_loop, "fitted_rows", lambda *passed: None)
    assert identified()[0] is None


# --- the policy ------------------------------------------------------------------------------------------------------


def test_a_script_is_named_by_its_hash():
    # Of nothing, as RFC 6234 has it.
    assert hash_of("") == "'sha256-47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU='"


def test_a_policy_allows_exactly_the_named_scripts():
    text = policy(["a", "b"], ["c"])
    assert text.startswith(
        f"default-src 'none'; script-src {hash_of('a')} {hash_of('b')} 'wasm-unsafe-eval'; style-src {hash_of('c')}; img-src data:; "
    )
    assert "'unsafe-inline'" not in text
    assert "style-src 'unsafe-inline';" in policy(["a"])


def test_a_line_of_up_to_four_thousand_samples_is_drawn_whole(monkeypatch):
    thinned = []
    monkeypatch.setattr(
        living,
        "living_described",
        lambda *passed, **how: thinned.append((how["around"], how["thinned"])),
    )
    assert living.living_part(SimpleNamespace(best=SimpleNamespace(parameters={})), None) is None
    ((around, envelope),) = thinned
    assert (around, envelope(np.arange(4000.0)).size) == (3.0, 4000)
    assert envelope(np.arange(4001.0)).size < 4000


def test_a_page_gets_only_known_facts_of_the_model(monkeypatch):
    reported, model = [], friction.coulomb(F_C=3.0)
    monkeypatch.setattr(page, "paper_loop", lambda: "loop")
    monkeypatch.setattr(
        page, "lab_described", lambda *passed, **options: reported.append((*passed, options)) or {}
    )
    page.lab_page()
    page.lab_page(model)
    text = page.lab_page(
        model,
        mass=2.0,
        fastest=0.5,
        source="a.toml",
        uncertainty={},
        provenance={"model": "a <file>"},
    )
    assert "a &lt;file&gt;" in text
    unknown = {"uncertainty": None, "mass": None, "fastest": 0.0, "named": ""}
    known = {"uncertainty": {}, "mass": 2.0, "fastest": 0.5, "named": "coulomb of a.toml"}
    assert reported == [
        ("preisach_lugre", "loop", unknown),
        (model, "loop", unknown),
        (model, "loop", known),
    ]


# --- Templates of a page, and what a model is called on it


class Nothing(NamedTuple):
    """No parameters and no state."""


def trial(state, memory, motion, dt, p):
    return 0.0, state


def test_lines_of_a_template_that_are_no_text_leave_no_line_and_no_space():
    template = environment(PACKAGE).from_string(
        "<ul>\n  {% for word in words %}\n<li>{{ word }}</li>\n  {% endfor %}\n</ul>\n"
    )
    assert template.render(words=["a", "<b>"]) == "<ul>\n<li>a</li>\n<li>&lt;b&gt;</li>\n</ul>"
    with pytest.raises(jinja2.UndefinedError):
        environment(PACKAGE).from_string("{{ missing }}").render()


def test_a_model_of_a_file_is_called_by_its_file_and_a_model_of_the_package_by_its_name():
    own = FrictionModel(
        name="own",
        description="",
        Parameters=Nothing,
        State=Nothing,
        trial=trial,
        commit=lambda state, *_: state,
    )
    assert head_of(own) == {"toml": 'file = "test_living.py"', "python": ""}
    assert head_of(find("lugre+asymmetry")) == {
        "toml": 'model = "lugre+asymmetry"',
        "python": 'br.friction.find("lugre+asymmetry")',
    }
