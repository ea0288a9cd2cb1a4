"""Tables and sentences of loops: errors in a common unit, parts with values, gains in units of the drive."""

import math
from types import SimpleNamespace as Some

import numpy as np
from tests.loop.conftest import loop
from tests.report.known import UNSTABLE, assessed

from bristle import controllers, friction
from bristle.core import Status, number
from bristle.core.axis import Axis
from bristle.core.diagnostic import Diagnostic
from bristle.core.experiment import Feedforward
from bristle.report import loops as report
from bristle.report.loops import component_table, direction_table, law_lines, parts_table, run_table, variant_table
from bristle.report.sentences import SENTENCES
from bristle.simulation.statistics import Statistics


def errors(peak, rms=0.0, mean=0.0):
    return Statistics(peak_to_peak=peak, rms=rms, mean=mean, std=0.0, min=-peak, max=0.5 * peak)


def ran(name, peak, *, status=Status.OK, is_open=False):
    by_direction = {"forward": errors(0.5 * peak, 0.25 * peak, 1e-7), "backward": errors(0.25 * peak, 0.125 * peak, -1e-7)}
    return Some(
        name=name,
        status=status,
        is_open=is_open,
        following_error=errors(peak, 0.25 * peak, -1e-7),
        true_error=errors(2.0 * peak),
        motion=errors(peak),
        effort_rms=2.0,
        effort_peak=5.0,
        by_direction=by_direction,
    )


def result(*variants, kind="translational"):
    return Some(variants={variant.name: variant for variant in variants}, experiment=Some(kind=kind))


def test_errors_of_loops_have_the_unit_of_the_smallest():
    table = variant_table(result(ran("a", 8e-3), ran("b", 4e-6)))
    assert table.caption == "The variants of the loop"
    assert table.heads == [
        "Variant",
        "Following error, peak to peak [µm]",
        "rms [µm]",
        "mean [µm]",
        "True error, peak to peak [µm]",
        "Force, rms [N]",
        "peak [N]",
    ]
    assert table.rows == [
        ["a", "8000.00", "2000.00", "−0.10", "16000.00", "2.00", "5.00"],
        ["b", "4.00", "1.00", "−0.10", "8.00", "2.00", "5.00"],
    ]


def test_smallest_unit_of_loop_errors_is_the_micrometre():
    table = variant_table(result(ran("a", 3e-8), ran("b", 4e-9)))
    assert table.heads[1] == "Following error, peak to peak [µm]"
    assert [row[1] for row in table.rows] == ["0.03000", "0.00400"]
    assert variant_table(result(ran("a", 3e-2), ran("b", 2e-3))).heads[1] == "Following error, peak to peak [mm]"


def test_measured_errors_are_in_the_first_row():
    table = variant_table(result(ran("a", 4e-6)), errors(6e-6, 3e-6, 1e-6))
    assert table.rows[0] == ["measured", "6.00", "3.00", "1.00", "–", "–", "–"]
    assert table.rows[1][0] == "a"


def test_diverged_loop_has_dashes_and_a_remark():
    table = variant_table(result(ran("a", 4e-6), ran("b", 1e-9, status=Status.NOT_FINITE), ran("c", 4e-6, status=Status.TOLERANCE_MISSED)))
    assert table.rows[1] == ["b", *["–"] * 6, Status.NOT_FINITE.sentence]
    assert [row[-1] for row in table.rows[::2]] == ["", Status.TOLERANCE_MISSED.sentence]
    assert table.heads[1].endswith("[µm]")


def test_open_loops_are_reported_by_their_motion():
    table = variant_table(result(ran("a", 4e-3, is_open=True), kind="rotational"))
    assert table.caption == "The variants"
    assert table.heads == ["Variant", "Position, peak to peak [mrad]", "lowest [mrad]", "highest [mrad]", "Torque, rms [N·m]", "peak [N·m]"]
    assert table.rows == [["a", "4.00", "−4.00", "2.00", "2.00", "5.00"]]
    assert variant_table(result(ran("a", 4e-3, is_open=True), ran("b", 1.0))).caption == "The variants of the loop"
    assert variant_table(result()).caption == "The variants of the loop"


def test_errors_are_listed_by_direction_of_the_reference():
    table = direction_table(result(ran("a", 8e-6), ran("b", 1e-9, status=Status.NOT_FINITE)))
    assert table.heads == ["Variant", "Direction", "Mean [µm]", "rms [µm]", "Peak to peak [µm]"]
    assert table.rows == [["a", "forward", "0.10", "2.00", "4.00"], ["a", "backward", "−0.10", "1.00", "2.00"]]


def test_parts_of_a_loop_have_their_values():
    law = controllers.cascade(k_p=80.0, k_v=4000.0)
    table = component_table("parts", [("Controller", law), ("Friction", friction.coulomb(F_C=8.0)), ("Fed forward", None)])
    assert (table.caption, table.heads) == ("parts", ("Part", "Model", "Parameters"))
    assert table.rows[1:] == [("Friction", "coulomb", "F_C = 8 N"), ("Fed forward", "none", "")]
    assert table.rows[0][:2] == ("Controller", "cascade")
    assert table.rows[0][2].startswith("k_p = 80 1/s, k_v = 4000 N·s/m")


def test_list_of_numbers_is_reported_by_size_and_range():
    model = Some(values={"K_i": np.array([1e6, 3e6]), "shape": "round"}, name="m", kind="translational")
    model.component = Some(variables=dict.fromkeys(model.values, Some(unit=lambda kind: "N/m")))
    ((_, _, text),) = component_table("parts", [("Friction", model)]).rows
    assert text == f"K_i = 2 values, {number(1e6)} to {number(3e6)} N/m, shape = round"


def test_open_loop_has_no_controller():
    closed = [row[0] for row in parts_table(loop()).rows]
    assert closed == ["Plant", "Friction", "Controller", "Sensor", "Reference", "Friction feedforward"]
    table = parts_table(Some(**{name: getattr(loop(), name) for name in ("name", "plant", "friction", "sensor")}, effort=Some()))
    assert [row[0] for row in table.rows] == ["Plant", "Friction", "Sensor"]
    assert table.caption == "The parts of " + loop().name


def test_run_settings_have_units():
    run = Some(duration=1.25, settle=0.5, sample_time=1e-3, tolerance=0.0, substeps=4, delay=2, effort_limit=math.inf)
    variant = Some(name="a", run=run, plant=Some(kind="translational"), feedforward=Some(mass=20.0, gain=0.5))
    table = run_table([variant])
    assert dict(zip(table.heads, table.rows[0], strict=True)) == {
        "Variant": "a",
        "Duration": "1.25 s",
        "Left out at the start": "500 ms",
        "Sample time": "1 ms",
        "Steps in a sample": "4",
        "Delay [samples]": "2",
        "Effort limit": "∞ N",
        "Mass feedforward": "20 kg",
        "Factor on friction feedforward": "0.5",
    }
    run.tolerance = 1e-9
    assert dict(zip(table.heads, run_table([variant]).rows[0], strict=True))["Steps in a sample"] == "adaptive, to within 1 nm of position"


def lines(**changes):
    return [line.replace("\u00a0", " ") for line in law_lines(loop(**changes))]


def test_gains_are_listed_with_feedforward_of_friction_and_mass():
    law = controllers.cascade(k_p=80.0, k_v=4000.0)
    contact = friction.coulomb(F_C=8.0)
    whole = lines(controller=law, feedforward=Feedforward(friction=contact, mass=20.0))
    assert whole == [
        "law cascade: k_p 80 1/s, k_v 4000 N·s/m, averaging 1",
        f"friction feedforward: coulomb, along the {Feedforward().along} motion",
        "inertia feedforward: acceleration × 20 kg",
    ]
    assert lines(controller=law, feedforward=Feedforward(friction=contact, gain=0.5))[1:] == [
        f"friction feedforward: coulomb × 0.5, along the {Feedforward().along} motion"
    ]
    assert lines(controller=law, feedforward=Feedforward()) == whole[:1]
    at_motor = lines(controller=law, feedforward=Feedforward(), axis=Axis(arm=0.8e-3))
    assert at_motor == ["law cascade: k_p 80 1/s, k_v 4000 N·s/m (0.00256 N*m*s/rad at the motor), averaging 1"]


def test_loops_with_the_same_warning_share_a_line():
    judged = {"a": assessed("a", 15.0, switches=True), "b": assessed("b", 15.0), "c": assessed("c", 15.0, gain=UNSTABLE)}
    reported = report.about_loops(judged, {"d": Diagnostic("switching_law", "", "note")})
    assert [(item.code, item.numbers["variants"]) for item in reported] == [
        ("switching_law", ("a",)),
        ("small_margin", ("a", "b")),
        ("loop_diverges", ("c",)),
        ("switching_law", ("d",)),
    ]
    words = report.loop_warnings(reported)
    assert words[1].startswith("a, b: warning: the phase margin is only 15°")
    assert words[2].startswith("c: unstable, not simulated")
    assert words[3].startswith("d: the control law chatters")
    assert report.loop_doubts(reported) == [words[2], f"{SENTENCES['switching_law'].means}: a", "the loop has small margins: a, b"]


def test_single_name_of_a_variant_is_accepted_and_many_are_cut():
    single = Diagnostic("switching_law", "", "note", {"variants": "a"})
    small = Diagnostic("small_margin", "", "warning", {"variants": tuple("abcde"), "motions": "all", "phase": 15.0, "enough": 30.0})
    assert report.loop_doubts([small]) == ["the loop has small margins: a, b, c, d and 1 more"]
    assert report.loop_warnings([single])[0].startswith("a: the control law")
