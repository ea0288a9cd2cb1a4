"""Gravity, springs, cogging, known columns, and friction that rises with the transmitted effort."""

import numpy as np
import pytest
from tests.identification.known_logs import sines
from tests.identification.rigid import identify
from tests.simulation import transmitted_truth as truth

import bristle as br
from bristle import friction
from bristle.core import Axis, InputError
from bristle.files import axis_text, read_axis, read_model, write_model
from bristle.files.axis import axis_from
from bristle.identification import request, simulated_bands
from bristle.identification.preprocessing import treat_all
from bristle.logs import Log
from bristle.logs.check import checked
from bristle.models.friction.next_model import model_with
from bristle.models.plants import inertia, with_terms
from bristle.models.plants.terms import effort_of_columns
from bristle.report.messages import message

RATE = 1000.0
COLUMNS = {
    "time": {"column": "t", "unit": "s"},
    "position": {"column": "q"},
    "effort": {"column": "u"},
}
SCREW = {"lead": "5 mm", "gear_ratio": 2.0}
MOTOR_TURN = 2.5e-3


def axis(kind="rotational", **tables):
    units = {"rotational": ("rad", "N*m"), "translational": ("m", "N")}[kind]
    columns = {name: dict(column) for name, column in COLUMNS.items()}
    columns["position"]["unit"], columns["effort"]["unit"] = units
    stated = {"timing": {"delay": 0}, "identification": {"cutoff": "100 Hz"}}
    return read_axis({"schema": 1, "kind": kind, "columns": columns} | stated | tables)


def swing(seconds, amplitude, slowest, seed=0):
    """A sum of sines of random phases."""
    phases = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, 3)
    return sines(
        seconds,
        1.0 / RATE,
        amplitude * np.array([0.7, 0.2, 0.1]),
        slowest * np.array([1.0, 2.7, 5.3]),
        phases,
    )


def arm(mass, seed=0, seconds=12.0):
    """A log of an arm that hangs 0.3 rad off its zero: inertia, gravity, friction and noise, in numpy alone."""
    t, q, v, a = swing(seconds, 1.4, 0.3, seed)
    noise = 1e-3 * np.random.default_rng(seed).standard_normal(t.size)
    u = 0.02 * mass * a + 0.9 * mass * np.sin(q - 0.3) + 0.15 * np.sign(v) + 0.02 * v + noise
    return {"t": t, "q": q, "u": u}


def identified(columns, described, model="coulomb_viscous", **options):
    return identify(
        Log.from_columns(columns, axis=described), model, axis=described, draws=0, **options
    )


@pytest.fixture(scope="module")
def light():
    return identified(arm(1.0, 1), axis(plant={"gravity": "link"}), blocks=0).best


def test_two_coefficients_describe_gravity_of_a_link_at_any_angle(light):
    heavy = identified(arm(2.0, 2), axis(plant={"gravity": "link"}), blocks=0).best
    assert light.plant.name == "inertia+gravity"
    values = light.plant.values
    assert values["g_sin"] == pytest.approx(0.9 * np.cos(0.3), rel=0.01)
    assert values["g_cos"] == pytest.approx(-0.9 * np.sin(0.3), rel=0.02)
    amplitudes = [
        np.hypot(fit.plant.values["g_sin"], fit.plant.values["g_cos"]) for fit in (light, heavy)
    ]
    assert amplitudes[1] / amplitudes[0] == pytest.approx(2.0, rel=0.01)
    assert heavy.friction.values["F_C"] == pytest.approx(0.15, rel=0.03)


def test_gravity_that_the_axis_omits_is_found(light):
    best = identified(arm(1.0, 1), axis(plant={}), blocks=0).best
    assert best.plant.name == light.plant.name
    assert best.error_percent == pytest.approx(light.error_percent, rel=1e-3)


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
    best = identified(
        screw(1.0, 0.0, 30.0),
        axis("translational", transmission=SCREW, cogging=[{"turn": "motor"}]),
    ).best
    assert best.plant.component.orders == (("motor", 6), ("motor", 12))
    assert amplitude(best, 6) == pytest.approx(1.0, rel=0.05)
    assert amplitude(best, 12) == pytest.approx(0.5, rel=0.05)
    assert best.friction.values["F_C"] == pytest.approx(15.0, rel=0.01)


@pytest.mark.slow
def test_absent_cogging_is_not_found():
    with pytest.raises(
        InputError, match="no part of the effort in this log repeats with the motor"
    ):
        identified(
            screw(0.0, 0.0, 5.0),
            axis("translational", transmission=SCREW, cogging=[{"turn": "motor"}]),
        )


def test_harmonics_in_less_than_one_and_a_half_turns_are_rejected():
    columns = screw(0.0, 0.0)
    with pytest.raises(
        InputError,
        match=r"need 1\.5 turns of the motor, but the log has 0\.\d+ turns; .* record more turns",
    ):
        identified(
            columns | {"q": 0.02 * columns["q"]},
            axis("translational", transmission=SCREW, cogging=[{"turn": "motor"}]),
        )


@pytest.mark.slow
def test_a_wave_with_one_sample_a_period_is_not_a_harmonic():
    # Of a linear motor with a pitch of 24 mm on strokes at 0.2 m/s, each longer than the last: 0.2 mm from sample to
    # sample are the 120th part of the pitch.
    ends = np.cumsum([0.0, *((-1.0) ** n * (0.1 + 0.0237 * n) for n in range(20))])
    turns = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(ends)) / 0.2)])
    t = np.arange(round(turns[-1] * RATE)) / RATE
    q = np.convolve(
        np.pad(np.interp(t, turns, ends), 40, mode="edge"),
        np.hanning(81) / np.hanning(81).sum(),
        "valid",
    )
    v = np.gradient(q, t)
    angle = 2.0 * np.pi * q / 0.024
    u = (
        12.0 * np.gradient(v, t)
        + 9.0 * np.sign(v)
        + 40.0 * v
        + 6.0 * np.sin(angle)
        + 3.0 * np.cos(2.0 * angle)
    )
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
    best = identified(
        columns, axis("translational", transmission=SCREW, cogging=both), blocks=0
    ).best
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
    assert (
        identified(columns, axis("translational"), blocks=0).best.error_percent
        > 2.0 * best.error_percent
    )


def test_a_log_with_other_known_columns_than_the_plant_is_rejected():
    pulled = with_terms(inertia, columns=["belt"])(M=1.0, known_belt=2.0)
    assert effort_of_columns(pulled, np.ones((1, 3))) == pytest.approx(2.0)
    with pytest.raises(
        InputError, match=r"known columns for the plant; found '2 columns', allowed belt"
    ):
        effort_of_columns(pulled, np.ones((2, 3)))


@pytest.mark.parametrize(
    ("kind", "tables", "told"),
    [
        ("translational", {"plant": {"gravity": "link"}}, "translational"),
        (
            "rotational",
            {"cogging": [{"turn": "motor"}, {"turn": "motor", "harmonics": [6]}]},
            "twice",
        ),
    ],
)
def test_impossible_terms_are_rejected(kind, tables, told):
    with pytest.raises(InputError, match=told):
        axis(kind, **tables)


ARM = axis(plant={"gravity": "link"}, identification={"decimation": 10, "cutoff": "100 Hz"})
RIPPLED = axis(
    "translational",
    timing={},
    transmission={"lead": "5 mm"},
    identification={"decimation": 4},
    cogging=[{"turn": "motor", "harmonics": [1, 6]}],
)
SLOTTED = ("coulomb_viscous", "coulomb_viscous+transmitted")


def held_out(fit):
    assert fit.held_out is not None
    return fit.held_out.mean_percent


@pytest.fixture(scope="module")
def geared():
    """Fits with the slot and without it, to friction that rises with the transmitted effort."""
    fits = identified(truth.log(seconds=12.0), ARM, list(SLOTTED), blocks=2).fits
    return {fit.name: fit for fit in fits}


def test_friction_of_a_gear_rises_with_the_transmitted_effort(geared):
    with_slot, without = geared["coulomb_viscous+transmitted"], geared["coulomb_viscous"]
    assert with_slot.rank == 1
    assert held_out(without) > 2.0 * held_out(with_slot)
    values = with_slot.friction.values
    assert values["c_T"] == pytest.approx(truth.SHARE, rel=0.03)
    assert values["F_C"] == pytest.approx(truth.F_C, rel=0.03)
    assert with_slot.plant.values["g_sin"] == pytest.approx(truth.GRAVITY, rel=0.01)
    # No force is missing.
    assert "structure" not in {diagnostic.code for diagnostic in with_slot.diagnostics}


def test_draws_have_the_friction_of_the_transmitted_effort():
    dataset = treat_all([Log.from_columns(truth.log(seconds=4.0), axis=ARM)], [ARM])
    plant = br.plants.find("inertia+gravity")(M=truth.J, g_sin=truth.GRAVITY, g_cos=0.0)
    rising = friction.find("coulomb_viscous+transmitted")(
        F_C=truth.F_C, F_v=truth.F_V, c_T=truth.SHARE
    )
    fixed = simulated_bands.Bands(
        {"F_C": np.array([truth.F_C])}, scatter=0.0, noise=0.0, unexplained=0.0
    )
    (effort,) = simulated_bands._efforts(fixed, plant, rising, dataset, 1)
    assert np.sqrt(np.mean((effort - dataset.effort) ** 2)) < 0.02 * np.sqrt(
        np.mean(dataset.effort**2)
    )


def test_the_slot_does_no_harm_for_constant_friction():
    fits = {
        fit.name: fit
        for fit in identified(truth.log(share=0.0, seconds=12.0), ARM, list(SLOTTED), blocks=2).fits
    }
    plain, slotted = (fits[name] for name in SLOTTED)
    assert held_out(slotted) < 1.02 * held_out(plain)
    assert abs(slotted.friction.values["c_T"]) < 0.005


def test_a_gear_is_named_by_the_input_of_its_friction():
    best = identified(truth.log(), ARM, "coulomb_viscous", blocks=0).best
    (said,) = (item for item in best.diagnostics if item.code == "terms_beside")
    assert said.numbers["model"] == "coulomb_viscous+transmitted"
    assert "holds with load (" in message(said)


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("seed", range(3))
def test_a_gear_is_not_named_for_constant_friction(seed):
    best = identified(truth.log(share=0.0, seed=seed), ARM, "coulomb_viscous", blocks=0).best
    assert "structure" not in {diagnostic.code for diagnostic in best.diagnostics}


@pytest.mark.slow
@pytest.mark.parametrize("share", [truth.SHARE, 0.0])
def test_all_models_include_the_gear_if_the_log_shows_it(share, monkeypatch):
    monkeypatch.setattr(request, "MODELS", {"coulomb": request.MODELS["coulomb"]})
    identification = identified(truth.log(share=share, seconds=10.0), ARM, "all", blocks=2)
    names = [fit.name for fit in identification.fits]
    if share:
        assert names[0] == "coulomb_viscous+transmitted"
        plain = next(fit for fit in identification.fits if fit.name == "coulomb")
        assert held_out(plain) > 2.0 * held_out(identification.best)
    else:
        assert not any("transmitted" in name for name in names)


def test_elements_are_not_referred_to_an_impossible_slot():
    assert model_with("transmitted", friction.maxwell_slip(**friction.maxwell_slip.example)) == ""
    assert (
        model_with("transmitted", friction.lugre(**friction.lugre.example)) == "lugre+transmitted"
    )


@pytest.mark.slow
def test_cogging_is_distinguished_from_rippling_friction():
    t, q, v, a = truth.swing(25.0, 3)
    q, v, a = (0.02 * signal for signal in (q, v, a))
    angle = 2.0 * np.pi * q / 5e-3
    # Six in a hundred of the friction each: even once and six times a turn, odd once a turn.
    even = 0.9 * np.cos(angle + 1.0) + 0.9 * np.sin(6.0 * angle)
    u = 12.0 * a + even + (15.0 + 0.9 * np.sin(angle - 0.3)) * np.sign(v) + 60.0 * v
    noisy = u + 0.05 * np.random.default_rng(5).standard_normal(t.size)
    best = identified({"t": t, "q": q, "u": noisy}, RIPPLED, "coulomb_viscous+ripple").best
    plant, contact = best.plant.values, best.friction.values
    assert np.hypot(plant["motor_1_cos"], plant["motor_1_sin"]) == pytest.approx(0.9, rel=0.1)
    assert np.hypot(plant["motor_6_cos"], plant["motor_6_sin"]) == pytest.approx(0.9, rel=0.1)
    assert np.hypot(contact["h_c1"], contact["h_s1"]) == pytest.approx(0.9, rel=0.1)
    assert contact["h_s1"] == pytest.approx(0.9 * np.cos(0.3), rel=0.1)


@pytest.mark.parametrize(
    ("model", "told"),
    [("viscous+transmitted", "no friction level"), ("maxwell_slip+transmitted", r"\+transmitted")],
)
def test_a_model_without_a_level_or_with_elements_has_no_such_slot(model, told):
    with pytest.raises(InputError, match=told):
        identified(truth.log(seconds=3.0), ARM, model)


DT, J, F_C, F_V = 2e-3, 0.2, 1.0, 0.5


def joint(force, kind="rotational", scale=1.0, seconds=14.0):
    """Return the log of a joint that moves in three sines: inertia, Coulomb and viscous friction, and a force of the position."""
    t, q, v, a = sines(
        seconds, DT, scale * np.array([0.9, 0.5, 0.15]), np.array([0.7, 1.9, 4.4]) / (2.0 * np.pi)
    )
    noise = 0.02 * np.random.default_rng(0).normal(size=t.size)
    effort = J * a / scale + F_C * np.sign(v) + F_V * v / scale + force(q / scale) + noise
    return Log.from_columns({"time": t, "position": q, "effort": effort}, kind=kind)


def forced(log, blocks=None, **options):
    axis = Axis(kind=log.kind, **options)
    return identify(
        log, "coulomb_viscous", axis=axis, method="inverse_dynamics", draws=0, blocks=blocks
    )


def values(result):
    return {name: estimate.value for name, estimate in result.best.parameters.items()}


FORCES = {
    "gravity": lambda q: 20.0 * np.sin(q + 0.3),
    "strong gravity": lambda q: 80.0 * np.sin(q + 0.3),
    "spring": lambda q: 5.0 * (q - 0.4),
    "strong spring": lambda q: 60.0 * (q - 0.4),
    "cable": lambda q: 1.5 * q**2 + 0.8 * q**3,
}


@pytest.mark.parametrize("force", FORCES)
def test_a_force_of_the_position_does_not_count_as_a_stuck_axis(force):
    assert "never_slides" not in {item.code for item in checked(joint(FORCES[force]))}


@pytest.mark.parametrize("force", ["spring", "strong spring"])
def test_the_same_force_over_a_short_stroke_may_be_a_stuck_axis(force):
    codes = {item.code for item in checked(joint(FORCES[force], "translational", 1e-5))}
    assert ("never_slides" in codes) == (force == "strong spring")


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    ("force", "line", "expected"),
    [
        (
            "strong gravity",
            ("gravity", "link"),
            {"g_sin": 80.0 * np.cos(0.3), "g_cos": 80.0 * np.sin(0.3)},
        ),
        ("spring", ("spring", "linear"), {"spring_1": 5.0, "offset": -2.0}),
        ("strong spring", ("spring", "linear"), {"spring_1": 60.0, "offset": -24.0}),
    ],
)
def test_a_force_of_the_position_is_proposed_and_identified(force, line, expected):
    result = forced(joint(FORCES[force]), blocks=2)
    assert [(entry.section, entry.key, entry.value) for entry in result.second_pass.lines] == [
        ("plant", *line)
    ]
    assert result.second_pass.taken
    found = values(result)
    for name, value in (expected | {"M": J}).items():
        assert found[name] == pytest.approx(value, rel=0.02), name
    assert found["F_C"] == pytest.approx(F_C, rel=0.1)


@pytest.mark.slow
def test_a_stated_spring_or_cable_is_identified_in_the_first_pass():
    found = values(forced(joint(FORCES["spring"]), spring="linear", blocks=0))
    assert found["spring_1"] == pytest.approx(5.0, rel=0.01)
    assert "spring_2" not in found
    found = values(forced(joint(FORCES["cable"], "translational"), spring="cubic", blocks=0))
    assert (found["spring_2"], found["spring_3"]) == (
        pytest.approx(1.5, rel=0.03),
        pytest.approx(0.8, rel=0.03),
    )


@pytest.mark.slow
def test_friction_that_varies_with_the_position_is_no_spring():
    t = np.arange(0.0, 14.0, DT)
    q = 0.9 * np.sin(0.7 * t) + 0.5 * np.sin(1.9 * t + 1.0)
    v, a = np.gradient(q, DT), np.gradient(np.gradient(q, DT), DT)
    effort = (
        J * a
        + (F_C + 0.8 * q) * np.sign(v)
        + F_V * v
        + 0.02 * np.random.default_rng(0).normal(size=t.size)
    )
    result = forced(
        Log.from_columns({"time": t, "position": q, "effort": effort}, kind="rotational")
    )
    (beside,) = [item for item in result.best.diagnostics if item.code == "terms_beside"]
    assert beside.numbers["terms"][0].startswith("along the axis")
    assert result.second_pass is None


def test_a_spring_is_a_line_of_the_axis_file(tmp_path):
    lines = {"schema": 1, "kind": "rotational", "plant": {"spring": "cubic"}}
    columns = {
        name: {"column": name, "unit": unit}
        for name, unit in (("time", "s"), ("position", "rad"), ("effort", "N*m"))
    }
    axis = axis_from(lines | {"columns": columns})
    assert axis.spring == "cubic"
    (tmp_path / "axis.toml").write_bytes(axis_text(axis))
    assert read_axis(tmp_path / "axis.toml").spring == "cubic"
    with pytest.raises(br.core.InputError, match="spring"):
        axis_from(lines | {"columns": columns, "plant": {"spring": "quadratic"}})
