"""The table of a loop, and the experiment file beside a model: read back as written, and gains that an axis bears."""

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bristle import controllers, friction, plants, references, sensors
from bristle.core.axis import Axis
from bristle.core.content import Content
from bristle.core.errors import InputError
from bristle.core.experiment import Feedforward, Run, Variant
from bristle.files.experiment_text import LoopRecord, NextExperiment, kind_of_loop, read_loop
from bristle.logs.log import Log
from bristle.models.controllers.feedforward import Rule

HEAD = "time [s],reference [m],unexplained [N]"


def content(*rows, head=HEAD):
    """A file that holds these rows below a head."""
    return Content(Path("loop.csv"), "\n".join([head, *rows, ""]).encode())


def times(*stamps):
    """A table with these stamps."""
    return content(*(f"{stamp!r},0.0,1.0" for stamp in stamps))


@pytest.mark.parametrize("kind", ["translational", "rotational"])
@pytest.mark.parametrize("injected", [None, np.array([0.0, 2.0, -2.0, 1.0])])
def test_a_loop_survives_a_round_trip(kind, injected):
    record = LoopRecord(
        kind, 2.5e-4, np.array([0.1, 0.2, -0.3, 0.0]), np.array([1.0, -2.0, 3.5, 0.0]), injected
    )
    text = record.text
    length, force = ("m", "N") if kind == "translational" else ("rad", "N*m")
    head = f"time [s],reference [{length}],unexplained [{force}]" + (
        "" if injected is None else f",injected [{force}]"
    )
    assert text.splitlines()[0] == head
    assert [float(row.split(",")[0]) for row in text.splitlines()[1:]] == pytest.approx(
        [0.0, 2.5e-4, 5e-4, 7.5e-4]
    )
    again = read_loop(Content(Path("loop.csv"), text.encode()))
    assert (again.kind, again.sample_time) == (kind, pytest.approx(2.5e-4))
    for name in ("reference", "unexplained", "injected"):
        values = getattr(record, name)
        assert getattr(again, name) == (None if values is None else pytest.approx(values))


OTHER = content("0,0,0", "1,0,0", "2,0,0", head="time [s],position [m],effort [N]")
FINITE = "needs a finite number in each column and at least three rows"


def test_the_head_names_the_kind_of_axis():
    assert (kind_of_loop(times(0.0, 1.0, 2.0)), kind_of_loop(OTHER)) == ("translational", None)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        (
            OTHER,
            r"is not a table of the loop of a log; allowed columns: time \[s\],reference \[m\]",
        ),
        (content("0,0,0"), FINITE),
        (content("0,0,0", "1,0,0"), FINITE),
        (content("0,0,0", "1,nan,0", "2,0,0"), FINITE),
        (content("0,0,0", "1,0,inf", "2,0,0"), FINITE),
        (content("0,0,0,0", "1,0,0,0", "2,0,0,0"), FINITE),
        (content("0,0", "1,0", "2,0"), FINITE),
        (content("0,0,0", "1,0,0", "2,0,0", head=f"{HEAD},injected [N]"), FINITE),
        (content("0,0,0", "1,a,0", "2,0,0"), "cannot be read"),
        # Samples are even and rise.
        (times(0.0, 1.0, 2.00001, 3.0), "has unevenly spaced samples"),
        (times(3.0, 2.0, 1.0, 0.0), "has unevenly spaced samples"),
        (times(1.0, 1.0, 1.0), "has unevenly spaced samples"),
        (times(0.0, 0.0, 2.0), "has unevenly spaced samples"),
    ],
)
def test_a_table_that_is_no_loop_is_refused(table, words):
    with pytest.raises(InputError, match=words):
        read_loop(table)


def test_decimals_of_stamps_leave_a_loop_even():
    assert read_loop(times(0.0, 1.0, 2.0000001, 3.0)).sample_time == pytest.approx(1.0)
    # A hundred-thousandth of a stamp's last digits.
    late = [1e6 + 1e-6 * k + 3e-6 * (k == 2) for k in range(40)]
    assert read_loop(times(*late)).sample_time == pytest.approx(1e-6, rel=0.01)


def log_of(frequency=1.0, amplitude=0.02, offset=0.1, dt=1e-3, count=4000, **more):
    """A log of a sine whose position is known."""
    time = dt * np.arange(count)
    position = offset + amplitude * np.sin(2.0 * np.pi * frequency * time)
    return Log(time=time, position=position, effort=np.cos(time), sample_time=dt, **more)


def following(log, axis=None, mass=3.0, folder=Path(), *, has_axis_file=True):
    """The experiment beside a model of so much mass, with its tables."""
    plant = plants.inertia(M=mass)
    result = NextExperiment.beside_model(
        plant, axis or Axis(), log, folder, has_axis_file=has_axis_file
    )
    return result, tomllib.loads(result.text)


FAST = 2.0 * np.pi * 20.0  # of a velocity loop; that of the position is four times slower


@pytest.mark.parametrize(
    ("dt", "mass", "bandwidth"), [(1e-4, 3.0, FAST), (1e-4, 6.0, FAST), (2e-3, 3.0, 50.0)]
)
def test_suggested_gains_are_limited_to_20_hz_and_a_tenth_of_the_sampling(dt, mass, bandwidth):
    lines = following(log_of(dt=dt), mass=mass)[0].text.splitlines()
    gains = [
        float(line.rpartition('such as "')[2].split()[0])
        for line in lines
        if line.startswith(("k_p", "k_v"))
    ]
    assert gains == pytest.approx([0.25 * bandwidth, mass * bandwidth], rel=5e-3)


def test_unknown_gains_must_be_filled_in():
    result, tables = following(log_of())
    assert result.missing == ("controller.k_p", "controller.k_v")
    assert (tables["controller"]["k_p"], tables["controller"]["k_v"]) == ("?", "?")
    known, tables = following(log_of(), Axis(controller=controllers.cascade(k_p=10.0, k_v=200.0)))
    assert (known.missing, known.loop, "controller" in tables) == ((), None, False)


def loop_of(injected=None):
    """A loop as an identification finds it: half a second of a reference, and what is known of its efforts."""
    reference = references.recorded(position=0.01 * np.arange(500.0), sample_time=1e-3)
    contact, law = friction.coulomb(F_C=1.0), controllers.cascade(k_p=10.0, k_v=200.0)
    run, plain = Run(0.499, 1e-3, settle=0.1), Feedforward()
    return Variant(
        "loop",
        plants.inertia(M=3.0),
        contact,
        law,
        sensors.encoder(resolution=0.0),
        reference,
        plain,
        run,
        injected=injected,
    )


def test_a_known_input_of_a_loop_is_replayed():
    log, plant = log_of(), plants.inertia(M=3.0)
    options = {"has_axis_file": True, "loop": loop_of()}
    alone = NextExperiment.beside_model(plant, Axis(), log, Path(), **options, rule=Rule(0.9, 5e-6))
    pushed = NextExperiment.beside_model(
        plant, Axis(), log, Path(), **options | {"loop": loop_of(np.ones(500))}
    )
    assert "injected" not in tomllib.loads(alone.text)
    assert (
        'gain = 0.9, scaled = "contact", return_distance = "5e-06 m", fade_time = "0.5 s" }'
        in alone.text
    )
    assert tomllib.loads(pushed.text)["injected"] == {"file": "loop.csv"}


def test_variants_feed_forward_inertia_and_then_friction():
    _, tables = following(log_of(), Axis(name="stage"), mass=3.0)
    fed = {"mass": "3 kg", "plant": "own"}
    assert list(tables["compare"].values()) == [
        {},
        {"controller": {"k_ff": 1.0, "feedforward": fed}},
        {"controller": {"k_ff": 1.0, "feedforward": fed | {"friction": {"file": "model.toml"}}}},
    ]
    assert tables["name"] == "stage, without and with compensation"


def test_the_experiment_states_the_kind_without_an_axis_file():
    assert "axis" in following(log_of())[1]
    tables = following(log_of(), has_axis_file=False)[1]
    assert (tables["kind"], "axis" in tables) == ("translational", False)


@pytest.mark.parametrize(
    ("frequency", "amplitude", "offset"), [(1.0, 0.02, 0.1), (2.5, 0.004, -0.3)]
)
def test_a_log_without_a_reference_is_followed_by_a_sine_of_its_range_and_speed(
    frequency, amplitude, offset
):
    _, tables = following(log_of(frequency, amplitude, offset))
    numbers = {
        key: float(text.split()[0])
        for table in ("reference", "run")
        for key, text in tables[table].items()
        if key != "model"
    }
    assert numbers == {
        "amplitude": pytest.approx(amplitude, rel=1e-3),
        "offset": pytest.approx(offset, abs=1e-3 * amplitude),
        # 95 % of the speeds are below 0.997 of the largest
        "frequency": pytest.approx(frequency, rel=0.01),
        "sample_time": 1e-3,
        "duration": pytest.approx(4.0 / frequency, rel=0.01),
        "settle": pytest.approx(1.0 / frequency, rel=0.01),
    }


@pytest.mark.parametrize(("count", "settle"), [(4000, 0.2), (9000, 0.45), (12_000, 0.5)])
def test_a_recorded_reference_settles_for_a_twentieth_of_the_log_and_half_a_second_at_most(
    tmp_path, count, settle
):
    source = tmp_path / "log" / "a.csv"
    source.parent.mkdir()
    source.write_text("")
    log = replace(log_of(count=count, reference=np.zeros(count)), source=source)
    _, tables = following(log, folder=tmp_path / "out")
    assert (tables["reference"], tables["run"]) == (
        {"model": "recorded", "file": "../log/a.csv"},
        {"settle": f"{settle:.3g} s"},
    )
    parted = replace(log, segments=(slice(0, 2000), slice(2000, count)))
    assert following(parted, folder=tmp_path / "out")[1]["reference"]["model"] == "sine"
    assert (
        following(replace(log, reference=None), folder=tmp_path / "out")[1]["reference"]["model"]
        == "sine"
    )
