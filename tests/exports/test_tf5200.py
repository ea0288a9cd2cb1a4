"""The list of compensation values of a TF5200: its units and ends, and what the control makes of it at a reversal."""

import numpy as np
import pytest
from tests.exports.drives import SCREW, TURNING, listed

import bristle as br
from bristle.exports import tf5200
from bristle.exports.drive import Side
from bristle.exports.targets import Request
from bristle.exports.tf5200 import merged, reads, write
from bristle.prediction.drive_units import DriveUnit

# An arm of a millimetre: 0.2 N m are 200 N, and a per mille of that is 0.2 N.
AXIS = br.read_axis(SCREW | {"effort": {"rated": "0.2 N*m"}, "transmission": {"lead": f"{2.0 * np.pi!r} mm"}})


def request_for(model, axis=AXIS, **changes):
    return Request(model, "axis_x", 1e-3, axis=axis, **{"speed": 0.2, "points": 5} | changes)


def test_the_list_is_in_micrometres_a_second_and_per_mille_of_rated():
    rows = listed(write(request_for(br.friction.coulomb_viscous(F_C=8.0, F_v=20.0))))
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
    rows = listed(write(request_for(viscous, br.read_axis(TURNING), speed=np.pi)))
    assert [rows[f"table[1].{key}"] for key in ("in", "out")] == [180_000, round((0.1 + 0.02 * np.pi) / 0.0005)]


@pytest.mark.parametrize(("microns", "written", "is_noted"), [(0.4, 4, False), (1.0, 10, False), (1.2, 10, True)])
def test_a_delay_over_a_distance_is_limited_to_ten_tenths_of_a_micrometre(monkeypatch, microns, written, is_noted):
    requested = []
    monkeypatch.setattr(tf5200, "reversal_distance", lambda model, speed: requested.append(speed) or microns * 1e-6)
    product = write(request_for(br.friction.coulomb(F_C=8.0)))
    assert listed(product)["position_delay"] == written
    reason = "position_delay has its largest value, 10, but the friction needs 12 x 0.1 um to reverse"
    assert (reason in product.notes) is is_noted
    assert requested == [pytest.approx(0.2)]


@pytest.mark.parametrize(("ahead", "written"), [(1, 1), (4, 4), (5, 4)])
def test_the_current_leads_a_reversal_by_four_cycles_at_most(monkeypatch, ahead, written):
    monkeypatch.setattr(tf5200, "samples_ahead", lambda loop: ahead)
    product = write(request_for(br.friction.coulomb(F_C=8.0)))
    assert listed(product)["reversal_lookahead"] == written
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
        assert listed(write(request))["table_entries"] == count


@pytest.mark.parametrize(
    ("entries", "kept"),
    [
        # Of several entries at a rounded speed the first, and of equal ones both ends.
        ([[0.0, 5.0], [4e-7, 7.0], [1e-6, 9.0], [2e-6, 9.0]], [0, 2, 3]),
        ([[1e-3 * k, force] for k, force in enumerate([10.0, 10.0, 10.0, 20.0, 20.0, 30.0])], [0, 2, 3, 4, 5]),
    ],
)
def test_an_entry_that_says_nothing_is_omitted(entries, kept):
    entries = np.array(entries)
    assert merged(Side(entries, entries), DriveUnit("0.1 % of rated", 1.0), "translational").entries.tolist() == entries[kept].tolist()


def test_the_constant_force_does_not_count_as_an_error_of_a_direction():
    lifting = br.friction.find("coulomb")(F_C=8.0, offset=4.0)
    product = write(request_for(lifting))
    assert [listed(product)[f"table[{i}].out"] for i in (0, 1)] == [40, 40]
    assert any("does not contain the constant force of 4 N" in note for note in product.notes)


LIST = {"table_entries": 2, "position_delay": 0, "reversal_lookahead": 0, "scaling_factor": 1000}
LIST |= {"table[0].in": 0, "table[0].out": 10, "table[1].in": 100_000, "table[1].out": 30}  # 2 N, and 6 N at 100 mm/s


@pytest.mark.parametrize(
    ("steps", "dt", "changes", "forces"),
    [
        # Between entries: 25 um in a millisecond are 25 mm/s, 2 N and a quarter of 4 N more; beyond the last entry it stays.
        ([25.0, 100.0, 200.0, -25.0], 1e-3, {}, [3.0, 6.0, 6.0, -3.0]),
        ([25.0, 100.0], 1e-3, {"scaling_factor": 500}, [1.5, 3.0]),
        # It stays through a stop without a reversal.
        ([0.0, 25.0, 0.0, 25.0, 0.0, -25.0, 0.0], 1e-3, {}, [0.0, 3.0, 2.0, 3.0, 2.0, -3.0, -2.0]),
        # Of 2 N with two cycles before a reversal: a third and two thirds of it are left before the turn.
        ([1e-3] * 4 + [-1e-3] * 2, 1e-3, {"reversal_lookahead": 2}, [2.0, 2.0, 4.0 / 3.0, 2.0 / 3.0, -2.0, -2.0]),
        # 0.4 um behind the turn, in steps of 0.1 um; a reversal before that begins anew.
        ([-0.1] * 2 + [0.1] * 6, 10.0, {"position_delay": 4}, [-0.5, -1.0, 0.5, 1.0, 1.5, 2.0, 2.0, 2.0]),
        ([-0.1, 0.1, 0.1], 10.0, {"position_delay": 4}, [-0.5, 0.5, 1.0]),
    ],
)
def test_the_control_adds_the_force_of_the_list_along_a_motion(steps, dt, changes, forces):
    text = "\n".join(f"frict_comp.{key} {value}" for key, value in (LIST | changes).items())
    drive = reads({"axis_x.txt": f"# a remark\n{text}"}, request_for(br.friction.coulomb(F_C=8.0)))
    assert drive(np.cumsum([0.0, *steps]) * 1e-6, dt)[1:] == pytest.approx(forces, abs=1e-3)
