"""Channels of a log that friction depends on, and slots over them."""

from typing import Annotated, NamedTuple

import numpy as np
import pytest

from bristle.core.errors import InputError
from bristle.core.kernel import kernel
from bristle.core.motion import Motion
from bristle.core.slot import Slot, refuse_unfit
from bristle.core.surroundings import OF_MOTION, Surrounding, at_rest, motion_with, on_side, reader_of
from bristle.core.variable import Variable

HUMID = Variable("1", "relative humidity", min=0.0, max=1.0)
HUMIDITY = Surrounding("humidity", HUMID, usual=0.5)


class Parameters(NamedTuple):
    k_H: Annotated[float, Variable("1", "rise with humidity", excitation="channel")] = 0.0
    H_0: Annotated[float, Variable("1", "where nothing rises")] = 0.5


@kernel
def factor(c, p):
    return 1.0 + p.k_H * (c - p.H_0)


def slot(**changes):
    parts = {"name": "humid", "description": "rises", "Parameters": Parameters, "channel": HUMIDITY, "factor": factor}
    return Slot(**parts | changes)


@pytest.mark.parametrize("name", ["", "a b", "class", "_x", "größe", "1x", 3])
def test_a_channel_has_a_name_that_can_be_asked_for(name):
    with pytest.raises(InputError, match="is not a valid name of a channel"):
        Surrounding(name, HUMID, 0.5)


def test_a_user_channel_has_a_new_name_and_a_usual_value_within_its_range():
    with pytest.raises(InputError, match="is already the name of a channel of bristle"):
        Surrounding("load", HUMID, 0.5)
    with pytest.raises(InputError, match="usual value of humidity"):
        Surrounding("humidity", HUMID, 1.5)
    with pytest.raises(InputError, match="needs a Variable"):
        Surrounding("humidity", "1", 0.5)


def test_required_channels_besides_the_motion_are_listed():
    assert (HUMIDITY.field, HUMIDITY.is_own, HUMIDITY.is_recorded) == ("humidity", True, True)
    load, position, transmitted = (OF_MOTION[name] for name in ("load", "position", "transmitted"))
    assert (load.field, load.is_own, load.is_recorded) == ("load", False, True)
    assert (position.field, position.is_own, position.is_recorded) == ("x", False, False)
    assert (transmitted.is_own, transmitted.is_recorded) == (False, False)
    assert position.usual == 0.0


def test_a_motion_has_each_requested_channel_once():
    assert motion_with([OF_MOTION["load"]]) is Motion
    wider = motion_with([HUMIDITY, OF_MOTION["load"], HUMIDITY])
    assert wider._fields == (*Motion._fields, "humidity")
    assert wider(1.0, 2.0).humidity == 0.5
    with pytest.raises(InputError, match="different descriptions in two slots"):
        motion_with([HUMIDITY, Surrounding("humidity", HUMID, usual=0.4)])


def test_only_a_moving_axis_transmits_effort():
    motion = motion_with([HUMIDITY])(3.0, 2.0, 1.5, 300.0, 7.0, 0.9)
    assert at_rest(-0.0, motion) == (0.0, 2.0, 1.5, 300.0, 0.0, 0.9)
    assert on_side(-0.0, motion) == (0.0, 2.0, 1.5, 300.0, 7.0, 0.9)
    assert reader_of(HUMIDITY)(motion) == 0.9
    assert reader_of(HUMIDITY)(Motion(3.0, 2.0)) == 0.5
    assert reader_of(OF_MOTION["position"])(motion) == 2.0


def test_a_slot_lists_its_identified_parameters():
    assert slot().identified == ("k_H",)
    assert slot().neutral == (0.0, 0.5)
    assert slot(channel="load").channel == OF_MOTION["load"]
    refuse_unfit(slot())
    with pytest.raises(InputError, match="is not a channel of a log"):
        slot(channel="wind")
    with pytest.raises(InputError, match="is not a valid choice"):
        slot(of="all")


class NoDefault(NamedTuple):
    k_H: Annotated[float, Variable("1", "rise", excitation="channel")]


class NothingToTell(NamedTuple):
    k_H: Annotated[float, Variable("1", "rise")] = 0.0


class OtherNeed(NamedTuple):
    k_H: Annotated[float, Variable("1", "rise", excitation="sliding")] = 0.0


@kernel
def of_one(c):
    return c


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"Parameters": NoDefault}, "has no default"),
        ({"Parameters": NothingToTell}, "no parameter to identify from a log"),
        ({"Parameters": OtherNeed}, "is not an excitation for a slot"),
        ({"factor": lambda c, p: 1.0}, "is not a kernel"),
        ({"factor": of_one}, r"takes 1 arguments.*factor\(channel, p\)"),
    ],
)
def test_invalid_slots_are_refused(changes, words):
    with pytest.raises(InputError, match=words):
        refuse_unfit(slot(**changes))


@pytest.mark.parametrize("name", ["v", "x", "dt", "p", "memory", "state", "motion", "force"])
def test_reserved_words_of_the_contract_are_not_names_of_channels(name):
    with pytest.raises(InputError, match="is not a valid name of a channel"):
        Surrounding(name, HUMID, 0.5)
    assert Surrounding(f"{name}_2", HUMID, 0.5).name == f"{name}_2"


class OfMany(NamedTuple):
    k_H: Annotated[np.ndarray, Variable("1", "rises", excitation="channel")] = np.zeros(2)


class OfChoices(NamedTuple):
    k_H: Annotated[int, Variable("1", "form", choices=("a", "b"), excitation="channel")] = 0


@pytest.mark.parametrize("parameters", [OfMany, OfChoices])
def test_a_slot_takes_numbers(parameters):
    with pytest.raises(InputError, match=r"Parameters\.k_H: is not a number"):
        refuse_unfit(slot(Parameters=parameters))


def test_a_slot_is_a_factor_of_all_friction_unless_it_is_of_the_level():
    assert (slot().of, slot(of="level").of, slot().family) == ("friction", "level", "slot")
    assert [slot(channel=name).channel.name for name in ("position", "load", "temperature")] == ["position", "load", "temperature"]
    for name in ("transmitted", "velocity", "time"):
        with pytest.raises(InputError, match="allowed load, temperature, position, or a further channel"):
            slot(channel=name)


def test_the_channels_of_bristle_keep_their_meaning():
    assert Surrounding("load", OF_MOTION["load"].variable, 1.0) == OF_MOTION["load"]
    assert {name: surrounding.usual for name, surrounding in OF_MOTION.items()} == {
        "load": 1.0,
        "temperature": 293.15,
        "transmitted": 0.0,
        "position": 0.0,
    }
    for name in ("velocity", "effort", "transmitted", "following_error"):
        with pytest.raises(InputError, match="is already the name of a channel of bristle"):
            Surrounding(name, HUMID, 0.5)
