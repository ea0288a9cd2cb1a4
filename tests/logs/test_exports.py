"""Files of other programs: each is understood untold, and the same numbers come from all of them."""

import re

import numpy as np
import pytest
from tests.logs.binary_exports import BINARY
from tests.logs.exports import EXPORTS, RATED, motion

from bristle.core import InputError
from bristle.files.axis import axis_from, read_axis
from bristle.files.proposal import propose_axis
from bristle.logs import read_log, summarize
from bristle.logs.readers import read_table

ALL = EXPORTS | BINARY
MOTION = motion()


@pytest.mark.fast_cases(2)
@pytest.mark.parametrize("name", ALL)
def test_a_log_of_another_program_is_read_and_its_axis_file_proposed(tmp_path, name):
    export = ALL[name]
    path = export.write(tmp_path, MOTION)
    proposal = propose_axis(path)
    assert (set(proposal.missing), len(proposal.missing) <= 2) == (set(export.filled), True)
    assert summarize(path, proposal.axis)["problems"] == []
    text = proposal.text
    for key, value in export.filled.items():
        last = key.rpartition(".")[2]
        channel = key.split(".")[1] if key.startswith("columns") else ""
        text, count = re.subn(rf'(?m)^({channel}.*?{last} = )"\?"', rf'\1"{value}"', text, count=1)
        assert count == 1
    file = tmp_path / "axis.toml"
    file.write_text(text, encoding="utf-8")
    axis = read_axis(file)
    log = read_log(path, axis)
    assert (axis.kind, log.sample_time) == ("translational", pytest.approx(1e-3, rel=1e-12))
    at = np.round(log.position.values * 1e6).astype(int)
    first = int(np.flatnonzero(MOTION.position_um == at[0])[0])
    expected = slice(first, first + len(log))
    assert len(log) >= 0.99 * MOTION.time_us.size
    np.testing.assert_allclose(
        log.position.values, 1e-6 * MOTION.position_um[expected], rtol=1e-12, atol=1e-18
    )
    truth = 1e-3 * RATED * MOTION.torque[expected]
    if export.exact:
        np.testing.assert_allclose(log.effort.values, truth, rtol=1e-12, atol=1e-12)
    else:
        assert np.sqrt(np.mean((log.effort.values - truth) ** 2)) < 0.1 * np.std(truth)
        assert [finding.code for finding in log.findings] == ["resampled"]
    if log.reference is not None:
        np.testing.assert_allclose(
            log.reference.values, 1e-6 * MOTION.reference_um[expected], rtol=1e-12, atol=1e-18
        )


def torque_log(torque):
    """A log without units, as the scope of a controller writes it."""
    rows = [
        f"{1e-3 * i:.3f};{10.0 * np.sin(0.01 * i):.4f};{value}" for i, value in enumerate(torque)
    ]
    return "\n".join(["time;ActPos;ActTorque", *rows]).encode()


@pytest.mark.parametrize(
    ("factor", "digits", "unit"),
    [(8.16, 1, "?"), (81.6, 0, "?"), (816.0, 0, "‰"), (81600.0, 0, "?"), (0.816, 3, "?")],
)
def test_numbers_alone_do_not_separate_per_cent_from_per_mille(factor, digits, unit):
    wave = np.sign(np.cos(0.01 * np.arange(2000))) + 0.1 * np.random.default_rng(1).standard_normal(
        2000
    )
    text = propose_axis(
        torque_log(np.round(factor * wave, digits) if digits else (factor * wave).astype(int))
    ).text
    line = next(line for line in text.splitlines() if line.startswith("effort"))
    assert (f'unit = "{unit}"' in line, line.count("#")) == (True, 1)
    assert factor != 81.6 or '"%" or "‰" of rated' in line


def arm_log(pull, unit="Nm"):
    """A joint that swings through a radian or two, with what pulls at it beside inertia and friction."""
    t = 1e-3 * np.arange(8000)
    q = 1.2 * np.sin(2.0 * t) + 0.3 * np.sin(5.3 * t)
    v, a = np.gradient(q, t), np.gradient(np.gradient(q, t), t)
    torque = (
        1.5 * a
        + 4.0 * np.sign(v)
        + 6.0 * v
        + pull(q)
        + 0.1 * np.random.default_rng(2).standard_normal(t.size)
    )
    rows = [
        f"{time:.3f};{np.degrees(angle):.5f};{effort:.4f}"
        for time, angle, effort in zip(t, q, torque, strict=True)
    ]
    return "\n".join([f"t [s];joint_pos [deg];joint_torque [{unit}]", *rows]).encode()


@pytest.mark.parametrize(
    ("pull", "named"),
    [
        (lambda q: 30.0 * np.sin(q + 0.3), True),
        (lambda q: 30.0 * q, False),
        (lambda q: 10.0 * q * q, False),
        (lambda q: 0.0 * q, False),
    ],
    ids=["link", "spring", "parabola", "nothing"],
)
def test_an_arm_is_proposed_to_be_one(pull, named):
    proposal = propose_axis(arm_log(pull))
    remark = 'gravity = "link"  # the effort depends on' in proposal.text
    assert (remark, proposal.axis.gravity, read_axis(proposal.text.encode()).gravity) == (
        named,
        named,
        named,
    )


def lagging(name):
    """A position that sticks behind a reference in the same unit."""
    t = 1e-3 * np.arange(2000)
    reference = 10.0 * np.sin(6.0 * t)
    position = 4.0 * np.sin(6.0 * t - 1.2)
    rows = [
        f"{a:.3f};{b:.4f};{c:.4f};{d:.4f}"
        for a, b, c, d in zip(t, position, reference, np.sign(reference), strict=True)
    ]
    return "\n".join([f"Zeit [s];Weg [mm];{name} [mm];Kraft [N]", *rows]).encode()


def test_a_reference_is_known_by_the_name_of_the_position_however_far_it_is():
    assert (
        'reference = { column = "Sollweg", unit = "mm" }' in propose_axis(lagging("Sollweg")).text
    )
    assert "reference" not in propose_axis(lagging("Sollhub")).text


def turning_log(step):
    """A rotary table in degrees whose encoder has such a step, written with four digits, or none that shows."""
    digits = 4 if step else 7
    t = 1e-3 * np.arange(3000)
    angle = 0.3 * np.sin(2.0 * t)
    angle = (
        step * np.round(angle / step)
        if step
        else angle + 1e-3 * np.random.default_rng(1).normal(size=t.size)
    )
    rows = [
        f"{a:.3f};{b:.{digits}f};{c:.2f}"
        for a, b, c in zip(t, angle, 40.0 * np.sign(np.cos(2.0 * t)), strict=True)
    ]
    return "\n".join(["t [s];Angle [deg];Torque [%]", *rows]).encode()


@pytest.mark.parametrize(("step", "says"), [(5e-4, True), (3.333e-4, False), (0.0, False)])
def test_of_an_axis_that_turns_a_torque_is_asked_for_and_clear_steps_are_named(step, says):
    text = propose_axis(turning_log(step)).text
    assert 'rated = "?"  # effort at 100 %, such as "1.3 N*m"\n' in text
    assert ('\n# [encoder]\n# resolution = "0.0005 deg"  # ' in text) is says
    assert ("resolution" in text) is says
    if says:  # as it would be without the marks of a comment
        message = (
            text.replace("# [encoder]", "[encoder]")
            .replace("# resolution", "resolution")
            .replace('gear_ratio = "?"', "")
            .replace('"?"', '"1 N*m"')
        )
        assert read_axis(message.encode()).resolution == pytest.approx(np.deg2rad(step))


def test_missing_values_in_a_proposal_name_their_source(tmp_path):
    rows = [
        f"{i};{int(1e4 * np.sin(0.01 * i))};{np.sign(np.cos(0.01 * i)) + 0.01 * (i % 3):.2f}"
        for i in range(2000)
    ]
    counts = "\n".join(["t [ms];enc [count];torque [%]", *rows]).encode()
    text = propose_axis(counts).text
    sources = (
        'lead = "10 mm", travel per turn of the motor, under [transmission]',
        'counts_per_rev = 8192 and side = "motor"',
    )
    assert [source for source in sources if source not in text] == []


@pytest.mark.parametrize("name", [name for name in EXPORTS if name.startswith("SINUMERIK")])
def test_a_trace_of_a_sinumerik_is_called_one(tmp_path, name):
    path = EXPORTS[name].write(tmp_path, motion(0.5))
    assert read_table(path).format.startswith("SINUMERIK trace")


CANDUMPS = {
    "log": "(1436509052.{0:06d}) vcan0 {1:03X}#{2:016X}",
    "for the eye": "  can0  {1:03X}   [8]  11 22 33 44 55 66 77 {3:02X}",
    "dated, extended": " (2024-03-14 09:31:12.{0:06d})  can1  TX - -  18FF{1:04X}   [4]  00 01 02 {3:02X}",
    "flexible rate": "(0.{0:06d}) can0 {1:03X}##1{2:016X}",
}


@pytest.mark.parametrize("name", CANDUMPS)
def test_frames_of_a_bus_are_refused_with_advice_on_decoding(name):
    lines = [CANDUMPS[name].format(i, 0x100 + i % 7, 7919 * i, i % 256) for i in range(300)]
    with pytest.raises(InputError, match=r"candump.*DBC.*cantools or asammdf"):
        read_log("\n".join(lines).encode())


def test_a_table_of_hexadecimal_names_is_no_bus():
    rows = ["t 123#1 456#2"] + [f"{0.001 * i:.3f} {i % 9} {i % 5}" for i in range(100)]
    assert len(read_table("\n".join(rows).encode()).columns) == 3


def test_channels_of_a_trace_keep_their_shift_against_each_other(tmp_path):
    table = read_table(EXPORTS["twincat, rates"].write(tmp_path, MOTION))
    position, torque = (table.columns[table.stamps[name]] for name in ("ActPos", "ActTorque"))
    assert table.units[table.stamps["ActPos"]] == "ms"
    assert (position[0], torque[0], position[-1], torque[-1]) == pytest.approx(
        (0.0, 4.0, 3999.0, 3998.0)
    )


def test_samples_before_and_behind_a_channel_that_is_recorded_later_are_left_out_with_a_note(
    tmp_path,
):
    effort = {"column": "ActTorque", "unit": "N"}
    described = axis_from(
        {"schema": 1, "kind": "translational", "columns": {"position": "ActPos", "effort": effort}}
    )
    log = read_log(EXPORTS["twincat, rates"].write(tmp_path, MOTION), described)
    (count,) = (
        int(note.split()[2])
        for note in log.notes
        if note.endswith("at the ends, where column ActTorque has no values")
    )
    assert len(log) == 4000 - count
    assert 4 <= count <= 5
