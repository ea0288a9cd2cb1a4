"""Gravity of a link, cogging and known columns are recovered from simulated logs."""

import numpy as np
import pytest

from bristle import identify
from bristle.core import InputError
from bristle.files import read_model, write_model
from bristle.files.axis import read_axis
from bristle.logs.log import Log
from bristle.plants import inertia
from bristle.plants.terms import effort_of_columns, with_terms

pytestmark = pytest.mark.usefixtures("of_one_mass")

RATE = 1000.0
COLUMNS = {"time": {"column": "t", "unit": "s"}, "position": {"column": "q"}, "effort": {"column": "u"}}
SCREW = {"lead": "5 mm", "gear_ratio": 2.0}
MOTOR_TURN = 2.5e-3


def axis(kind="rotational", **tables):
    units = {"rotational": ("rad", "N*m"), "translational": ("m", "N")}[kind]
    columns = {name: dict(column) for name, column in COLUMNS.items()}
    columns["position"]["unit"], columns["effort"]["unit"] = units
    stated = {"timing": {"delay": 0}, "identification": {"cutoff": "100 Hz"}}
    return read_axis({"schema": 1, "kind": kind, "columns": columns} | stated | tables)


def swing(seconds, amplitude, slowest, seed=0):
    """A sum of sines, its velocity and acceleration, on the time of a log."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(seconds * RATE)) / RATE
    q, v, a = np.zeros((3, t.size))
    for share, factor in ((0.7, 1.0), (0.2, 2.7), (0.1, 5.3)):
        w, phase = 2.0 * np.pi * slowest * factor, rng.uniform(0.0, 2.0 * np.pi)
        q += amplitude * share * np.sin(w * t + phase)
        v += amplitude * share * w * np.cos(w * t + phase)
        a -= amplitude * share * w * w * np.sin(w * t + phase)
    return t, q, v, a


def arm(mass, seed=0, seconds=12.0):
    """A log of an arm that hangs 0.3 rad off its zero: inertia, gravity, friction and noise, in numpy alone."""
    t, q, v, a = swing(seconds, 1.4, 0.3, seed)
    noise = 1e-3 * np.random.default_rng(seed).standard_normal(t.size)
    u = 0.02 * mass * a + 0.9 * mass * np.sin(q - 0.3) + 0.15 * np.sign(v) + 0.02 * v + noise
    return {"t": t, "q": q, "u": u}


def identified(columns, described, model="coulomb_viscous", **options):
    return identify(Log.from_columns(columns, axis=described), model, axis=described, draws=0, **options)


@pytest.fixture(scope="module")
def light():
    return identified(arm(1.0, 1), axis(plant={"gravity": "link"}), blocks=0).best


def test_two_coefficients_describe_gravity_of_a_link_at_any_angle(light):
    heavy = identified(arm(2.0, 2), axis(plant={"gravity": "link"}), blocks=0).best
    assert light.plant.name == "inertia+gravity"
    values = light.plant.values
    assert values["g_sin"] == pytest.approx(0.9 * np.cos(0.3), rel=0.01)
    assert values["g_cos"] == pytest.approx(-0.9 * np.sin(0.3), rel=0.02)
    amplitudes = [np.hypot(fit.plant.values["g_sin"], fit.plant.values["g_cos"]) for fit in (light, heavy)]
    assert amplitudes[1] / amplitudes[0] == pytest.approx(2.0, rel=0.01)
    assert heavy.friction.values["F_C"] == pytest.approx(0.15, rel=0.03)


def test_without_the_term_gravity_remains_in_the_residual(light):
    assert identified(arm(1.0, 1), axis(plant={}), blocks=0).best.error_percent > 20.0 * light.error_percent


def test_a_model_with_terms_is_written_and_read(tmp_path, light):
    write_model(tmp_path / "model.toml", light.plant, light.friction)
    assert read_model(tmp_path / "model.toml").plant == light.plant
    assert 'model = "inertia+gravity"' in (tmp_path / "model.toml").read_text()


def screw(even, odd, seconds=12.0):
    """A log of a screw with friction and with cogging of the motor, six and twelve times a turn."""
    t, q, v, a = swing(seconds, 0.03, 0.15, 3)
    angle = 2.0 * np.pi * q / MOTOR_TURN
    u = 12.0 * a + (15.0 + odd * np.sin(0.5 * angle + 0.7)) * np.sign(v) + 40.0 * v
    u += even * np.cos(6.0 * angle - 0.4) + 0.5 * even * np.sin(12.0 * angle)
    return {"t": t, "q": q, "u": u + 0.05 * np.random.default_rng(4).standard_normal(t.size)}


def amplitude(fit, order, turner="motor"):
    values = fit.plant.values
    return np.hypot(values[f"{turner}_{order}_cos"], values[f"{turner}_{order}_sin"])


@pytest.mark.slow
def test_cogging_is_found_with_its_harmonics():
    best = identified(screw(1.0, 0.0, 30.0), axis("translational", transmission=SCREW, cogging=[{"turn": "motor"}])).best
    assert best.plant.component.orders == (("motor", 6), ("motor", 12))
    assert amplitude(best, 6) == pytest.approx(1.0, rel=0.05)
    assert amplitude(best, 12) == pytest.approx(0.5, rel=0.05)
    assert best.friction.values["F_C"] == pytest.approx(15.0, rel=0.01)


def test_absent_cogging_is_not_found():
    with pytest.raises(InputError, match="no part of the effort in this log repeats with the motor"):
        identified(screw(0.0, 0.0, 5.0), axis("translational", transmission=SCREW, cogging=[{"turn": "motor"}]))


def test_harmonics_in_less_than_one_and_a_half_turns_are_rejected():
    columns = screw(0.0, 0.0)
    with pytest.raises(InputError, match=r"need 1\.5 turns of the motor, but the log has 0\.\d+ turns; .* record more turns"):
        identified(columns | {"q": 0.02 * columns["q"]}, axis("translational", transmission=SCREW, cogging=[{"turn": "motor"}]))


@pytest.mark.slow
def test_a_wave_with_one_sample_a_period_is_not_a_harmonic():
    # Of a linear motor with a pitch of 24 mm on strokes at 0.2 m/s, each longer than the last: 0.2 mm from sample to
    # sample are the 120th part of the pitch.
    ends = np.cumsum([0.0, *((-1.0) ** n * (0.1 + 0.0237 * n) for n in range(20))])
    turns = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(ends)) / 0.2)])
    t = np.arange(round(turns[-1] * RATE)) / RATE
    q = np.convolve(np.pad(np.interp(t, turns, ends), 40, mode="edge"), np.hanning(81) / np.hanning(81).sum(), "valid")
    v = np.gradient(q, t)
    angle = 2.0 * np.pi * q / 0.024
    u = 12.0 * np.gradient(v, t) + 9.0 * np.sign(v) + 40.0 * v + 6.0 * np.sin(angle) + 3.0 * np.cos(2.0 * angle)
    u += 20.0 * q + 30.0 * q**2 + 0.1 * np.random.default_rng(4).standard_normal(t.size)
    linear = axis("translational", transmission={"lead": "24 mm"}, cogging=[{"turn": "motor"}])
    best = identified({"t": t, "q": q, "u": u}, linear, blocks=0).best
    orders = {order for _, order in best.plant.component.orders}
    assert {1, 2} <= orders
    assert max(orders) < 10


def test_cogging_of_motor_and_screw_are_identified_together():
    both = [{"turn": "motor", "harmonics": [6, 12]}, {"turn": "screw", "harmonics": [3]}]
    columns = screw(1.0, 0.0)
    columns["u"] = columns["u"] + 0.8 * np.cos(2.0 * np.pi * 3.0 * columns["q"] / 5e-3)
    best = identified(columns, axis("translational", transmission=SCREW, cogging=both), blocks=0).best
    assert best.plant.values["screw_turn"] == pytest.approx(5e-3)
    assert amplitude(best, 6) == pytest.approx(1.0, rel=0.05)
    assert best.plant.values["screw_3_cos"] == pytest.approx(0.8, rel=0.05)


def test_a_known_column_has_its_coefficient():
    columns = screw(0.0, 0.0, seconds=10.0)
    pull = np.cumsum(np.random.default_rng(5).standard_normal(columns["t"].size)) / 50.0
    columns |= {"u": columns["u"] + 2.5 * pull, "belt force": pull}
    named = axis("translational", known=[{"column": "belt force"}])
    best = identified(columns, named, blocks=0).best
    assert best.plant.values["known_belt_force"] == pytest.approx(2.5, rel=0.01)
    assert identified(columns, axis("translational"), blocks=0).best.error_percent > 2.0 * best.error_percent


def test_a_log_with_other_known_columns_than_the_plant_is_rejected():
    pulled = with_terms(inertia, columns=["belt"])(M=1.0, known_belt=2.0)
    assert effort_of_columns(pulled, np.ones((1, 3))) == pytest.approx(2.0)
    with pytest.raises(InputError, match=r"known columns for the plant; found '2 columns', allowed belt"):
        effort_of_columns(pulled, np.ones((2, 3)))


@pytest.mark.parametrize(
    ("kind", "tables", "told"),
    [
        ("translational", {"plant": {"gravity": "link"}}, "translational"),
        ("rotational", {"cogging": [{"turn": "motor"}, {"turn": "motor", "harmonics": [6]}]}, "twice"),
    ],
)
def test_impossible_terms_are_rejected(kind, tables, told):
    with pytest.raises(InputError, match=told):
        axis(kind, **tables)
