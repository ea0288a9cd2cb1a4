"""Channels of a log that friction depends on, and slots over them."""

from typing import Annotated, NamedTuple

import numpy as np
import pytest

from bristle.core.errors import InputError
from bristle.core.kernel import kernel
from bristle.core.motion import Motion
from bristle.core.slot import Slot, refuse_unfit
from bristle.core.surroundings import (
    OF_MOTION,
    Surrounding,
    at_rest,
    motion_with,
    on_side,
    reader_of,
)
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
    parts = {
        "name": "humid",
        "description": "rises",
        "Parameters": Parameters,
        "channel": HUMIDITY,
        "factor": factor,
    }
    return Slot(**parts | changes)


RESERVED = ("v", "x", "dt", "p", "memory", "state", "motion", "force")


@pytest.mark.parametrize(
    ("name", "variable", "usual", "words"),
    [
        *(
            (name, HUMID, 0.5, "is not a valid name of a channel")
            for name in ("", "a b", "class", "_x", "größe", "1x", 3, *RESERVED)
        ),
        *(
            (name, HUMID, 0.5, "is already the name of a channel of bristle")
            for name in ("load", "velocity", "effort", "transmitted", "following_error")
        ),
        ("humidity", HUMID, 1.5, "usual value of humidity"),
        ("humidity", "1", 0.5, "needs a Variable"),
    ],
)
def test_a_channel_has_a_new_valid_name_and_a_usual_value_within_its_range(
    name, variable, usual, words
):
    with pytest.raises(InputError, match=words):
        Surrounding(name, variable, usual)


def test_a_channel_may_be_named_like_a_reserved_word_with_more():
    assert [Surrounding(f"{name}_2", HUMID, 0.5).name for name in RESERVED] == [
        f"{name}_2" for name in RESERVED
    ]


@pytest.mark.parametrize(
    ("channel", "field", "is_own", "is_recorded"),
    [
        (HUMIDITY, "humidity", True, True),
        (OF_MOTION["load"], "load", False, True),
        (OF_MOTION["position"], "x", False, False),
        (OF_MOTION["transmitted"], "transmitted", False, False),
    ],
)
def test_required_channels_besides_the_motion_are_listed(channel, field, is_own, is_recorded):
    assert (channel.field, channel.is_own, channel.is_recorded) == (field, is_own, is_recorded)


def test_a_motion_has_each_requested_channel_once():
    assert motion_with([OF_MOTION["load"]]) is Motion
    wider = motion_with([HUMIDITY, OF_MOTION["load"], HUMIDITY])
    assert wider._fields == (*Motion._fields, "humidity")
    assert wider(1.0, 2.0).humidity == 0.5


MOVING = motion_with([HUMIDITY])(3.0, 2.0, 1.5, 300.0, 7.0, 0.9)


def test_only_a_moving_axis_transmits_effort():
    assert at_rest(-0.0, MOVING) == (0.0, 2.0, 1.5, 300.0, 0.0, 0.9)
    assert on_side(-0.0, MOVING) == (0.0, 2.0, 1.5, 300.0, 7.0, 0.9)


@pytest.mark.parametrize(
    ("channel", "motion", "value"),
    [
        (HUMIDITY, MOVING, 0.9),
        (HUMIDITY, Motion(3.0, 2.0), 0.5),
        (OF_MOTION["position"], MOVING, 2.0),
    ],
)
def test_a_channel_is_read_from_a_motion_or_has_its_usual_value(channel, motion, value):
    assert reader_of(channel)(motion) == value


def test_a_slot_lists_its_identified_parameters():
    assert slot().identified == ("k_H",)
    assert slot().neutral == (0.0, 0.5)
    refuse_unfit(slot())


class NoDefault(NamedTuple):
    k_H: Annotated[float, Variable("1", "rise", excitation="channel")]


class NothingToTell(NamedTuple):
    k_H: Annotated[float, Variable("1", "rise")] = 0.0


class OtherNeed(NamedTuple):
    k_H: Annotated[float, Variable("1", "rise", excitation="sliding")] = 0.0


@kernel
def of_one(c):
    return c


class OfMany(NamedTuple):
    k_H: Annotated[np.ndarray, Variable("1", "rises", excitation="channel")] = np.zeros(2)


class OfChoices(NamedTuple):
    k_H: Annotated[int, Variable("1", "form", choices=("a", "b"), excitation="channel")] = 0


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"Parameters": NoDefault},
            r"Parameters\.k_H: has no default\. Give each parameter a default",
        ),
        ({"Parameters": NothingToTell}, "no parameter to identify from a log"),
        ({"Parameters": OtherNeed}, "is not an excitation for a slot"),
        ({"Parameters": OfMany}, r"Parameters\.k_H: is not a number"),
        ({"Parameters": OfChoices}, r"Parameters\.k_H: is not a number"),
        ({"factor": lambda c, p: 1.0}, "is not a kernel"),
        ({"factor": of_one}, r"takes 1 arguments.*factor\(channel, p\)"),
        ({"channel": "wind"}, "is not a channel of a log"),
        *(
            ({"channel": name}, "allowed load, temperature, position, or a further channel")
            for name in ("transmitted", "velocity", "time")
        ),
        ({"of": "all"}, "is not a valid choice"),
    ],
)
def test_invalid_slots_are_refused(changes, words):
    with pytest.raises(InputError, match=words):
        refuse_unfit(slot(**changes))


def test_a_slot_is_a_factor_of_all_friction_unless_it_is_of_the_level():
    assert (slot().of, slot(of="level").of, slot().family) == ("friction", "level", "slot")
    assert [slot(channel=name).channel for name in OF_MOTION if name != "transmitted"] == [
        OF_MOTION[name] for name in OF_MOTION if name != "transmitted"
    ]


def test_the_channels_of_bristle_keep_their_meaning():
    assert Surrounding("load", OF_MOTION["load"].variable, 1.0) == OF_MOTION["load"]
    usual = {"load": 1.0, "temperature": 293.15, "transmitted": 0.0, "position": 0.0}
    assert {name: surrounding.usual for name, surrounding in OF_MOTION.items()} == usual
