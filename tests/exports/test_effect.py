"""The effect of an export on the axis: the files are read back, simulated, and judged before they are written."""

import json
import math
import re
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from tests.exports.drives import listed

import bristle as br
from bristle.cli.main import main
from bristle.engine.contact import steady_force
from bristle.exports import effect
from bristle.exports.described import Source
from bristle.exports.effect import TIMES, Along, Effect, Limits, driven_by, effect_in_loop, effect_of_files, sliding_level, turning_distance
from bristle.exports.loops import assumed_loops, loop_for, samples_ahead
from bristle.exports.targets import TARGETS, Request
from bristle.exports.writing import files_for
from bristle.files.axis import axis_from
from bristle.prediction.drive_table import reversal_distance
from bristle.simulation.run import simulate_with

DT = 1e-3
MASS = 25.0
SCREW = {
    "schema": 1,
    "kind": "translational",
    "columns": {"time": {"column": "t", "unit": "s"}, "position": {"column": "q", "unit": "mm"}, "effort": {"column": "u", "unit": "N"}},
    "effort": {"rated": "2 N*m", "limit": "2 kN"},
    "transmission": {"lead": "10 mm", "gear_ratio": 2.0},
    "encoder": {"resolution": "0.1 um"},
    "controller": {"model": "cascade", "k_p": "60 1/s", "k_v": "5000 N*s/m", "k_i": "200 kN/m"},
}
AXIS = axis_from(SCREW)
WITHOUT_LOOP = axis_from({key: value for key, value in SCREW.items() if key != "controller"})
LUGRE = br.friction.lugre(F_C=40.0, F_S=50.0, v_S=5e-3, sigma_0=5e6, sigma_1=2e3, sigma_2=200.0)
STRIBECK = br.friction.stribeck(F_C=40.0, F_S=50.0, v_S=5e-3, F_v=200.0)


def export_request(model=LUGRE, axis=AXIS, **options):
    return Request(
        model, "axis_x", DT, Source({"command": "bristle export"}), axis=axis, speed=0.1, plant=br.plants.inertia(M=MASS), **options
    )


def text_of(product, end):
    return next(str(text) for name, text in product.files.items() if name.endswith(end))


@pytest.fixture(scope="module")
def written():
    """Return what each target that acts on an axis writes of a model with memory."""
    cogging = br.plants.with_terms(br.plants.inertia, cogging={"motor": [6]})(M=MASS, motor_turn=0.005, motor_6_cos=10.0, motor_6_sin=5.0)
    result = {}
    for name in ("c", "st", "table", "tf5200", "ax8000", "cogging", "sinumerik"):
        request = replace(export_request(), plant=cogging) if name == "cogging" else export_request()
        result[name] = files_for(name, request, accept_harm=True)
    return result


def test_each_target_that_acts_on_an_axis_states_its_effect(written):
    for product in written.values():
        assert not product.effect.loops
        assert [each.distance / product.effect.distance for each in product.effect.along[:4]] == pytest.approx(TIMES)
        assert any("simulated following error, peak to peak, without -> with compensation" in note for note in product.notes)


@pytest.mark.parametrize(("name", "end"), [("c", ".h"), ("st", ".st"), ("table", "_drive.csv"), ("tf5200", ".txt"), ("ax8000", ".csv")])
def test_the_file_states_effect_and_preview(written, name, end):
    text, (head, *_) = text_of(written[name], end), written[name].effect.lines()
    plain = " ".join(re.sub(r"(?m)^\s*(#|;|\(\*|/?\*)", " ", text).split())
    assert head in plain
    assert "feed the desired motion 1 sample of 1 ms ahead" in plain


def test_a_model_with_memory_helps_on_moves_that_a_table_worsens(written):
    shortest = {name: product.effect.along[0] for name, product in written.items()}
    assert shortest["c"].with_it < 0.2 * shortest["c"].without
    assert shortest["table"].with_it > 3.0 * shortest["c"].with_it
    longest = {name: written[name].effect.along[3] for name in ("c", "table", "tf5200", "ax8000")}
    assert all(each.with_it < 0.7 * each.without for each in longest.values())
    assert len({each.without for each in longest.values()}) == 1


def test_an_export_that_worsens_long_moves_is_refused_unless_accepted():
    wrong = loop_for(export_request())
    loop = replace(wrong, friction=LUGRE.with_values(F_C=10.0, F_S=12.0))  # the axis has a quarter of that friction
    with pytest.raises(br.core.InputError, match=r"makes the error larger .the compensation harms moves up to .*--accept-harm"):
        files_for("table", export_request(loop=loop))
    product = files_for("table", export_request(loop=loop), accept_harm=True)
    assert product.effect.is_harmful
    assert product.effect.as_data()["harmful"] is True


@pytest.fixture(scope="module")
def assumed():
    """A table for an axis whose controller nobody knows."""
    return files_for("table", export_request(axis=WITHOUT_LOOP))


def test_without_a_controller_two_assumed_loops_judge_a_table(assumed):
    product, effect = assumed, assumed.effect
    slow, stiff = effect.loops
    assert slow == pytest.approx(10.0, rel=0.01)
    assert stiff > 3.0 * slow
    # A table turns at once: within the pre-sliding distance it pushes the wrong way, far beyond it removes most of the error.
    first, *_, last = effect.moves
    assert first.is_worse
    assert last.ratio < 0.5
    assert effect.distance < effect.least_distance < last.distance
    assert re.match(r"the compensation helps (quick )?moves of [\d.]+ [um]m or more; shorter moves can get worse", product.notes[0])
    # Nothing says whether the integral of the controller relaxes the contact: the rule at rest is that of the target.
    assert any("at rest (velocity 0): output the entry at zero of the last direction" in note for note in product.notes)
    # The model itself leaves nothing to judge.
    assert files_for("c", export_request(axis=WITHOUT_LOOP)).effect is None


def test_an_integral_follows_the_friction_of_a_slow_move_and_not_the_step_of_a_table(assumed):
    quick, slow = (
        {path.distance: path.ratio for path in assumed.effect.along if path.motion == motion} for motion in ("moves", "slow moves")
    )
    assert quick.keys() == slow.keys()
    assert [loop.lasting for loop in assumed_loops(export_request(axis=WITHOUT_LOOP), MASS)] == [0.1, 1.0]
    assert slow[max(slow)] > 2.0 * quick[max(quick)]


@pytest.mark.parametrize("points", [3, 20])
def test_no_table_feeds_the_peak_of_a_break_away(points):
    """A break-away force that no log determined, ten times the sliding friction, does not reach the drive."""
    peak = LUGRE.with_values(F_S=400.0, v_S=1e-5)
    request = export_request(peak, axis=None, points=points, rest="held")
    drive = TARGETS["table"].reads(TARGETS["table"].write(request).files, request)
    still, moving = np.zeros(3), 1e-9 * np.arange(3)
    assert np.max(np.abs(drive(np.concatenate([moving, moving[-1] + still]), DT))) < 1.05 * 40.0
    assert any("leaves out friction that falls with speed" in note for note in TARGETS["table"].write(replace(request, points=20)).notes)


def test_a_static_model_reports_an_assumed_distance():
    assert any("bristle assumes 10.0 um" in note for note in files_for("c", export_request(STRIBECK), accept_harm=True).notes)


@pytest.mark.parametrize(("lag", "delay"), [(0.0, 0), (2e-3, 0), (1.4e-3, 2)])
def test_the_lead_is_one_sample_plus_delay_and_lag(lag, delay):
    loop = loop_for(export_request())
    loop = replace(loop, run=replace(loop.run, current_lag=lag, delay=delay))
    ahead = 1 + delay + round(lag / DT)
    assert samples_ahead(loop) == ahead
    product = files_for("tf5200", export_request(loop=loop), accept_harm=True)
    assert any(f"feed the desired motion {ahead} sample" in note for note in product.notes)
    assert listed(product)["reversal_lookahead"] == min(ahead, 4)


def test_the_stated_lead_has_the_smallest_error():
    loop = loop_for(export_request())
    loop = replace(loop, run=replace(loop.run, delay=2))
    request = replace(export_request(loop=loop), rest="held")
    stated = effect_of_files(request, None)
    errors = {}
    for ahead in (0, stated.ahead, stated.ahead + 3):
        drive = driven_by(partial(br.response, LUGRE))
        result = effect_in_loop(loop_for(request), drive, Limits(0.1, 1.6), (stated.distance, False), ahead)
        errors[ahead] = result.along[2].with_it
    assert stated.ahead == 3
    assert errors[3] < 0.8 * errors[0]
    assert errors[3] < 0.8 * errors[6]


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize(("name", "points"), [("table", 20), ("table", 3), ("tf5200", 20)])
def test_the_force_read_back_is_the_friction_along_the_axis(name, points, turned):
    """The file alone, in its own units and signs, gives the steady friction of the model to the digits it has."""
    columns = SCREW["columns"] | {"position": {"column": "q", "unit": "mm", "sign": -1}}
    axis = axis_from(SCREW | {"columns": columns}) if turned else AXIS
    request = export_request(STRIBECK, axis=axis, points=points, rest="held" if name == "table" else "")
    target = TARGETS[name]
    drive = target.reads(target.write(request).files, request)
    t = DT * np.arange(400)
    for speed in (0.09, -0.09, 0.03, -0.03):
        force = drive(speed * t, DT)[-1]
        exact = steady_force(STRIBECK, speed)
        allowed = 0.01 * abs(exact) if points == 20 else 0.25 * abs(exact)
        allowed += 0.5e-3 * axis.rated if name == "tf5200" else 0.0  # integers in 0.1 %
        assert force == pytest.approx(exact, abs=allowed)
        assert abs(force) <= abs(exact) * (1.001 if points == 3 else 1.02)


def test_c_and_structured_text_command_in_the_units_of_the_drive(tmp_path):
    header = text_of(files_for("c", export_request()), ".h")
    assert "double axis_x_command(axis_x *axis, double position, double dt);" in header
    assert re.search(r"#define AXIS_X_PERCENT_OF_RATED\s", header)
    block = text_of(files_for("st", export_request()), "axis_x.st")
    arm = 0.010 / (2.0 * math.pi) / 2.0
    result = re.search(r"command := force / ([\d.]+);", block)
    assert float(result[1]) == pytest.approx(1.0 / arm, rel=1e-12)
    assert re.search(r"command .*N\*m at the motor", block)
    without = text_of(files_for("c", export_request(axis=None)), ".h")
    assert "axis_x_command" not in without


def test_the_command_line_prints_and_writes_the_effect(tmp_path, capsys):
    from bristle.files.model import write_model

    folder = tmp_path / "found"
    folder.mkdir()
    write_model(folder / "model.toml", br.plants.inertia(M=MASS), LUGRE)
    axis = tmp_path / "axis.toml"
    axis.write_text(
        'schema = 1\nkind = "translational"\n[columns]\ntime = { column = "t", unit = "s" }\n'
        'position = { column = "q", unit = "mm" }\neffort = { column = "u", unit = "N" }\n[effort]\nrated = "100 N"\n'
        '[controller]\nmodel = "cascade"\nk_p = "60 1/s"\nk_v = "5000 N*s/m"\nk_i = "200 kN/m"\n'
    )
    arguments = ["export", str(folder / "model.toml"), "--to", "table", "--axis", str(axis), "--speed", "0.1 m/s"]
    assert main([*arguments, "--out", str(tmp_path / "out"), "--json"]) == 0
    message = json.loads(capsys.readouterr().out)
    assert message["effect"]["quantity"] == "following_error"
    assert [each["motion"] for each in message["effect"]["along"]][:4] == ["moves"] * 4
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["effect"] == message["effect"]


def moved(distance, without, with_it, **others):
    return Along("moves", distance, without, with_it, **others)


def effect_along(*along, kind="translational", distance=1e-5, assumed=False, loops=()):
    return Effect(along, kind, distance, assumed, loops, 1)


@pytest.mark.parametrize(
    ("size", "too_much", "is_worse", "is_no_better"),
    [
        (0.5, math.nan, False, False),
        (0.94, math.nan, False, False),
        (0.96, math.nan, False, True),
        (1.0, math.nan, False, True),
        (1.04, math.nan, False, True),
        (1.06, math.nan, True, True),
        (math.inf, math.nan, True, True),
        (math.nan, math.nan, True, True),
        # A gain of less than half counts where a tenth more friction leaves the most of it.
        (0.45, 0.97, False, False),
        (0.55, 0.97, False, True),
        (0.55, 0.9, False, False),
    ],
)
def test_errors_within_five_per_cent_count_as_equal(size, too_much, is_worse, is_no_better):
    along = moved(1e-5, 1.0, size, too_much=too_much)
    assert (along.is_worse, along.is_no_better) == (is_worse, is_no_better)


SHORT, LONG, LONGER = moved(1e-5, 1.0, 1.5), moved(3e-4, 1.0, 0.4), moved(3e-3, 1.0, 0.1)
BETTER, MILD = moved(1e-5, 1.0, 0.2), moved(1e-5, 1.0, 0.2, too_much=0.4)


@pytest.mark.parametrize(
    ("effect", "name", "expected"),
    [
        # An export is harmful if long moves or the motion of the log become worse, in a loop that is known.
        (effect_along(BETTER, moved(9e-5, 1.0, 2.0)), "is_harmful", False),
        (effect_along(BETTER, moved(1e-4, 1.0, 2.0)), "is_harmful", True),
        (effect_along(BETTER, Along("log", 0.0, 1.0, 2.0)), "is_harmful", True),
        (effect_along(BETTER, moved(1e-4, 1.0, 2.0), loops=(10.0, 50.0)), "is_harmful", False),
        # The ratio is the geometric mean.
        (effect_along(moved(1e-5, 4.0, 2.0), moved(3e-5, 1.0, 0.125)), "ratio", pytest.approx(0.25)),
        (effect_along(moved(1e-5, 1.0, np.inf)), "ratio", np.inf),
        (effect_along(SHORT, LONG, LONGER), "least_distance", 3e-4),
        (effect_along(LONG, LONGER), "least_distance", 0.0),
        (effect_along(SHORT), "least_distance", np.inf),
    ],
)
def test_numbers_of_an_effect_follow_from_its_motions(effect, name, expected):
    assert getattr(effect, name) == expected


SLOW, SLOWER, SLOWEST = (Along("slow moves", far, 1.0, with_it) for far, with_it in ((1e-5, 2.0), (3e-4, 1.2), (3e-3, 0.5)))
UNKNOWN = effect_along(SHORT, LONG, SLOW, SLOWER, SLOWEST, loops=(10.0, 50.0))
MEND = ": switch it off there, or export a model with pre-sliding (--to c)"
OVER = moved(2e-5, 1.0, 0.3, too_much=1.2)
SIZES = "simulated following error, peak to peak, without -> with compensation: "


@pytest.mark.parametrize(
    ("effect", "place", "words"),
    [
        (
            effect_along(SHORT, LONG, LONGER),
            0,
            "^the compensation helps moves of 300 um or more; shorter moves get worse: switch it off there$",
        ),
        (effect_along(SHORT, LONG, LONGER), 1, f"^{SIZES}1000 mm -> 100 mm in moves of 3.00 mm; 1000 mm -> 1500 mm in moves of 10.0 um$"),
        (effect_along(LONG, LONGER), 0, "^the compensation helps moves of 300 um or more$"),
        (effect_along(SHORT), 0, "^the compensation harms moves up to 10.0 um: switch it off there$"),
        (effect_along(moved(1e-5, 1.0, 1.0)), 0, "^the compensation does not help moves up to 10.0 um"),
        (
            effect_along(SHORT, LONG, assumed=True),
            0,
            "moves of 300 um or more, and of 30 times the true pre-sliding distance if this exceeds the assumed 10.0 um; shorter",
        ),
        (effect_along(SHORT, LONG, assumed=True), -1, "the pre-sliding distance is unknown, and bristle assumes 10.0 um"),
        # An unknown controller is a slow loop with quick moves, and a stiff one with slow moves.
        (
            UNKNOWN,
            0,
            f"^the compensation helps quick moves of 300 um or more; shorter moves can get worse; slow moves up to 300 um can get "
            f"worse in a stiff loop{re.escape(MEND)}$",
        ),
        (UNKNOWN, 1, r"1000 mm -> 1500 mm in moves of 10.0 um \(loop of 10 Hz, moves of 0.1 s\)$"),
        (UNKNOWN, 2, r"^slow moves: 1000 mm -> 500 mm in moves of 3.00 mm; 1000 mm -> 2000 mm in moves of 10.0 um"),
        (UNKNOWN, 2, r"\(loop of 50 Hz, moves of 1 s\)$"),
        (UNKNOWN, -1, "the controller is unknown"),
        # Slow moves that get worse, but are shorter than the limit of quick ones, need no limit of their own.
        (
            effect_along(SHORT, LONG, SLOW, SLOWEST, loops=(10.0, 50.0)),
            0,
            f"^the compensation helps moves of 300 um or more; shorter moves can get worse{re.escape(MEND)}$",
        ),
        (effect_along(moved(2e-4, 1e-5, np.inf), kind="rotational"), 1, f"^{SIZES}10.0 urad -> diverges in moves of 200 urad"),
        # Of too much friction the worst move is told, of the log what is lost without the lead.
        (
            effect_along(MILD, moved(2e-5, 1.0, 0.3, too_much=0.9)),
            2,
            "^with a tenth too much friction fed forward: 1000 mm -> 900 mm in moves of 20.0 um$",
        ),
        (effect_along(MILD, OVER), 2, "in moves of 20.0 um: worse than no compensation, so feed forward only 90 % of the friction$"),
        (
            effect_along(MILD, Along("log", 0.0, 0.5, 0.1, not_ahead=0.3)),
            2,
            "^along the motion of the log: 500 mm -> 100 mm, 300 mm if the motion is not fed ahead$",
        ),
        (effect_along(MILD, Along("log", 0.0, 0.5, 0.1)), 2, "^along the motion of the log: 500 mm -> 100 mm$"),
    ],
)
def test_lines_state_where_to_switch_off_and_the_sizes_in_units_of_the_axis(effect, place, words):
    assert re.search(words, effect.lines()[place])


def test_data_of_an_effect_are_in_si():
    data = effect_along(moved(2e-4, 1e-5, np.inf), kind="rotational").as_data()
    assert (data["unit"], data["quantity"], data["harmful"], data["least_distance"]) == ("rad", "following_error", True, None)
    numbers = {"distance": 2e-4, "without": 1e-5, "with": None, "not_fed_ahead": None, "with_a_tenth_more": None}
    assert data["along"] == [{"motion": "moves", "worse": True} | numbers]


def test_the_turning_distance_comes_from_the_model_the_axis_or_an_assumption():
    known = axis_from(SCREW | {"plant": {"presliding": "30 um"}})
    distance, assumed = turning_distance(LUGRE, known, 0.1)
    assert not assumed
    assert distance == pytest.approx(reversal_distance(LUGRE, 0.1))
    assert turning_distance(STRIBECK, known, 0.1) == (pytest.approx(3e-5), False)
    assert turning_distance(STRIBECK, AXIS, 0.1) == turning_distance(STRIBECK, None, 0.1) == (1e-5, True)
    assert turning_distance(br.friction.coulomb(kind="rotational", F_C=1.0), None, 0.1) == (2e-4, True)


def test_sliding_friction_is_the_mean_of_both_directions():
    heavy = br.friction.with_slots(br.friction.coulomb, ["asymmetry"])(F_C_pos=9.0, F_C_neg=5.0, offset=40.0)
    assert sliding_level(heavy, 0.1) == pytest.approx(7.0)


def test_the_reference_loop_has_no_friction_feedforward_and_the_limits_of_the_axis():
    loop = loop_for(export_request())
    assert loop.feedforward.friction is None
    assert loop.run.effort_limit == pytest.approx(2000.0)
    assert loop.run.sample_time == DT
    assert loop.plant.values["M"] == MASS
    assert loop_for(export_request(axis=None)) is None
    assert loop_for(replace(export_request(), plant=None)) is None
    passed = loop_for(replace(export_request(), loop=loop))
    assert passed.plant is loop.plant


def loop_along_a_log(**run):
    there = br.references.recorded(position=1e-3 * np.sin(0.02 * np.arange(300)), sample_time=DT)
    loop = loop_for(export_request())
    return replace(loop, reference=there, run=replace(loop.run, duration=0.3, **run))


@pytest.mark.parametrize(("ahead", "own"), [(3, [(3, 1.0), (0, 1.0)]), (0, [(0, 1.0)])])
def test_the_log_motion_runs_without_with_and_with_late_feedforward(ahead, own):
    loop = loop_along_a_log()
    asked = []

    def compensated(variant, ahead, share=1.0):
        asked.append((ahead, share))
        return simulate_with(variant, None)

    effect = effect_in_loop(loop, compensated, Limits(0.1, 1.6), (1e-5, False), ahead)
    assert asked[: -len(own)] == [(ahead, 1.0), (ahead, 1.1)] * len(TIMES)
    assert asked[-len(own) :] == own
    assert len(effect.along) == len(TIMES) + 1
    last = effect.along[-1]
    assert last.without == pytest.approx(last.with_it)
    assert last.without > 0.0


def test_the_reference_loop_of_a_law_feeds_neither_friction_nor_offset(monkeypatch):
    loop = replace(loop_along_a_log(delay=2), feedforward=br.core.Feedforward(mass=MASS, friction=LUGRE, offset=3.0))
    asked = []

    def judged(variant, compensated, limits, distance, ahead):
        asked.append((variant, limits, ahead))
        return Effect((), "translational", 1e-5, assumed=False, loops=(), ahead=ahead)

    monkeypatch.setattr(effect, "effect_in_loop", judged)
    assert effect.effect_of_law(loop).ahead == 3
    ((variant, limits, ahead),) = asked
    assert variant == replace(loop, feedforward=br.core.Feedforward(mass=MASS))
    assert ahead == 0
    assert limits.velocity == pytest.approx(1e-3 * 0.02 / DT, rel=1e-2)
    assert effect.effect_of_law(variant) is None
