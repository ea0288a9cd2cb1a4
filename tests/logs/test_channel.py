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


@pytest.mark.parametrize("offset", [0.0, 0.03, -40.07])
def test_the_step_of_an_encoder_is_clear_wherever_its_zero_lies(offset):
    assert clear_step(offset + 0.1 * STEPS) == pytest.approx(0.1, rel=1e-9)
    assert clear_step(np.append(offset + 0.1 * STEPS, np.nan)) == pytest.approx(0.1, rel=1e-9)


def test_no_step_is_clear_between_values_that_are_no_multiples_or_far_apart():
    assert clear_step(np.array([0.0, 1.0, 2.0, 3.4])) == 0.0
    assert clear_step(np.ones(6)) == 0.0
    apart = np.array([0.0, 1.0, 31.0, 62.0, 93.0])
    assert clear_step(apart) == 0.0
    assert clear_step(apart, most=31.0) == 1.0


def test_rounding_makes_no_step():
    assert quantisation(np.array([1.0, 1.0 + 1e-15, 3.0])) == pytest.approx(2.0)
    assert quantisation(np.array([2.0, 2.0])) == quantisation(np.array([])) == 0.0
    assert Channel(STEPS, "m", "q").step == 1.0
    assert Channel(STEPS, "m", "q", recorded_step=0.25).step == 0.25


def test_the_time_between_samples_is_the_usual_one_unless_given():
    assert log_data(time=np.array([0.0, 0.1, 0.2, 0.3, 0.9])).sample_time == pytest.approx(0.1)
    assert log_data(sample_time=0.2).sample_time == 0.2
    assert log_data().segments == (slice(0, 5),)
    assert log_data().duration == pytest.approx(2.5)
    for time in (np.array([0.0, 0.1, 0.1, 0.2, 0.3]), np.array([0.4, 0.3, 0.2, 0.1, 0.0])):
        with pytest.raises(InputError, match="must increase from sample to sample"):
            log_data(time=time)
    with pytest.raises(InputError, match="must increase"):
        log_data(size=1)


def test_parts_of_a_file_overlap_where_columns_and_times_do():
    log = log_data(effort=Channel(np.ones(5), "N", "u"))
    assert log.part == "columns q, u, 0 to 2 s"
    assert log.is_part(log.part)
    assert log.is_part("columns q, u, 2 to 9 s")
    assert log.is_part("columns q, u, -3 to 0 s")
    assert not log.is_part("columns q, u, 2.5 to 9 s")
    assert not log.is_part("columns q, u, -3 to -0.5 s")
    assert not log.is_part("columns q, w, 0 to 2 s")
    assert log.is_part("the whole file")


def test_a_log_is_called_as_its_origin_or_else_as_its_file():
    first_line = lambda log: str(log).splitlines()[0]  # noqa: E731
    assert first_line(log_data()) == "Log of 5 samples, 2.5 s at 2 Hz, translational"
    assert first_line(log_data(source=Path("folder/a.csv"))).endswith("translational, from a.csv")
    named = log_data(source=Path("folder/a.csv"), origin=Origin("b.csv", "0" * 64))
    assert first_line(named).endswith("translational, from b.csv")
    assert named.to_dict()["source"] == "b.csv"
    assert log_data(source=Path("folder/a.csv")).to_dict()["source"] == "a.csv"


def test_gaps_are_counted_by_the_segments_between_them():
    assert "2 segments without a gap" in str(log_data(segments=(slice(0, 2), slice(2, 5))))
    assert "segments without a gap" not in str(log_data())
    assert log_data(segments=(slice(0, 2), slice(2, 5))).to_dict()["segments"] == [[0, 2], [2, 5]]


def test_known_inputs_add_up_and_further_signals_surround_the_axis():
    pushed = (Channel(np.ones(5), "N", "a"), Channel(np.arange(5.0), "N", "b"))
    log = log_data(injected=pushed, load=Channel(np.full(5, 2.0), "1", "w"), further={"pressure": Channel(np.ones(5), "Pa", "p")})
    assert np.array_equal(log.injected_effort, [1.0, 2.0, 3.0, 4.0, 5.0])
    assert np.array_equal(log_data().injected_effort, np.zeros(5))
    assert set(log.surroundings) == {"load", "pressure"}
    assert [name for name, _ in log.channels()] == ["time", "position", "load", "pressure", "injected.a", "injected.b"]
    with pytest.raises(InputError, match="has more or fewer samples than time"):
        log_data(effort=Channel(np.ones(4), "N", "u"))
