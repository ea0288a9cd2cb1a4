"""Channels and what a log says of itself: steps of an encoder, the time between samples, which part of a file it is."""

from pathlib import Path

import numpy as np
import pytest

from bristle.core.content import Origin
from bristle.core.errors import InputError
from bristle.logs.channel import Channel, LogData, clear_step, quantisation

STEPS = np.array([0, 2, 3, 7, 8, 8, 5, 1])


def log_data(**passed):
    size = passed.pop("size", 5)
    time = Channel(passed.pop("time", 0.5 * np.arange(size)), "s", "t")
    position = Channel(np.arange(float(size)), "m", passed.pop("column", "q"))
    return LogData(time=time, position=position, **passed)


APART = np.array([0.0, 1.0, 31.0, 62.0, 93.0])


@pytest.mark.parametrize(
    ("call", "step"),
    [
        *(
            (lambda offset=offset: clear_step(offset + 0.1 * STEPS), pytest.approx(0.1, rel=1e-9))
            for offset in (0.0, 0.03, -40.07)
        ),
        (lambda: clear_step(np.append(0.03 + 0.1 * STEPS, np.nan)), pytest.approx(0.1, rel=1e-9)),
        (lambda: clear_step(np.array([0.0, 1.0, 2.0, 3.4])), 0.0),
        (lambda: clear_step(np.ones(6)), 0.0),
        (lambda: clear_step(APART), 0.0),
        (lambda: clear_step(APART, most=31.0), 1.0),
        # Rounding makes no step.
        (lambda: quantisation(np.array([1.0, 1.0 + 1e-15, 3.0])), pytest.approx(2.0)),
        (lambda: quantisation(np.array([2.0, 2.0])), 0.0),
        (lambda: quantisation(np.array([])), 0.0),
        (lambda: Channel(STEPS, "m", "q").step, 1.0),
        (lambda: Channel(STEPS, "m", "q", recorded_step=0.25).step, 0.25),
    ],
)
def test_the_step_of_an_encoder_is_clear_wherever_its_zero_lies(call, step):
    assert call() == step


def test_the_time_between_samples_is_the_usual_one_unless_given():
    assert log_data(time=np.array([0.0, 0.1, 0.2, 0.3, 0.9])).sample_time == pytest.approx(0.1)
    assert log_data(sample_time=0.2).sample_time == 0.2
    assert (log_data().segments, log_data().duration) == ((slice(0, 5),), pytest.approx(2.5))


@pytest.mark.parametrize("time", [[0.0, 0.1, 0.1, 0.2, 0.3], [0.4, 0.3, 0.2, 0.1, 0.0], [0.0]])
def test_the_time_increases_from_sample_to_sample(time):
    with pytest.raises(InputError, match="must increase"):
        log_data(time=np.array(time), size=len(time))


@pytest.mark.parametrize(
    ("part", "overlaps"),
    [
        ("columns q, u, 0 to 2 s", True),
        ("columns q, u, 2 to 9 s", True),
        ("columns q, u, -3 to 0 s", True),
        ("columns q, u, 2.5 to 9 s", False),
        ("columns q, u, -3 to -0.5 s", False),
        ("columns q, w, 0 to 2 s", False),
        ("the whole file", True),
    ],
)
def test_parts_of_a_file_overlap_where_columns_and_times_do(part, overlaps):
    log = log_data(effort=Channel(np.ones(5), "N", "u"))
    assert (log.part, log.is_part(part)) == ("columns q, u, 0 to 2 s", overlaps)


@pytest.mark.parametrize(
    ("passed", "name"),
    [
        ({}, ""),
        ({"source": Path("folder/a.csv")}, "a.csv"),
        ({"source": Path("folder/a.csv"), "origin": Origin("b.csv", "0" * 64)}, "b.csv"),
    ],
)
def test_a_log_is_called_as_its_origin_or_else_as_its_file(passed, name):
    log = log_data(**passed)
    assert str(log).splitlines()[0] == "Log of 5 samples, 2.5 s at 2 Hz, translational" + (
        f", from {name}" if name else ""
    )
    assert not name or log.to_dict()["source"] == name


def test_gaps_are_counted_by_the_segments_between_them():
    parted = log_data(segments=(slice(0, 2), slice(2, 5)))
    assert ["2 segments without a gap" in str(log) for log in (parted, log_data())] == [True, False]
    assert parted.to_dict()["segments"] == [[0, 2], [2, 5]]


def test_known_inputs_add_up_and_further_signals_surround_the_axis():
    pushed = (Channel(np.ones(5), "N", "a"), Channel(np.arange(5.0), "N", "b"))
    log = log_data(
        injected=pushed,
        load=Channel(np.full(5, 2.0), "1", "w"),
        further={"pressure": Channel(np.ones(5), "Pa", "p")},
    )
    assert np.array_equal(log.injected_effort, [1.0, 2.0, 3.0, 4.0, 5.0])
    assert np.array_equal(log_data().injected_effort, np.zeros(5))
    assert set(log.surroundings) == {"load", "pressure"}
    assert [name for name, _ in log.channels()] == [
        "time",
        "position",
        "load",
        "pressure",
        "injected.a",
        "injected.b",
    ]
    with pytest.raises(InputError, match="has more or fewer samples than time"):
        log_data(effort=Channel(np.ones(4), "N", "u"))
