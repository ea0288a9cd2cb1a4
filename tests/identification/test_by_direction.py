"""Only ``+asymmetry`` makes parameters directional, not the ending of a name."""

import re
from dataclasses import replace
from typing import Annotated, NamedTuple

import pytest
from tests.identification.known_logs import STATED, slow_log
from tests.identification.rigid import identify

from bristle.core import FrictionModel, Variable
from bristle.core.mathematics import direction
from bristle.friction import find
from bristle.friction.slots import by_direction, directional, slotted
from bristle.identification.settings import DEFAULT
from bristle.report.judgement import judged
from bristle.report.messages import warnings_of
from bristle.report.model_tables import WITH_CONSTANT, parameter_table


class Parameters(NamedTuple):
    F_neg: Annotated[float, Variable("force", "level against the motion", min=0.0, excitation="sliding")]


class State(NamedTuple):
    pass


def trial(state, memory, motion, dt, p):
    return p.F_neg * direction(motion.v), State()


def commit(state, memory, move, p):
    return state


OWN = FrictionModel(
    name="against",
    description="a level whose name ends as one of a direction",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    linear=True,
)


def test_a_level_named_like_a_directional_level_does_not_fix_the_offset():
    fit = identify(slow_log(find("coulomb_viscous")(F_C=5.0, F_v=0.0, offset=1.5), duration=6.0), OWN, axis=STATED, blocks=0, draws=0).best
    assert fit.parameters["offset"].status == "identified"
    assert fit.parameters["offset"].value == pytest.approx(1.5, abs=0.1)


@pytest.mark.parametrize("name", ["stribeck", "stribeck+position+asymmetry", "gms+asymmetry"])
def test_a_component_names_its_parameters_by_direction(name):
    component, sided = find(name), "asymmetry" in name
    assert by_direction(component, "F_S") == (("F_S_pos", "F_S_neg") if sided else ("F_S",))
    assert (by_direction(component, "v_S"), by_direction(component, "offset")) == (("v_S",), ("offset",))
    assert set(directional(component)) == {key for key in component.variables if key[-4:] in ("_pos", "_neg")}
    assert directional(slotted(OWN, asymmetry=False)) == directional(OWN) == ()


@pytest.mark.parametrize(("offset", "code"), [(3.0, "held_levels"), (-12.0, "held_constant"), (12.0, "held_constant")])
def test_a_weight_larger_than_friction_makes_no_level_negative(offset, code):
    truth = find("coulomb_viscous+asymmetry")(F_C_pos=5.0, F_C_neg=4.0, F_v_pos=0.0, F_v_neg=0.0, offset=offset)
    fit = identify(slow_log(truth, duration=6.0), "coulomb_viscous+asymmetry", axis=STATED, blocks=0, draws=0).best
    result = {name: item.value for name, item in fit.parameters.items()}
    assert fit.parameters["offset"].reason.code == code
    assert result["F_C_pos"] + result["offset"] == pytest.approx(5.0 + offset, abs=0.1)
    assert result["F_C_neg"] - result["offset"] == pytest.approx(4.0 - offset, abs=0.1)
    assert {fit.parameters[name].status for name in ("F_C_pos", "F_C_neg")} == {"identified"}
    remarks = {row[0]: row[-1] for row in parameter_table(fit).rows}
    assert [name for name, remark in remarks.items() if remark == WITH_CONSTANT] == ["F_C_pos", "F_C_neg"]
    assert any("which bristle guessed" in text for text in warnings_of(fit)) is (code == "held_constant")


def notes_of(identification, *ranked):
    """Notes about the offset where these models rank so."""
    fits = {fit.name: fit for fit in identification.fits}
    return [note for note in replace(identification, fits=tuple(fits[name] for name in ranked)).notes if "offset" in note]


def test_a_constant_force_is_compared_with_the_level_not_with_break_away():
    """It is reported from a quarter of the level: 2.2 N of 6 N, for any break-away force."""
    log = slow_log(find("stribeck")(F_C=6.0, F_S=12.0, v_S=2e-3, F_v=30.0, offset=2.2), duration=6.0)
    assert notes_of(identify(log, ["stribeck+asymmetry", "stribeck"], axis=STATED, blocks=0, draws=0), "stribeck+asymmetry", "stribeck")


def test_break_away_by_direction_is_valid_with_the_offset():
    shape = {"v_S": 2e-3, "F_v_pos": 30.0, "F_v_neg": 30.0, "offset": 12.0}
    truth = find("stribeck+asymmetry")(F_C_pos=8.0, F_C_neg=6.0, F_S_pos=11.0, F_S_neg=9.0, **shape)
    fit = identify(slow_log(truth, duration=6.0), "stribeck+asymmetry", axis=STATED, blocks=0, draws=0).best
    assert fit.with_constant == ("F_C_pos", "F_C_neg", "F_S_pos", "F_S_neg")
    (message,) = (text for text in warnings_of(fit) if "which bristle guessed" in text)
    assert "F_C_pos, F_C_neg, F_S_pos, F_S_neg are valid only with an offset of 1" in message
    judgement = judged(fit, DEFAULT)
    assert judgement.level != "usable"
    assert any("a guessed weight" in reason for reason in judgement.reasons)


@pytest.mark.parametrize(("offset", "told"), [(3.0, True), (0.6, False), (0.0, False)])
def test_a_constant_force_found_by_another_model_is_named(offset, told):
    log = slow_log(find("coulomb_viscous")(F_C=5.0, F_v=0.0, offset=offset), duration=6.0)
    split, plain = "coulomb_viscous+asymmetry", "coulomb_viscous"
    identification = identify(log, [split, plain], axis=STATED, blocks=0, draws=0)
    named = notes_of(identification, split, plain)
    assert bool(named) is told
    if told:
        assert re.search(r'coulomb_viscous identified offset = (3|2\.9).*offset = "(3|2\.9)\d*\.?\d* N" under \[plant\]', named[0])
    assert notes_of(identification, plain, split) == notes_of(identification, split) == []
