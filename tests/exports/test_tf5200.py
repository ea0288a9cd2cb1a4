"""The list of compensation values of a TF5200: its units and ends, and what the control makes of it at a reversal."""

import numpy as np
import pytest

import bristle as br
from bristle.exports import tf5200
from bristle.exports.drive import Side
from bristle.exports.targets import Request
from bristle.exports.tf5200 import merged, reads, write
from bristle.prediction.drive_units import DriveUnit

COLUMNS = {name: {"column": name[0], "unit": unit} for name, unit in (("time", "s"), ("position", "mm"), ("effort", "N"))}
# An arm of a millimetre: 0.2 N m are 200 N, and a per mille of that is 0.2 N.
AXIS = br.read_axis(
    {"schema": 1, "kind": "translational", "columns": COLUMNS}
    | {"effort": {"rated": "0.2 N*m"}, "transmission": {"lead": f"{2.0 * np.pi!r} mm"}}
)
TURNING = br.read_axis(
    {"schema": 1, "kind": "rotational", "effort": {"rated": "0.5 N*m"}}
    | {"columns": COLUMNS | {"position": {"column": "p", "unit": "deg"}, "effort": {"column": "e", "unit": "%"}}}
)


def request_for(model, axis=AXIS, **changes):
    return Request(model, "axis_x", 1e-3, axis=axis, **{"speed": 0.2, "points": 5} | changes)


def rows_of(product):
    lines = (line.split() for line in product.files["axis_x.txt"].splitlines() if not line.startswith("#"))
    return {key.removeprefix("frict_comp."): int(value) for key, value in lines}


def test_the_list_is_in_micrometres_a_second_and_per_mille_of_rated():
    rows = rows_of(write(request_for(br.friction.coulomb_viscous(F_C=8.0, F_v=20.0))))
    assert rows == {
        "mode": 3,
        "table_entries": 2,
        "position_delay": 0,
        "reversal_lookahead": 1,
        "scaling_factor": 1000,
        "delay_cycles": 0,
        "table[0].in": 0,
        "table[0].out": 40,
        "table[1].in": 200_000,
        "table[1].out": 60,
    }


def test_the_list_of_a_rotary_axis_is_in_thousandths_of_a_degree_a_second():
    viscous = br.friction.coulomb_viscous(kind="rotational", F_C=0.1, F_v=0.02)
    rows = rows_of(write(request_for(viscous, TURNING, speed=np.pi)))
    assert [rows[f"table[1].{key}"] for key in ("in", "out")] == [180_000, round((0.1 + 0.02 * np.pi) / 0.0005)]


@pytest.mark.parametrize(("microns", "written", "is_noted"), [(0.4, 4, False), (1.0, 10, False), (1.2, 10, True)])
def test_a_delay_over_a_distance_is_limited_to_ten_tenths_of_a_micrometre(monkeypatch, microns, written, is_noted):
    requested = []
    monkeypatch.setattr(tf5200, "reversal_distance", lambda model, speed: requested.append(speed) or microns * 1e-6)
    product = write(request_for(br.friction.coulomb(F_C=8.0)))
    assert rows_of(product)["position_delay"] == written
    reason = "position_delay has its largest value, 10, but the friction needs 12 x 0.1 um to reverse"
    assert (reason in product.notes) is is_noted
    assert requested == [pytest.approx(0.2)]


@pytest.mark.parametrize(("ahead", "written"), [(1, 1), (4, 4), (5, 4)])
def test_the_current_leads_a_reversal_by_four_cycles_at_most(monkeypatch, ahead, written):
    monkeypatch.setattr(tf5200, "samples_ahead", lambda loop: ahead)
    product = write(request_for(br.friction.coulomb(F_C=8.0)))
    assert rows_of(product)["reversal_lookahead"] == written
    assert f"leads a reversal; this axis needs {ahead}, the largest value is 4." in str(product.files["axis_x.txt"])


@pytest.mark.parametrize(("count", "is_refused"), [(20, False), (21, True)])
def test_the_list_has_at_most_twenty_entries(monkeypatch, count, is_refused):
    entries = np.column_stack([0.01 * np.arange(count), 1.0 + np.arange(count) % 2])
    monkeypatch.setattr(tf5200, "mean_side", lambda *passed: Side(entries, entries))
    request = request_for(br.friction.coulomb(F_C=8.0))
    if is_refused:
        with pytest.raises(
            br.core.InputError, match="points: exceeds the length of the list of the CNC; found 21, allowed 20 entries or fewer"
        ):
            write(request)
    else:
        assert rows_of(write(request))["table_entries"] == count


def test_the_first_of_several_entries_at_a_rounded_speed_is_kept():
    entries = np.array([[0.0, 5.0], [4e-7, 7.0], [1e-6, 9.0], [2e-6, 9.0]])
    kept = merged(Side(entries, entries), DriveUnit("0.1 % of rated", 1.0), "translational").entries
    assert kept.tolist() == entries[[0, 2, 3]].tolist()


def test_the_constant_force_does_not_count_as_an_error_of_a_direction():
    lifting = br.friction.find("coulomb")(F_C=8.0, offset=4.0)
    product = write(request_for(lifting))
    assert [rows_of(product)[f"table[{i}].out"] for i in (0, 1)] == [40, 40]
    assert any("does not contain the constant force of 4 N" in note for note in product.notes)


LIST = {"table_entries": 2, "position_delay": 0, "reversal_lookahead": 0, "scaling_factor": 1000}
LIST |= {"table[0].in": 0, "table[0].out": 10, "table[1].in": 100_000, "table[1].out": 30}  # 2 N, and 6 N at 100 mm/s


def force_along(steps, dt=1e-3, **changes):
    """Return the force [N] that the control adds at each position after 0, which are so many micrometres apart."""
    text = "\n".join(f"frict_comp.{key} {value}" for key, value in (LIST | changes).items())
    drive = reads({"axis_x.txt": f"# a remark\n{text}"}, request_for(br.friction.coulomb(F_C=8.0)))
    return drive(np.cumsum([0.0, *steps]) * 1e-6, dt)[1:]


def test_the_control_interpolates_between_entries_by_the_commanded_velocity():
    # 25 um in a millisecond are 25 mm/s: 2 N and a quarter of 4 N more; beyond the last entry it stays.
    assert force_along([25.0, 100.0, 200.0, -25.0]) == pytest.approx([3.0, 6.0, 6.0, -3.0])
    assert force_along([25.0, 100.0], scaling_factor=500) == pytest.approx([1.5, 3.0])


def test_the_current_stays_through_a_stop_without_a_reversal():
    assert force_along([0.0, 25.0, 0.0, 25.0, 0.0, -25.0, 0.0]) == pytest.approx([0.0, 3.0, 2.0, 3.0, 2.0, -3.0, -2.0])


def test_the_current_fades_over_the_cycles_before_a_reversal():
    # Of 2 N with two cycles: a third and two thirds of it are left before the turn.
    steps = [1e-3] * 4 + [-1e-3] * 2
    assert force_along(steps, reversal_lookahead=2) == pytest.approx([2.0, 2.0, 4.0 / 3.0, 2.0 / 3.0, -2.0, -2.0], abs=1e-3)


def test_the_current_builds_up_over_the_distance_after_a_reversal():
    # 0.4 um behind the turn, in steps of 0.1 um; a reversal before that begins anew.
    steps = [-0.1] * 2 + [0.1] * 6
    built = force_along(steps, dt=10.0, position_delay=4)
    assert built == pytest.approx([-0.5, -1.0, 0.5, 1.0, 1.5, 2.0, 2.0, 2.0], abs=1e-3)
    assert force_along([-0.1, 0.1, 0.1], dt=10.0, position_delay=4)[1:] == pytest.approx([0.5, 1.0], abs=1e-3)
