"""Scenes of MuJoCo: contents, stated errors and, if MuJoCo is installed, forces in MuJoCo."""

import importlib.util
import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from tests.exports.native import walk

import bristle as br
from bristle.apps.targets.mjcf import write
from bristle.contract import example_of
from bristle.core import InputError
from bristle.exports.described import Request
from bristle.exports.moves import moves_for

needs_mujoco = pytest.mark.skipif(importlib.util.find_spec("mujoco") is None, reason="needs mujoco")
LUGRE = br.friction.lugre(F_C=1.0, F_S=1.5, v_S=1e-3, sigma_0=1e5, sigma_1=316.0, sigma_2=0.4)


def scene(model, **options):
    product = write(Request(model, "axis_x", 1e-3, **options))
    return ElementTree.fromstring(product.files["axis_x.xml"]), product.notes


def read(attribute):
    """Return the numbers of an attribute, or its word."""
    return attribute if attribute.isalpha() else [float(number) for number in attribute.split()]


DRY = br.friction.with_slots(br.friction.coulomb_viscous, [])(
    kind="rotational", F_C=0.2, F_v=0.03, offset=0.1
)
FROZEN = br.friction.find("coulomb+position+temperature")(
    F_C=2.0, x_0=0.1, x_L=0.2, p_1=0.3, k_T=0.01
)


@pytest.mark.parametrize(
    ("model", "options", "parts", "words"),
    [
        # The bristle is a passive motor, which the integrator Euler treats implicitly.
        (
            LUGRE,
            {"mass": 2.0},
            {
                "actuator/dcmotor": {"lugre": [1e5, 316.0, 1.0, 1.5, 1e-3], "damping": [0.4]},
                "option": {"integrator": "Euler"},
                "worldbody/body/inertial": {"mass": [2.0], "diaginertia": [1.0, 1.0, 1.0]},
            },
            ["Euler"],
        ),
        # Dry and viscous friction belong to the joint, and an offset is a constant force.
        (
            DRY,
            {"mass": 0.5},
            {
                "worldbody/body/joint": {
                    "type": "hinge",
                    "frictionloss": [0.2],
                    "damping": [0.03],
                    "axis": [0.0, 0.0, 1.0],
                },
                "worldbody/body/inertial": {"mass": [1.0], "diaginertia": [0.5, 0.5, 0.5]},
                "actuator/general": {"biasprm": [-0.1, 0.0, 0.0]},
            },
            ["no error"],
        ),
        (
            br.friction.coulomb(F_C=0.2),
            {"mass": 0.5, "plant": br.plants.oscillator(M=0.5, c=1.0, k=10.0)},
            {
                "worldbody/body/joint": {
                    "type": "slide",
                    "frictionloss": [0.2],
                    "axis": [1.0, 0.0, 0.0],
                },
                "worldbody/body/inertial": {"mass": [0.5], "diaginertia": [1.0, 1.0, 1.0]},
            },
            ["no error", "without c, k"],
        ),
        # Friction that varies has its nominal value.
        (
            FROZEN,
            {},
            {"worldbody/body/joint": {"frictionloss": [2.0]}},
            ["omits position, temperature"],
        ),
    ],
    ids=["lugre", "dry", "coulomb", "frozen"],
)
def test_friction_is_written_in_the_parts_of_a_scene(model, options, parts, words):
    root, notes = scene(model, **options)
    for place, attributes in parts.items():
        element = root.find(place).attrib
        assert {name: read(element[name]) for name in attributes} == attributes
    assert all(word in " ".join(notes) for word in words)


def test_dry_friction_alone_needs_no_damping_but_iterations_without_slip():
    root, _ = scene(br.friction.coulomb(F_C=0.2))
    assert "damping" not in root.find("worldbody/body/joint").attrib
    assert [part.tag for part in root.find("actuator")] == ["motor"]
    assert int(root.find("option").attrib["noslip_iterations"]) > 0


def test_the_scene_states_the_time_constant_of_the_bristles():
    text = write(Request(LUGRE, "axis_x", 1e-3, mass=4.0)).files["axis_x.xml"]
    assert f"{(4.0 / 1e5) ** 0.5:.2g}" in text
    assert "--" not in text.partition("<!--")[2].partition("-->")[0]


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in br.friction.MODELS if name != "lugre"])
def test_every_model_is_written_with_a_stated_error(name):
    model = br.friction.MODELS[name]
    for slots in ([], ["asymmetry"]):
        product = write(Request(example_of(br.friction.with_slots(model, slots)), "axis_x", 5e-4))
        exact = name in ("coulomb", "viscous", "coulomb_viscous", "maxwell_slip")
        assert (
            any(("no error" if exact and not slots else "% rms") in note for note in product.notes)
            or exact
        )
        error = next(note for note in product.notes if "error" in note)
        assert error.lower() in " ".join(product.files["axis_x.xml"].lower().split())


@pytest.mark.slow
def test_stops_and_a_spring_are_written_without_error():
    stops = br.hysteresis.prandtl_ishlinskii(
        kind="translational", thresholds=[1e-6, 4e-6], weights=[3e6, 1e6], spring=1e5
    )
    root, notes = scene(br.friction.preisach_contact(kernel=stops, sigma_2=50.0))
    written = [
        (part.get("stiffness"), part.get("springyield")) for part in root.iterfind("tendon/fixed")
    ]
    assert written == [("3000000.0", "1e-06"), ("1000000.0", "4e-06"), ("100000.0", None)]
    assert "no error" in notes[0]


def test_a_force_that_grows_without_bound_is_fitted_until_its_stiffness_has_doubled():
    """Without yielding, the force of `bouc_wen_classic` is alpha x (e^q - 1) / q at q = beta (gamma + delta) x."""
    friction = br.friction.bouc_wen_classic(alpha=5e4, beta=1e3, gamma=0.8, delta=-1.1)
    product = write(Request(friction, "axis_x", 5e-4, speed=0.5))
    q = 300.0 * product.error["reach"]
    assert 1.7 < np.expm1(q) / q < 2.1
    # Earlier moves leave a force behind.
    assert 0.8 < product.error["level"] / (5e4 / 300.0 * np.expm1(q)) <= 1.0
    assert product.error["rms"] < 12.0
    assert "grows without bound" in product.notes[0]
    assert re.search(
        r"along moves within 4.01 mm: .* of the largest force; beyond", product.notes[0]
    )


def test_a_model_without_friction_is_written():
    product = write(Request(br.friction.coulomb_viscous(F_C=0.0, F_v=0.0), "axis_x", 5e-4))
    assert product.error["largest"] == 0.0


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_force_that_is_not_finite_is_refused_by_name():
    huge = br.friction.bouc_wen_classic(alpha=1e90, beta=1e90, gamma=0.0, delta=-1e90)
    with pytest.raises(
        br.core.InputError, match="mjcf: has no finite force along moves; found 'bouc_wen_classic'"
    ):
        write(Request(huge, "axis_x", 5e-4))


def along_in_mujoco(text, x, dt, parts=1):
    """Return the mean resisting force of the joint over each step of a motion that its velocity prescribes, cut into parts."""
    import mujoco

    text = re.sub(
        r'(mass|diaginertia)="[^"]*"',
        lambda hit: f'{hit[1]}="{" ".join(["1e25"] * (1 + 2 * (hit[1] != "mass")))}"',
        text,
    )
    model = mujoco.MjModel.from_xml_string(
        re.sub('timestep="[^"]*"', f'timestep="{dt / parts!r}"', text)
    )
    data, at = (
        mujoco.MjData(model),
        np.interp(np.arange(parts * (len(x) - 1) + 1) / parts, np.arange(len(x)), x),
    )
    force = np.empty(at.size)
    for k, following in enumerate([*at[1:], at[-1]]):
        data.qvel[0] = (following - data.qpos[0]) * parts / dt
        mujoco.mj_step(model, data)  # its forces are those at the beginning of the step
        force[k] = -(data.qfrc_spring[0] + data.qfrc_actuator[0])
    damping = model.dof_damping[0] * np.diff(x) / dt
    return force, np.mean(0.5 * (force[1:] + force[:-1]).reshape(-1, parts), axis=1) + damping


@pytest.mark.parametrize(
    ("given", "moved"),
    [({}, "1.0"), ({"mass": 3.0}, "3.0"), ({"plant": br.plants.inertia(M="28 kg")}, "28.0")],
)
def test_a_scene_moves_the_mass_of_the_plant(tmp_path, given, moved):
    br.export(LUGRE, "mjcf", tmp_path / "out", **given)
    assert f'mass="{moved}"' in (tmp_path / "out/axis_x.xml").read_text()
    with pytest.raises(InputError, match=r"mass: must be positive; found 0"):
        br.export(LUGRE, "mjcf", tmp_path / "none", mass=0)


def simulated(model, mass=1.0, step=5e-4):
    """Return a scene of MuJoCo and its state."""
    import mujoco

    text = write(Request(model, "axis_x", step, mass=mass)).files["axis_x.xml"]
    made = mujoco.MjModel.from_xml_string(text)
    return mujoco.mj_step, made, mujoco.MjData(made)


@pytest.mark.parametrize("levels", [(20.0, 20.0), (25.0, 15.0)])
def test_a_scene_read_by_its_definition_is_friction_that_differs_by_direction(levels):
    """A tendon pulls by its stiffness from its rest length, which moves so that its stretch never exceeds the yield."""
    k, share = np.array([6e6, 1e6]), np.array([0.4, 0.6])
    friction = br.friction.find("maxwell_slip+asymmetry")(
        F_C_pos=levels[0], F_C_neg=levels[1], k_i=k, nu_i=share
    )
    root, _ = scene(friction)
    springs = [
        [float(part.get(key)) for key in ("stiffness", "springlength", "springyield")]
        for part in root.iterfind("tendon/fixed")
    ]
    stiffness, length, most = np.array(springs).T
    constant = sum(
        -float(part.get("biasprm").split()[0]) for part in root.iterfind("actuator/general")
    )
    z, force, plain = np.zeros(k.size), [constant - stiffness @ length], [0.0]
    at = 0.0
    for dx in np.diff(walk(2000, seed=0)):
        at += dx
        z = np.clip(z + k * dx, -levels[1] * share, levels[0] * share)
        length += np.sign(at - length) * np.maximum(np.abs(at - length) - most, 0.0)
        force.append(constant + stiffness @ (at - length))
        plain.append(z.sum())
    assert np.ptp(plain) == pytest.approx(sum(levels))
    np.testing.assert_allclose(force, plain, atol=1e-9)


@needs_mujoco
@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("levels", [(25.0, 15.0), (20.0, 20.0)])
def test_maxwell_slip_in_mujoco_equals_plain_elements(levels):
    k, share = (
        np.array([6e6, 3e6, 1e6, 4e5, 2e5, 1e5, 5e4, 2e4, 1e6]),
        np.array([0.1, 0.1, 0.15, 0.15, 0.15, 0.1, 0.15, 0.1, 0.0]),
    )
    friction = br.friction.find("maxwell_slip+asymmetry")(
        F_C_pos=levels[0], F_C_neg=levels[1], k_i=k, nu_i=share
    )
    x = walk(1500, seed=0)
    x -= x[0]
    force, _ = along_in_mujoco(
        write(Request(friction, "axis_x", 5e-4)).files["axis_x.xml"], x, 1e-4
    )
    z, plain = np.zeros(k.size), np.zeros(x.size)
    for j, dx in enumerate(np.diff(x), start=1):
        z = np.clip(z + k * dx, -levels[1] * share, levels[0] * share)
        plain[j] = np.sum(z)
    # MuJoCo never lets an element of springyield 0 slip, so the scene omits the element without force.
    assert np.ptp(plain) == pytest.approx(sum(levels))
    np.testing.assert_allclose(force, plain, atol=1e-9 * 20.0)


@needs_mujoco
@pytest.mark.parametrize(
    "name",
    [
        "hardening",
        *(pytest.param(name, marks=pytest.mark.slow) for name in ("dahl", "gms+asymmetry")),
    ],
)
def test_the_stated_error_is_the_error_in_mujoco(name):
    if name == "hardening":
        request = Request(
            br.friction.bouc_wen_classic(alpha=5e4, beta=1e3, gamma=0.8, delta=-1.1),
            "axis_x",
            5e-4,
            speed=0.5,
        )
    else:
        request = Request(example_of(br.friction.find(name)), "axis_x", 5e-4)
    product = write(request)
    x, dt, _ = moves_for(request, product.error.get("reach", 0.0))
    _, force = along_in_mujoco(product.files["axis_x.xml"], x, dt, parts=3)
    error = (br.engine.force_along(request.model, np.diff(x) / dt, dt, x[1:]) - force)[
        np.diff(x) != 0.0
    ]
    in_percent = (
        100.0
        * np.array([np.sqrt(np.mean(error**2)), np.max(np.abs(error))])
        / product.error["level"]
    )
    np.testing.assert_allclose(
        in_percent, [product.error["rms"], product.error["largest"]], rtol=2e-3
    )


@needs_mujoco
@pytest.mark.parametrize(
    ("levels", "load"), [((20.0, 20.0), 16.0), ((20.0, 10.0), 19.9), ((20.0, 10.0), -9.9)]
)
def test_a_load_below_dry_friction_moves_the_joint_at_no_speed(levels, load):
    mj_step, model, data = simulated(
        br.friction.find("coulomb+asymmetry")(F_C_pos=levels[0], F_C_neg=levels[1])
    )
    data.ctrl[0] = load
    mj_step(model, data, 50_000)
    assert abs(data.qvel[0]) < 1e-15
    assert abs(data.qpos[0]) < 1e-15
    side = np.sign(load)
    data.ctrl[0] = side * (levels[load < 0.0] + 1.0)
    mj_step(model, data, 1000)
    assert data.qvel[0] == pytest.approx(0.1 * side, rel=1e-3)


@pytest.mark.slow
@needs_mujoco
def test_elements_hold_a_load_without_creep():
    mj_step, model, data = simulated(
        br.friction.maxwell_slip(F_C=20.0, k_i=[6e6, 3e6, 1e6], nu_i=[0.3, 0.4, 0.3], sigma_2=200.0)
    )
    speed = []
    for load in np.minimum(np.arange(50_000) * 1.6e-3, 16.0):
        data.ctrl[0] = load
        mj_step(model, data)
        speed.append(abs(data.qvel[0]))
    assert max(speed[:10_000]) > 1e-6
    assert speed[-1] < 1e-15


@needs_mujoco
@pytest.mark.slow
def test_stick_slip_converges_to_bristle_with_first_order():
    pulled = br.plants.pulled_inertia(M=1.0, k=2.0, v_e=0.1)
    expected = np.array(br.engine.run_open_loop(pulled, LUGRE, np.zeros(400_000), 1e-5).position)[
        ::1000
    ]
    errors = []
    for step in (1e-4, 5e-5):
        mj_step, made, data = simulated(LUGRE)
        made.opt.timestep = step
        every, x = round(0.01 / step), []
        for k in range(400 * every):
            if k % every == 0:
                x.append(data.qpos[0])
            data.ctrl[0] = 2.0 * (0.1 * k * step - data.qpos[0])
            mj_step(made, data)
        errors.append(np.max(np.abs(np.array(x) - expected)))
    assert errors[0] < 2e-4
    assert errors[1] == pytest.approx(0.5 * errors[0], rel=0.2)


def test_the_inertia_of_a_screw_is_that_at_its_motor(tmp_path):
    # An arm of 1 mm.
    screw = br.plants.ball_screw(kind="rotational", J=1e-4, M=20.0, lead=2e-3 * np.pi, k=1e8)
    br.export(
        br.friction.coulomb(kind="rotational", F_C=0.1), "mjcf", tmp_path / "out", plant=screw
    )
    found = re.search(r'diaginertia="(\S+) ', (tmp_path / "out" / "axis_x.xml").read_text())
    assert float(found[1]) == pytest.approx(1e-4 + 20.0 * 1e-6, rel=1e-3)
