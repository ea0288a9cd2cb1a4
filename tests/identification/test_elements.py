"""Elements that slip: recovered from logs, their columns and their fixed shape."""

from dataclasses import replace

import numpy as np
import pytest
from tests.golden.simulated import ELEMENTS, SLOW, elements_log
from tests.identification.known_logs import STATED, Motion, log_of, sines, slow_log, virgin_curve
from tests.identification.rigid import identify

from bristle import plants
from bristle.core import InputError
from bristle.core.contracts import make_model
from bristle.engine import force_along
from bristle.files.model import read_model, write_model
from bristle.identification.element_models import elements_of
from bristle.identification.estimation import context_of
from bristle.identification.fixed_shape import DIFFERENCE, ElementSpace, in_lists, shaped
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.parameters import PriorKnowledge
from bristle.identification.preprocessing import treat
from bristle.identification.problem import covariance_of
from bristle.models.friction import find, maxwell_slip
from bristle.prediction import predict
from bristle.report.messages import assumptions_of

MASS = 12.0
KNOWN = replace(STATED, mass=MASS, cutoff=80.0, decimation=2)


@pytest.fixture(scope="module")
def identified():
    return identify(elements_log(), "dahl,maxwell_slip", axis=KNOWN, decimation=5, draws=0)


def test_level_stiffness_and_virgin_curve_are_recovered(identified):
    fit = identified.best
    values = fit.friction.values
    assert fit.name == "maxwell_slip"
    assert sum(values["nu_i"]) == pytest.approx(1.0)
    x = np.linspace(1e-6, 20e-6, 20)
    assert np.max(np.abs(virgin_curve(values, x) - virgin_curve(ELEMENTS, x))) < 0.4
    assert {fit.parameters[name].status for name in ("F_C", "s")} == {"identified"}
    assert fit.parameters["F_C"].value == pytest.approx(20.0, abs=0.2)
    assert fit.parameters["s"].value == pytest.approx(sum(ELEMENTS["k_i"]), rel=0.15)
    assert fit.parameters["s"].value == pytest.approx(float(np.sum(values["k_i"])))
    assert fit.parameters["offset"].value == pytest.approx(1.5, abs=0.1)
    assert fit.further == len(values["k_i"]) - 2


@pytest.mark.parametrize(
    ("seconds", "draws"), [(3.0, 0), pytest.param(8.0, 20, marks=pytest.mark.slow)]
)
def test_the_stiffness_of_long_strokes_is_identified_from_little_presliding(seconds, draws):
    log = elements_log(duration=seconds, dt=2e-4, fine=4, strokes=(1.5e-2, 3e-3, 2e-4), offset=0.0)
    stiffness = identify(
        log, "maxwell_slip", axis=replace(KNOWN, cutoff=400.0), blocks=0, draws=draws
    ).best.parameters["s"]
    assert stiffness.takes < 0.06
    assert stiffness.status == "identified"
    assert stiffness.value == pytest.approx(sum(ELEMENTS["k_i"]), rel=0.02)


def test_elements_rank_before_local_memory_for_loops_inside_loops(identified):
    errors = {fit.name: fit.held_out.mean_percent for fit in identified.fits}
    assert errors["maxwell_slip"] < 0.7 * errors["dahl"]


def test_a_model_file_with_elements_predicts_another_log(identified, tmp_path):
    fit = identified.best
    write_model(tmp_path / "model.toml", fit.plant, fit.friction, estimates=fit.estimates)
    read = read_model(tmp_path / "model.toml")
    assert read.friction == fit.friction
    text = predict(read.plant, read.friction, elements_log(seed=1), cutoff=80.0, decimation=2)
    assert text.metrics["force_rmse"] < 0.15
    assert text.metrics["force_unit"] == "N"


@pytest.mark.slow
def test_friction_over_the_position_is_distinguished_from_a_force_over_it():
    truth = {"x_0": 0.0, "x_L": 50e-6, "p_1": 0.15, "p_2": -0.2, "a_1": 1.2, "a_2": -0.8}
    log = elements_log("maxwell_slip+position", duration=8.0, **truth)
    identification = identify(
        log, "maxwell_slip,maxwell_slip+position", axis=KNOWN, decimation=5, blocks=0, draws=0
    )
    assert identification.best.name == "maxwell_slip+position"
    fit = identification.best
    x = np.linspace(-40e-6, 40e-6, 9)

    def along(p):
        xi = np.clip((x - p["x_0"]) / p["x_L"], -1.0, 1.0)
        return p["F_C"] * (1.0 + xi * (p["p_1"] + xi * p["p_2"])), xi * (
            p["a_1"] + xi * p["a_2"]
        ) + p["offset"]

    level, beside = along({name: item.value for name, item in fit.parameters.items()})
    true_level, true_beside = along(ELEMENTS | truth | {"offset": 1.5})
    assert np.max(np.abs(level - true_level)) < 0.5
    assert np.max(np.abs(beside - true_beside)) < 0.25
    assert fit.parameters["x_0"].status == "held"


@pytest.fixture(scope="module")
def loaded():
    """A log whose friction depends on load and temperature."""
    t = 1e-3 * np.arange(12_000)
    around = {"load": 1.0 + 0.3 * np.sin(0.9 * t), "temperature": 293.15 + 10.0 * np.cos(0.37 * t)}
    return elements_log("maxwell_slip+load+temperature", **around, k_L=0.8, k_T=-0.01)


@pytest.mark.parametrize(
    ("name", "decimation", "expected"),
    [
        (
            "maxwell_slip+load+temperature",
            10,
            {"k_L": pytest.approx(0.8, abs=0.03), "k_T": pytest.approx(-0.01, abs=1e-3)},
        ),
        # The search finds the same for no list of elements.
        ("coulomb_viscous+load", 20, {"k_L": pytest.approx(0.8, abs=0.15)}),
    ],
)
def test_load_and_temperature_are_factors_of_friction(loaded, name, decimation, expected):
    parameters = identify(
        loaded, name, axis=KNOWN, decimation=decimation, blocks=0, draws=0
    ).best.parameters
    assert {key: parameters[key].value for key in expected} == expected


def test_a_slot_needs_its_channel():
    with pytest.raises(InputError, match=r"has no load, needed by \+load"):
        identify(elements_log(duration=1.0), "maxwell_slip+load", axis=KNOWN, draws=0)


@pytest.mark.slow
def test_the_interval_of_the_level_includes_the_shape():
    fits = [
        identify(elements_log(seed=seed), "maxwell_slip", axis=KNOWN, blocks=0, draws=0).best
        for seed in range(8)
    ]
    for name in ("F_C", "offset"):
        spread = float(np.std([fit.parameters[name].value for fit in fits], ddof=1))
        assert fits[0].parameters[name].larger_std > 0.5 * spread, name
        assert fits[0].parameters[name].std < 10.0 * spread, name


def to_and_fro(duration, speed, **more):
    """Motion at one speed, and the friction of the elements along it."""
    t = 1e-3 * np.arange(round(duration / 1e-3))
    way = np.abs((speed * t + 20e-6) % 80e-6 - 40e-6) - 20e-6
    motion = Motion(t, way, np.gradient(way, t), 0.0 * t)
    return motion, force_along(find("maxwell_slip")(**ELEMENTS, **more), motion.velocity, 1e-3)


def test_at_one_speed_viscous_friction_is_not_a_number():
    motion, friction = to_and_fro(20.0, 8e-6, sigma_2=300.0)
    fit = identify(
        log_of(motion, friction), "maxwell_slip", axis=KNOWN, cutoff=40.0, blocks=0, draws=0
    ).best
    assert fit.parameters["sigma_2"].status == "held"
    assert fit.friction.values["sigma_2"] == 0.0
    assert any("because the log has a single speed" in item for item in assumptions_of(fit))
    assert fit.parameters["F_C"].value == pytest.approx(20.0, rel=0.02)


@pytest.mark.slow
def test_levels_by_direction_are_as_certain_as_a_level_and_an_offset():
    motion, friction = to_and_fro(12.0, 16e-6)
    log = log_of(motion, friction + np.random.default_rng(0).normal(0.0, 0.3, friction.size))
    plain, sided = (
        identify(log, name, axis=KNOWN, cutoff=40.0, blocks=0, draws=0).best.parameters
        for name in ("maxwell_slip", "maxwell_slip+asymmetry")
    )
    # F_C + d and F_C - d: the sum of their variances is twice that of F_C and of d.
    result = np.hypot(sided["F_C_pos"].std, sided["F_C_neg"].std)
    assert result == pytest.approx(
        2.0**0.5 * np.hypot(plain["F_C"].std, plain["offset"].std), rel=0.01
    )


@pytest.mark.slow
def test_directions_differ_by_one_number():
    levels = {"F_C_pos": 24.0, "F_C_neg": 16.0, "sigma_2_pos": 200.0, "sigma_2_neg": 500.0}
    shape = {name: ELEMENTS[name] for name in ("k_i", "nu_i")}
    motion = sines(12.0, 1e-4, *SLOW)
    truth = find("maxwell_slip+asymmetry")(**levels, **shape)
    friction = force_along(truth, motion.velocity, 1e-4, motion.position)
    coarse = Motion(*(item[::10] for item in motion))
    noise = np.random.default_rng(3).normal(0.0, 0.05, coarse.time.size)
    log = log_of(coarse, MASS * coarse.acceleration + friction[::10] + noise, step=1e-7)
    requested = {"axis": KNOWN, "decimation": 5, "blocks": 0}
    fit = identify(log, "maxwell_slip+asymmetry", draws=20, **requested).best
    for name in ("F_C_pos", "F_C_neg"):
        assert fit.parameters[name].value == pytest.approx(levels[name], abs=0.3)
        assert fit.parameters[name].interval[0] < levels[name] < fit.parameters[name].interval[1]
    assert fit.parameters["s"].value == pytest.approx(sum(shape["k_i"]), rel=0.15)
    assert fit.parameters["offset"].status == "held"
    # Without directions of their own the elements are the same, and the difference is an offset.
    plain = identify(log, "maxwell_slip", draws=0, **requested).best
    assert plain.parameters["offset"].value == pytest.approx(4.0, abs=0.3)
    assert plain.parameters["F_C"].value == pytest.approx(20.0, abs=0.3)


def elements_through(step):
    """A log through an encoder of this step, of which half of the stiffness slips within 0.4 um."""
    values = {"F_C": 20.0, "k_i": [3e6, 8e6 / 6.0, 0.4e6, 5e6], "nu_i": [0.25, 0.35, 0.3, 0.1]}
    return slow_log(
        find("maxwell_slip")(**values, sigma_2=300.0, offset=1.5), M=MASS, step=step, duration=12.0
    )


@pytest.mark.slow
def test_elements_within_five_encoder_steps_do_not_identify_a_stiffness():
    requested = {"axis": KNOWN, "cutoff": 250.0, "decimation": 2, "blocks": 0, "draws": 20}
    coarse, fine = (
        identify(elements_through(step), "maxwell_slip", **requested).best for step in (1e-7, 1e-8)
    )
    stiffness = coarse.parameters["s"]
    assert (stiffness.status, stiffness.reason.code) == ("unidentifiable", "coarse_elements")
    # What of it slips within 0.5 um, as the model tells it.
    values = coarse.friction.values
    slips = np.asarray(values["nu_i"]) * values["F_C"] / np.asarray(values["k_i"])
    share = np.sum(values["k_i"], where=slips < 5e-7) / np.sum(values["k_i"])
    assert stiffness.reason.numbers["percent"] == pytest.approx(100.0 * share)
    assert share > 0.3
    assert coarse.resampling.curve_from == pytest.approx(5e-7)
    assert coarse.parameters["F_C"].status == "identified"
    assert (fine.parameters["s"].status, fine.resampling.curve_from) == ("identified", 0.0)
    # Whoever knows better may say so.
    trusting = identify(
        elements_through(1e-7), "maxwell_slip", settings={"blurred_share": 1.0}, **requested
    ).best
    assert trusting.parameters["s"].status == "identified"


T = 1e-3 * np.arange(3000)
AROUND = {"load": 1.0 + 0.3 * np.sin(9.0 * T), "temperature": 293.15 + 10.0 * np.cos(3.7 * T)}


@pytest.mark.parametrize(
    ("name", "plant", "known"),
    [
        ("maxwell_slip", "inertia", {"M": MASS}),
        ("maxwell_slip+position", "inertia", {}),
        ("maxwell_slip+periodic", "oscillator", {}),
        ("maxwell_slip+load+temperature", "inertia", {"M": MASS}),
        ("maxwell_slip+position+periodic+load+temperature", "inertia", {}),
        ("maxwell_slip+position+periodic+load+temperature+asymmetry", "inertia", {}),
    ],
)
def test_columns_times_values_are_the_effort_of_the_model_with_its_slots(name, plant, known):
    dataset = treat(elements_log(duration=3.0, **AROUND), None, cutoff=80.0, decimation=2)
    context = context_of(dataset, PriorKnowledge(None, known, getattr(plants, plant), 2e-5))
    elements = elements_of(context, find(name))
    rng, r = np.random.default_rng(3), elements.thresholds
    stiffness = np.zeros(r.size)
    stiffness[[4, 11, 20]] = 3e6, 1e6, 4e5
    values = elements.parameters.complete(
        {factor: 0.1 * rng.standard_normal() for factor in elements.parameters.free}
    )
    values |= dict.fromkeys(elements._levels, float(stiffness @ r)) | {
        "s": float(np.sum(stiffness))
    }
    assert set(values) == {*elements.parameters.variables, "s"} - {"k_i", "nu_i"}

    columns = elements._for_factors(
        np.array([values[factor] for factor in elements._factors]), slice(None)
    ).columns
    explained = columns @ np.concatenate(
        [stiffness, [values.get(factor, 0.0) for factor in elements._single]]
    )
    view = shaped(find(name), stiffness[stiffness > 0.0], (stiffness * r)[stiffness > 0.0])
    wanted = InverseDynamics(dataset, context.parameters(view)).predicted(values)
    assert explained + dataset.effort - elements._target == pytest.approx(
        wanted, rel=1e-9, abs=1e-9 * float(np.max(np.abs(wanted)))
    )


def test_errors_of_level_and_stiffness_are_those_of_sums_over_free_elements():
    dataset = treat(elements_log(duration=3.0, noise=0.5), None, cutoff=80.0, decimation=2)
    elements = elements_of(
        context_of(dataset, PriorKnowledge(None, {"M": MASS})), find("maxwell_slip")
    )
    problem, solution = elements.solution()
    residual = problem.residual(solution.values)
    result = dict(
        zip(solution.space.reported, covariance_of(solution, residual).std.tolist(), strict=True)
    )
    best = elements._best(slice(None))
    pressed, count = best.stiffness > 0.0, best.stiffness.size
    assert np.sum(pressed) > 2
    columns = best.columns[
        :, np.concatenate([pressed, np.ones(best.columns.shape[1] - count, dtype=bool)])
    ]
    square = float(residual @ residual) / (residual.size - len(result))
    covariance = square * np.linalg.inv(columns.T @ columns)[: np.sum(pressed), : np.sum(pressed)]
    for name, share in (("F_C", elements.thresholds[pressed]), ("s", np.ones(np.sum(pressed)))):
        assert result[name] == pytest.approx((share @ covariance @ share) ** 0.5, rel=1e-3), name


STIFFNESS, LEVELS = np.array([3e5, 1e5]), np.array([6.0, 4.0])
COMPONENT = shaped(maxwell_slip, STIFFNESS, LEVELS)
THRESHOLDS = np.array([1e-5, 4e-5])


def test_one_stiffness_replaces_those_of_all_elements():
    lists = {"F_C": 20.0, "k_i": pytest.approx([6e5, 2e5]), "nu_i": pytest.approx([0.6, 0.4])}
    assert COMPONENT.lists({"F_C": 20.0, "s": 8e5, "sigma_2": 0.0}) == lists | {"sigma_2": 0.0}
    assert COMPONENT.finished({"F_C": 20.0, "s": 8e5, "other": 1.0}) == lists | {"other": 1.0}
    assert (COMPONENT.further, shaped(maxwell_slip, np.ones(5), np.ones(5)).further) == (0, 3)


def test_kernel_parameters_convert_back_to_the_stiffness():
    model = make_model(COMPONENT, {"F_C": 20.0, "s": 8e5}, kind=None, validate=True)
    assert (model.values["s"], model.values["F_C"]) == (pytest.approx(8e5), 20.0)
    assert not COMPONENT.is_array("s")
    assert not COMPONENT.is_integer("s")
    lists = in_lists(model)
    assert lists.component is maxwell_slip
    assert lists.values["k_i"] == pytest.approx([6e5, 2e5])


@pytest.mark.parametrize(
    ("distance", "level", "share"),
    [(1.9e-5, 10.0, 0.0), (2.1e-5, 10.0, 0.75), (4.1e-5, 10.0, 1.0), (2.1e-5, 20.0, 0.0)],
)
def test_elements_that_slip_within_a_distance_have_their_share_of_the_stiffness(
    distance, level, share
):
    # At a level of 10 N and a stiffness of 4e5 N/m the elements slip at 6 N / 3e5 N/m and at 4 N / 1e5 N/m.
    assert COMPONENT.share_within(distance, 4e5, level) == pytest.approx(share)


def space_of(*levels, single=None):
    names = {"M": 0.0, "offset": -np.inf} if single is None else single
    return ElementSpace.around(THRESHOLDS, names, dict(levels), ["M", "offset", *dict(levels)])


def test_a_level_is_the_force_at_which_all_elements_slip():
    space, lists = (
        space_of(("F_C", 0.0)),
        {"k_i": pytest.approx([2e5, 1e5]), "nu_i": pytest.approx([2.0 / 6.0, 4.0 / 6.0])},
    )
    theta = np.array([2e5, 1e5, 12.0, -1.5])
    assert (
        space.values(theta)
        == {"F_C": pytest.approx(2e5 * 1e-5 + 1e5 * 4e-5), "M": 12.0, "offset": -1.5} | lists
    )
    assert space.reported == ("F_C", "s", "M", "offset")
    assert space.derivative(theta) @ theta == pytest.approx([6.0, 3e5, 12.0, -1.5])


def test_two_levels_differ_by_twice_their_difference():
    space = space_of(
        ("F_C_pos", 1.0),
        ("F_C_neg", -1.0),
        single={"M": 0.0, "offset": -np.inf, DIFFERENCE: -np.inf},
    )
    theta = np.array([2e5, 1e5, 12.0, -1.5, 0.5])
    values = space.values(theta)
    assert (values["F_C_pos"], values["F_C_neg"]) == (pytest.approx(6.5), pytest.approx(5.5))
    assert DIFFERENCE not in values
    assert space.derivative(theta) @ theta == pytest.approx([6.5, 5.5, 3e5, 12.0, -1.5])


def test_an_element_without_force_keeps_its_threshold():
    values = space_of(("F_C", 0.0)).values(np.array([2e5, 0.0, 1.0, 0.0]))
    k, level = values["k_i"], values["F_C"]
    assert k[1] > 0.0
    assert values["nu_i"] * level / k == pytest.approx(THRESHOLDS)


def test_the_virgin_curve_bends_at_the_thresholds():
    space = space_of(("F_C", 0.0))
    curve = space.numbers(np.array([2e5, 1e5, 12.0, -1.5]))[4:]
    assert len(space.curve) == 12
    assert (space.curve[0], space.curve[-1]) == (pytest.approx(1e-5), pytest.approx(4e-5))
    assert curve[0] == pytest.approx(3e5 * 1e-5)
    assert curve[-1] == pytest.approx(6.0)
    assert np.diff(curve) / np.diff(space.curve) == pytest.approx(1e5)


def test_the_reflection_of_a_fit_is_at_the_same_distance():
    space = space_of(("F_C", 0.0))
    best, theta = np.array([2e5, 1e5, 12.0, -1.5]), np.array([2.2e5, 1.1e5, 13.0, -1.0])
    bent = np.array([2.6e5, 0.9e5, 13.0, -1.0])
    # The shape is that of the fit.
    assert space.turned(bent, best).values["nu_i"] == pytest.approx(space.values(bent)["nu_i"])
    turned = space.turned(theta, best)
    assert turned.numbers[:4] == pytest.approx(
        2.0 * space.numbers(best)[:4] - space.numbers(theta)[:4]
    )
    assert (turned.values["F_C"], np.sum(turned.values["k_i"])) == (
        pytest.approx(5.4),
        pytest.approx(2.7e5),
    )
    assert "s" not in turned.values
    far = space.turned(np.array([9e5, 9e5, 40.0, 0.0]), best)
    assert far.values["F_C"] == pytest.approx(0.05 * 6.0)
    assert np.sum(far.values["k_i"]) == pytest.approx(0.05 * 3e5)
    assert far.values["M"] == 0.0  # no mass is below nothing
