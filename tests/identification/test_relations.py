"""An identified model is valid: it satisfies its ranges and relations."""

from dataclasses import replace
from typing import Annotated, NamedTuple

import pytest
from tests.identification.known_logs import STATED, sliding_log, slow_log

from bristle import friction
from bristle.core import FrictionModel, InputError, Relation, Variable, kernel
from bristle.core.mathematics import decay, direction
from bristle.files import read_model, write_model
from bristle.friction.slots import slotted
from bristle.identification import identify

pytestmark = pytest.mark.usefixtures("of_one_mass")


class Parameters(NamedTuple):
    F_S: Annotated[float, Variable("force", "level at rest", min=0.0, excitation="sliding")]
    F_C: Annotated[float, Variable("force", "level in motion", min=0.0, excitation="sliding")]


class State(NamedTuple):
    pass


@kernel
def trial(state, memory, motion, dt, p):
    ratio = motion.v / 4e-3
    share = decay(ratio * ratio)
    return (p.F_S * share + p.F_C * (1.0 - share)) * direction(motion.v), State()


@kernel
def commit(state, memory, move, p):
    return state


def two_levels(condition, holds, **changes):
    return FrictionModel(
        name="two_levels",
        description="a level at rest and one in motion",
        Parameters=Parameters,
        State=State,
        trial=trial,
        commit=commit,
        relations=(Relation(condition, holds, "Lower F_C"),),
        **changes,
    )


@pytest.fixture(scope="module")
def rising():
    """A log of friction that rises with speed, against the relation F_S >= F_C."""
    return slow_log(friction.stribeck(F_C=8.0, F_S=5.0, v_S=4e-3, F_v=0.0, validate=False), duration=10.0)


@pytest.mark.parametrize("linear", [False, True])
def test_a_relation_is_satisfied_for_any_order_of_the_parameters(rising, linear):
    model = two_levels("F_S >= F_C", lambda p: p.F_S >= p.F_C, linear=linear)
    fit = identify(rising, model, axis=STATED, blocks=0, draws=0).best
    values = fit.friction.values
    assert values["F_S"] >= values["F_C"]
    assert values["F_S"] == pytest.approx(values["F_C"], rel=1e-3)
    assert model(**{name: values[name] for name in ("F_S", "F_C")}).values["F_C"] == values["F_C"]


def test_a_strict_relation_is_satisfied_with_a_margin(rising):
    model = two_levels("F_S > F_C", lambda p: p.F_S > p.F_C)
    values = identify(rising, model, axis=STATED, blocks=0, draws=0).best.friction.values
    assert values["F_S"] > 1.02 * values["F_C"]


class OneSided(NamedTuple):
    F_S: Annotated[float, Variable("force", "level at rest", min=0.0, excitation="sliding", directional=True)]
    F_C: Annotated[float, Variable("force", "level in motion", min=0.0, excitation="sliding")]


def test_a_relation_with_one_directional_side_is_satisfied_in_both_directions(rising):
    model = two_levels("F_S >= F_C", lambda p: p.F_S >= p.F_C)
    model = slotted(replace(model, name="one_sided", Parameters=OneSided), asymmetry=True)
    values = identify(rising, model, axis=STATED, blocks=0, draws=0).best.friction.values
    assert min(values["F_S_pos"], values["F_S_neg"]) >= values["F_C"]


def test_a_relation_that_no_search_can_satisfy_is_rejected(rising):
    model = two_levels("F_C within F_S", lambda p: p.F_C <= p.F_S)
    with pytest.raises(InputError, match="has values that the model does not allow") as caught:
        identify(rising, model, axis=STATED, blocks=0, draws=0)
    assert caught.value.path == "model"
    assert "F_C within F_S" in caught.value.message
    assert "another model" in caught.value.mend


def test_a_model_with_an_impossible_relation_is_omitted_and_reported(rising):
    model = two_levels("F_C within F_S", lambda p: p.F_C <= p.F_S)
    identification = identify(rising, [model, "coulomb_viscous"], axis=STATED, blocks=0, draws=0)
    assert [fit.name for fit in identification.fits] == ["coulomb_viscous"]
    assert "two_levels is omitted: the best fit of two_levels has values that the model does not allow" in identification.notes[-1]


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    "name", ["viscous", "coulomb_viscous+asymmetry", "stribeck", "stribeck+asymmetry", "dahl", "lugre", "lugre+asymmetry"]
)
def test_an_identified_model_can_be_loaded(tmp_path, name):
    best = identify(sliding_log(F_v=-2.0), name, axis=STATED, blocks=0, draws=0).best
    write_model(tmp_path / "model.toml", best.plant, best.friction, estimates=best.estimates)
    assert read_model(tmp_path / "model.toml").friction.values == best.friction.values
