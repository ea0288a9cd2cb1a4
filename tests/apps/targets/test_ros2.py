"""Controllers for ros2_control, compiled with stand-ins for its headers and for rclcpp. ROS 2 itself was not run."""

import shutil
import subprocess
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from tests.exports.native import COMPILER, FLAGS, compiled, differing, walk

import bristle as br
from bristle.apps.targets.ros2 import write

HERE, DT, NAN = Path(__file__).parent / "ros2", 1e-3, np.nan
INCLUDED = (
    "controller_interface/chainable_controller_interface.hpp",
    "pluginlib/class_list_macros.hpp",
    "rclcpp/rclcpp.hpp",
    "sensor_msgs/msg/joint_state.hpp",
)
WARNINGS = (
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Wshadow",
    "-Werror",
    "-std=c++17",
    "-ffp-contract=off",
)
MODEL = br.friction.lugre(
    F_C="20 N", F_S="28 N", v_S="2 mm/s", sigma_0="10 N/um", sigma_1="1 kN*s/m"
)
AT_ONCE = ("gain=1.0", "slew=1e9", "a.lead=0.0")
CXX = shutil.which("g++") or shutil.which("clang++")
needs_compiler = pytest.mark.skipif(
    COMPILER is None or CXX is None, reason="needs compilers of C and C++"
)


def built(folder, model=MODEL, **options):
    """Return the command that runs a controller in the harness."""
    br.export(model, "ros2", folder, step=DT, **options)
    for name in INCLUDED:
        place = folder / "include" / name
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(f'#include "{HERE / "stand_ins.hpp"}"\n')
    own = [
        '-DCONTROLLER="axis_x_controller.cpp"',
        "-DTIME=rclcpp::Time{}",
        "-DDURATION(s)=rclcpp::Duration{s}",
    ]
    compiled(folder, "-O1", *FLAGS, "-c", "axis_x.c")
    sources = ("-I.", "-Iinclude", str(HERE / "harness.cpp"), "axis_x.o")
    compiled(folder, "-O1", *WARNINGS, *own, *sources, "-o", "harness", compiler=CXX)
    return str(folder / "harness")


@pytest.fixture(scope="module")
def harness(tmp_path_factory):
    return built(tmp_path_factory.mktemp("ros2") / "out")


def run(harness, mode, rows, *parameters, measured=0.0, names=2, dt=DT):
    """Return the commands of each cycle, shape (cycle, name), or the refusal of parameters; no cycle allocates memory."""
    content = np.ascontiguousarray(rows, dtype=float)
    line = [harness, mode, str(dt), str(float(measured)), *parameters]
    made = subprocess.run(line, input=content.tobytes(), capture_output=True, check=False)
    if made.returncode == 1:
        return made.stderr.decode()
    assert made.returncode == 0, made.stderr.decode()
    *commands, allocations = np.frombuffer(made.stdout)
    if mode == "chained":
        assert allocations == 0.0
    return np.array(commands).reshape(-1, names)


def rows_of(position=NAN, velocity=NAN, effort=NAN):
    """Return rows of references of the joint a; the joint b has none."""
    columns = np.broadcast_arrays(position, velocity, effort, NAN, NAN, NAN)
    return np.stack(columns, axis=1)


def python(model, x):
    with br.engine.interpreted():
        return br.engine.force_along(model, np.diff(x) / DT, DT, x[1:])


def test_the_package_contains_the_c_of_the_model_unchanged():
    model = br.friction.maxwell_slip(
        kind="rotational", F_C=20.0, k_i=[6e6, 3e6], nu_i=[0.4, 0.6], sigma_2=1e-5
    )
    for tunable in (False, True):
        request = br.exports.Request(model, "knee", DT, tunable=tunable)
        files, of_c = write(request).files, br.exports.TARGETS["c"].write(request).files
        for name in ("knee.h", "knee.c", "knee_selftest.c"):
            assert files[name] == of_c[name]
    plugin, package = (
        ElementTree.fromstring(files["knee_controller.xml"]),
        ElementTree.fromstring(files["package.xml"]),
    )
    described = plugin.find("class").attrib
    assert plugin.get("path") == package.findtext("name") == "knee_controller"
    assert described["base_class_type"] == "controller_interface::ChainableControllerInterface"
    assert f"class {described['type'].partition('::')[2]} :" in files["knee_controller.cpp"]
    yaml = pytest.importorskip("yaml").safe_load(files["knee_controller.yaml"])
    assert (
        yaml["controller_manager"]["ros__parameters"]["knee_friction"]["type"] == described["name"]
    )
    given = yaml["knee_friction"]["ros__parameters"]["joint_1"]["friction"]
    assert given == {"F_C": 20.0, "k_i": [6e6, 3e6], "nu_i": [0.4, 0.6], "sigma_2": 1e-5}
    assert "[N*m]" in files["knee_controller.cpp"]


@needs_compiler
@pytest.mark.slow
@pytest.mark.parametrize("mode", ["chained", "topic"])
def test_the_effort_is_that_of_bristle_to_the_last_bit(harness, mode):
    x = 0.3 + walk(100_000 if mode == "chained" else 5_000)
    force = python(MODEL, x)
    effort = run(harness, mode, rows_of(x[1:], effort=0.0), *AT_ONCE, measured=x[0])
    assert effort[0, 0] == 0.0
    assert differing(effort[1:, 0], force[1:]) == 0
    assert not np.any(effort[:, 1])
    added = run(harness, mode, rows_of(x[1:2000], effort=7.0), *AT_ONCE, measured=x[0])
    assert differing(added[1:, 0], 7.0 + force[1:1999]) == 0


@needs_compiler
@pytest.mark.slow
def test_the_first_cycle_adds_nothing_and_the_gain_rises_at_its_slew(harness):
    x = np.full(2001, 0.5)  # 20 % of the axis away from the measured position
    effort = run(harness, "chained", rows_of(x, effort=3.0), "gain=0.5", "slew=0.25", measured=0.3)[
        :, 0
    ]
    level = MODEL.values["F_C"]
    assert effort[0] == 3.0
    assert np.abs(np.diff(effort)).max() < 0.25 * DT * 1.5 * MODEL.values["F_S"]
    assert effort[-1] > 3.0 + 0.4 * level


@needs_compiler
@pytest.mark.slow
def test_a_velocity_alone_is_integrated_from_the_measured_position(harness):
    v = 1e-3 * np.sin(np.arange(3000) * DT)
    x = 0.3 + np.concatenate([[0.0], np.cumsum(v * DT)])
    effort = run(harness, "chained", rows_of(velocity=v), *AT_ONCE, measured=0.3)[:, 0]
    force = python(MODEL, x)
    # Rounding of the sum times the stiffness.
    assert effort[1:] == pytest.approx(force[1:], rel=0.0, abs=1e-3)
    assert np.ptp(force) > 20.0


@needs_compiler
@pytest.mark.slow
def test_a_lost_reference_fades_and_the_contact_begins_anew(harness):
    x = np.linspace(0.0, 1e-3, 400)
    lost = np.where((np.arange(400) >= 100) & (np.arange(400) < 200), NAN, x)
    effort = run(
        harness, "chained", rows_of(lost, effort=1.0), "gain=1.0", "slew=20.0", "a.lead=0.0"
    )[:, 0]
    assert np.isfinite(effort).all()
    assert np.all(effort[160:200] == 1.0)  # faded in 50 cycles
    assert effort[200] == 1.0
    again = run(
        harness,
        "chained",
        rows_of(x[200:], effort=1.0),
        "gain=1.0",
        "slew=20.0",
        "a.lead=0.0",
        measured=x[200],
    )[:, 0]
    assert differing(effort[201:], again[1:]) == 0
    assert np.all(run(harness, "chained", rows_of(np.full(50, NAN)), *AT_ONCE) == 0.0)


@needs_compiler
@pytest.mark.slow
def test_a_topic_that_falls_silent_is_no_reference(harness):
    x = np.linspace(0.0, 1e-3, 600)
    silent = np.where(np.arange(600) < 300, x, np.inf)
    effort = run(
        harness,
        "topic",
        rows_of(silent),
        "gain=1.0",
        "slew=20.0",
        "a.lead=0.0",
        "reference_timeout=0.05",
    )[:, 0]
    assert effort[340] > 15.0
    assert np.all(effort[420:] == 0.0)


@needs_compiler
@pytest.mark.slow
def test_lead_limit_and_gain_are_parameters(harness):
    x = np.linspace(0.0, 2e-3, 500)
    limited = run(harness, "chained", rows_of(x), *AT_ONCE, "a.limit=5.0", "b.limit=5.0")[:, 0]
    assert limited.max() == 5.0
    early, late = (
        run(harness, "chained", rows_of(x), *AT_ONCE, f"a.lead={lead}")[:, 0]
        for lead in ("0.002", "0.0")
    )
    assert early[100] > late[100]
    changed = run(harness, "chained", rows_of(x), *AT_ONCE, "@300:gain=0.0", "@400:gain=2.0")[:, 0]
    assert np.all(changed[301:] == 0.0)  # and a gain beyond its range is refused
    both = run(
        harness,
        "chained",
        rows_of(x, 0.1),
        *AT_ONCE,
        "command_interfaces=position,velocity,effort",
        names=6,
    )
    assert differing(both[:, 0], x) == 0
    assert np.all(both[:, 1] == 0.1)
    for wrong in (
        "command_interfaces=position,velocity",
        "command_interfaces=effort,torque",
        "command_interfaces=effort,effort",
    ):
        assert run(harness, "chained", rows_of(x), wrong).startswith("command_interfaces: must")


@needs_compiler
@pytest.mark.slow
def test_friction_of_each_joint_is_a_parameter_of_a_tunable_export(tmp_path):
    model = br.friction.maxwell_slip(F_C=20.0, k_i=[6e6, 3e6], nu_i=[0.4, 0.6])
    tuned, x = built(tmp_path / "out", model, tunable=True), 1e-2 * walk(2000)
    effort = run(
        tuned,
        "chained",
        rows_of(x[1:]),
        *AT_ONCE,
        "a.friction.F_C=31.5",
        "a.friction.k_i=6e6,1e6",
        measured=x[0],
    )[:, 0]
    expected = python(model.with_values(F_C=31.5, k_i=[6e6, 1e6]), x)
    assert differing(effort[1:], expected[1:]) == 0
    assert run(tuned, "chained", rows_of(x), "b.friction.F_C=-1.0").startswith(
        "b.friction: a parameter is outside its range"
    )
    assert run(tuned, "chained", rows_of(x), "a.friction.k_i=6e6,1e6,2.0").startswith(
        "a.friction.k_i: must have 2 numbers"
    )


def test_an_amplifier_in_velocity_mode_is_refused():
    with pytest.raises(br.core.InputError, match="ros2: feeds an effort forward"):
        write(br.exports.Request(MODEL, "axis_x", DT, mode="velocity"))
