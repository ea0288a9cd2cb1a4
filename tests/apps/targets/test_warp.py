"""Actuators for robot simulators: forces of bristle in every axis of a Warp array, in Newton, and behind the interface of Isaac Lab."""

import ast
import importlib
import sys
import types

import numpy as np
import pytest
from tests.exports.native import example_with

import bristle as br
from bristle.apps.targets.warp import write
from bristle.exports.described import Request
from bristle.exports.tunable import tunable_of

DT, AXES, SAMPLES = 5e-4, 48, 300
ELEMENTS = br.friction.maxwell_slip(F_C="20 N", k_i=["6 N/um", "3 N/um"], nu_i=[0.4, 0.6])
INFO = {
    "bands": {
        "draws": {
            "F_C": np.array([18.0, 22.0]),
            "nu_i": np.array([[0.3, 0.7], [0.5, 0.5]]),
            "M": np.array([1.0, 2.0]),
        }
    }
}


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """Return a function that exports a model and imports one of its files."""
    warp = pytest.importorskip("warp")
    folder = tmp_path_factory.mktemp("exported")
    warp.config.quiet, warp.config.kernel_cache_dir = True, str(folder / "kernels")
    sys.path.insert(0, str(folder))

    def module(model, name, kind="warp", info=None):
        for file, text in write(Request(model, name, DT, info=info or {})).files.items():
            (folder / file).write_text(text, encoding="utf-8")
        importlib.invalidate_caches()
        return importlib.import_module(f"{name}_{kind}")

    yield module
    sys.path.remove(str(folder))


def walks(reach=2e-6):
    """Return the position of each axis along its own random walk, shape (sample, axis)."""
    return np.cumsum(reach * np.random.default_rng(4).standard_normal((SAMPLES, AXES)), axis=0)


def along(friction, x, dtype=np.float64):
    """Return the force of each axis at each sample."""
    import warp

    kind = {np.float64: warp.float64, np.float32: warp.float32}[dtype]
    return np.array(
        [
            friction.force(warp.array(row.astype(dtype), dtype=kind, device="cpu"), DT).numpy()
            for row in x
        ]
    )


def test_files_are_python():
    files = write(Request(ELEMENTS, "knee", DT)).files
    assert set(files) == {"knee_warp.py", "knee_newton.py", "knee_isaaclab.py", "README.md"}
    for file in set(files) - {"README.md"}:
        compile(files[file], file, "exec")


def constants_of(model, info):
    """Return NUMBERS and DRAWS of the written module."""
    text = write(Request(model, "knee", DT, info=info)).files["knee_warp.py"]
    assigned = {
        node.targets[0].id: ast.unparse(node.value)
        for node in ast.parse(text).body
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name)
    }
    return [eval(assigned[name], {"float": float}) for name in ("NUMBERS", "DRAWS")]


def test_draws_are_written_with_one_column_for_each_number():
    numbers, draws = constants_of(ELEMENTS, INFO)
    assert draws == {"F_C": [18.0, 22.0], "nu_i_0": [0.3, 0.5], "nu_i_1": [0.7, 0.5]}
    assert numbers == {
        "F_C": 20.0,
        "k_i_0": 6e6,
        "k_i_1": 3e6,
        "nu_i_0": 0.4,
        "nu_i_1": 0.6,
        "sigma_2": 0.0,
    }


@pytest.mark.fast_cases(2)
@pytest.mark.slow
@pytest.mark.parametrize("name", br.friction.MODELS)
def test_draws_of_an_asymmetric_model_cover_every_number(name):
    model = example_with(name, ["asymmetry"])
    draws = {key: np.stack([value, value]) for key, value in tunable_of(model).values.items()}
    numbers, drawn = constants_of(model, {"bands": {"draws": draws}})
    assert drawn == {key: [value, value] for key, value in numbers.items()}
    assert len(drawn) > len(constants_of(example_with(name), {})[0])


@pytest.mark.slow
@pytest.mark.parametrize("name", br.friction.MODELS)
def test_each_axis_has_the_forces_of_bristle_to_the_bit(exported, name):
    model, x = example_with(name), walks()
    friction = exported(model, f"same_{name}").Friction(AXES, "cpu")
    forces = along(friction, x)
    at_rest = Request(model, name, DT, rest="middle").sampled
    expected = np.transpose([br.response(at_rest, x[:, axis], DT) for axis in range(AXES)])
    assert np.ptp(forces) > 0.0
    assert not np.any(friction.flags)
    assert np.array_equal(forces[1:], expected[1:])


@pytest.mark.slow
@pytest.mark.parametrize(
    "levels", [("F_C",), ("F_C_pos", "F_C_neg")], ids=["symmetric", "asymmetric"]
)
def test_axes_with_drawn_parameters_have_their_own_forces(exported, levels):
    drawn = {"nu_i": np.array([[0.3, 0.7], [0.5, 0.5]])} | {
        name: np.array([18.0, 22.0]) - k for k, name in enumerate(levels)
    }
    values = {name: ELEMENTS.values[name] for name in ("k_i", "nu_i")} | dict.fromkeys(levels, 20.0)
    friction = br.friction.with_slots(br.friction.maxwell_slip, ["asymmetry"] * (len(levels) - 1))(
        **values
    )
    module, x = (
        exported(friction, f"drawn_{len(levels)}", info={"bands": {"draws": drawn}}),
        walks(),
    )
    axes = module.Friction(AXES, "cpu")
    axes.draw(seed=1)
    rows = [dict(zip(module.NUMBERS, row, strict=True)) for row in axes.parameters.numpy()]
    first = [row[levels[0]] == 18.0 for row in rows]
    assert 0 < sum(first) < AXES
    own = {
        of: friction.with_values(**{name: value[int(not of)] for name, value in drawn.items()})
        for of in (True, False)
    }
    assert all(
        row[levels[-1]] == own[of].values[levels[-1]] for of, row in zip(first, rows, strict=True)
    )
    assert np.array_equal(
        along(axes, x),
        np.transpose([br.response(own[of], x[:, at], DT) for at, of in enumerate(first)]),
    )


@pytest.mark.slow
def test_reset_makes_some_contacts_virgin_and_keeps_their_parameters(exported):
    import warp

    module, x = exported(ELEMENTS, "again"), walks()
    friction, virgin = module.Friction(AXES, "cpu"), module.Friction(AXES, "cpu")
    friction.parameters[:, 0].fill_(15.0)
    virgin.parameters[:, 0].fill_(15.0)
    along(friction, x)
    chosen = np.arange(AXES) % 3 == 0
    friction.reset(warp.array(chosen, dtype=warp.bool, device="cpu"))
    again, first = along(friction, x), along(virgin, x)
    assert np.array_equal(again[:, chosen], first[:, chosen])
    assert not np.any(np.all(again[:, ~chosen] == first[:, ~chosen], axis=0))


@pytest.mark.slow
def test_positions_in_single_precision_err_by_their_rounding_times_the_stiffness(exported):
    module, x = exported(ELEMENTS, "single"), walks() + 0.25
    double, single = (
        along(module.Friction(AXES, "cpu"), x),
        along(module.Friction(AXES, "cpu"), x, np.float32),
    )
    rounding = np.max(np.abs(x.astype(np.float32) - x))
    assert 0.0 < np.max(np.abs(single - double)) <= 4.0 * 9e6 * rounding


@pytest.mark.slow
def test_an_invalid_position_or_parameter_is_flagged_and_repeats_the_force(exported):
    module, x = exported(ELEMENTS, "faulty"), walks()
    friction = module.Friction(AXES, "cpu")
    before = along(friction, x)[-1]
    x[-1, 5] = np.nan
    friction.parameters[7:8, 0].fill_(-1.0)
    after = along(friction, x[-1:])[0]
    assert np.array_equal(np.flatnonzero(friction.flags), [5, 7])
    assert after[5] == before[5]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["maxwell_slip", "preisach_lugre"])
def test_warp_compiles_it_for_a_graphics_processor_without_fused_operations(
    exported, name, tmp_path
):
    import warp

    module = exported(example_with(name), f"ptx_{name}")
    (path,) = warp.compile_aot_module(module, arch=80, use_ptx=True, module_dir=tmp_path)
    assert ".entry step_axes" in path.read_text()
    assert "fma.rn.f64" not in path.read_text()


def held(step, effort=15.0, mass=28.0, duration=2.0):
    """Return the positions of a mass under a constant effort, by semi-implicit Euler with ``step(x, v)`` as friction."""
    x, v, positions = 0.0, 0.0, []
    for _ in range(round(duration / DT)):
        v += DT / mass * (effort - step(x, v))
        x += DT * v
        positions.append(x)
    return np.array(positions)


@pytest.mark.slow
def test_a_mass_on_predicted_friction_holds_and_on_past_friction_creeps(exported):
    import warp

    module = exported(ELEMENTS, "held")

    def friction_of(*, predicted):
        axis = module.Friction(1, "cpu")

        def step(x, v):
            place, speed = (
                warp.array([value], dtype=warp.float64, device="cpu") for value in (x, v)
            )
            return float(axis.force(place, DT, speed if predicted else None).numpy()[0])

        return step

    rest = held(friction_of(predicted=True))
    assert np.ptp(rest[-1000:]) < 1e-12
    bristle = br.engine.run_open_loop(
        br.plants.inertia(M="28 kg"), ELEMENTS, np.full(rest.size, 15.0), DT
    ).position
    assert abs(rest[-1] - bristle[-1]) < 0.15 * abs(bristle[-1])
    assert np.ptp(held(friction_of(predicted=False))[-1000:]) > 1e-6


@pytest.mark.slow
def test_newton_holds_a_joint_below_break_away_and_moves_a_joint_above(exported):
    newton = pytest.importorskip("newton")
    module = exported(ELEMENTS, "joint", "newton")
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
    for values in ({}, {"F_C": 10.0}):
        link = builder.add_link(mass=28.0, inertia=np.eye(3))
        joint = builder.add_joint_prismatic(-1, link, axis=newton.Axis.X)
        builder.add_articulation([joint])
        builder.add_actuator(module.DriveFriction, index=builder.joint_qd_start[joint], **values)
    model = builder.finalize(device="cpu")
    (actuator,) = model.actuators
    solver = newton.solvers.SolverFeatherstone(model)
    now, after, control, before, following = (
        model.state(),
        model.state(),
        model.control(),
        actuator.state(),
        actuator.state(),
    )
    newton.eval_fk(model, model.joint_q, model.joint_qd, now)
    positions = []
    for _ in range(2000):
        control.joint_f.fill_(15.0)
        now.clear_forces()
        actuator.step(now, control, before, following, DT)
        solver.step(now, after, control, None, DT)
        now, after, before, following = after, now, following, before
        positions.append(now.joint_q.numpy().copy())
    rest, moving = np.transpose(positions)
    assert np.ptp(rest[-500:]) < 1e-9
    slipping = br.engine.run_open_loop(
        br.plants.inertia(M="28 kg"), ELEMENTS.with_values(F_C=10.0), np.full(2000, 15.0), DT
    )
    assert abs(moving[-1] - slipping.position[-1]) < 1e-3 * slipping.position[-1]
    with pytest.raises(ValueError, match="unknown parameters: F_X"):
        module.DriveFriction.resolve_arguments({"F_X": 1.0})


class IdealPDActuator:
    """A stand-in for the class of Isaac Lab: the constructor, names and shapes of its source, without its configuration."""

    def __init__(
        self, cfg, joint_names, joint_ids, num_envs, device, stiffness=0.0, damping=0.0, **_
    ):
        import torch

        self.cfg, self._num_envs, self._device, self._joint_names = (
            cfg,
            num_envs,
            device,
            joint_names,
        )
        self.stiffness, self.damping = stiffness, damping
        self.computed_effort = torch.zeros(num_envs, len(joint_names), device=device)
        self.applied_effort = torch.zeros_like(self.computed_effort)

    num_joints = property(lambda self: len(self._joint_names))

    def reset(self, env_ids):
        pass

    def compute(self, control_action, joint_pos, joint_vel):
        error = control_action.joint_positions - joint_pos
        self.computed_effort = (
            self.stiffness * error - self.damping * joint_vel + control_action.joint_efforts
        )
        self.applied_effort = self.computed_effort.clip(-30.0, 30.0)
        control_action.joint_efforts = self.applied_effort
        control_action.joint_positions = control_action.joint_velocities = None
        return control_action


@pytest.mark.slow
def test_an_actuator_of_isaac_lab_subtracts_the_friction_and_resets_its_environments(
    exported, monkeypatch
):
    torch = pytest.importorskip("torch")
    stand_in = types.SimpleNamespace(IdealPDActuator=IdealPDActuator, IdealPDActuatorCfg=object)
    monkeypatch.setitem(sys.modules, "isaaclab.actuators", stand_in)
    monkeypatch.setitem(
        sys.modules, "isaaclab.utils", types.SimpleNamespace(configclass=lambda cls: cls)
    )
    module = exported(ELEMENTS, "arm", "isaaclab")
    environments, joints = 12, 4
    actuator = module.FrictionActuator(
        module.FrictionActuatorCfg(), list("abcd"), slice(None), environments, "cpu", stiffness=1e6
    )
    x = torch.from_numpy(walks().reshape(SAMPLES, environments, joints)).float()

    def efforts():
        rows = []
        for row in x:
            # Other joints of the articulation lie between these: the rows are not contiguous.
            place, zero = torch.stack((row, row), dim=-1)[..., 0], torch.zeros_like(row)
            action = types.SimpleNamespace(
                joint_positions=zero, joint_velocities=zero, joint_efforts=zero
            )
            done = actuator.compute(action, place, zero)
            assert done.joint_efforts is actuator.applied_effort
            rows.append(actuator.applied_effort - (-1e6 * row).clip(-30.0, 30.0))
        return -torch.stack(rows).numpy()

    first = efforts()
    # Predicted at rest, the friction is that of a step of length 0 after the step to x.
    stopped = np.repeat(x.numpy().astype(float).reshape(SAMPLES, -1)[:, 3], 2)
    assert np.allclose(
        first.reshape(SAMPLES, -1)[:, 3], br.response(ELEMENTS, stopped, DT)[1::2], atol=1e-5 * 20.0
    )
    actuator.reset([2, 5])
    again = efforts()
    same = [bool(np.array_equal(first[:, at], again[:, at])) for at in range(environments)]
    assert np.array_equal(np.flatnonzero(same), [2, 5])
    actuator.reset(None)
    assert np.array_equal(first, efforts())
