"""The effect of an export: its share of the friction, the lead, the cases, the promise, and what the files say of them."""

import itertools
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from tests.exports.drives import listed
from tests.exports.test_drive import (
    AXIS,
    DT,
    LUGRE,
    MASS,
    SERVO,
    WITHOUT_LOOP,
    export_request,
    text_of,
)

import bristle as br
from bristle.exports import effect as effects
from bristle.exports.cases import Tried, cases_over, claims_of
from bristle.exports.effect import (
    Along,
    Effect,
    InLoop,
    drive_of_law,
    driven_by,
    effect_of_law,
    fed_along,
)
from bristle.exports.loops import late_of, lead_of, loop_for, reach_for
from bristle.exports.moves import TIMES, Limits
from bristle.exports.targets import TARGETS, Product, Target
from bristle.exports.writing import files_for, with_share
from bristle.files.axis import axis_from
from bristle.files.summary import plain
from bristle.models.controllers.feedforward import Rule
from bristle.prediction.claims import Claim, Compensation
from bristle.simulation.run import simulate_with

FROM_LOG = {"treatment": {"cutoff": 100.0, "delay": 0.0}}
STIFFNESS = 60.0 * 5000.0
PUSHING = br.friction.find("viscous+asymmetry")(F_v_pos=0.0, F_v_neg=0.0)
REACH = 40.0 / STIFFNESS  # the level of sliding friction, without break-away and viscous part


@pytest.fixture(scope="module")
def of_c():
    return files_for("c", export_request(info=FROM_LOG))


@pytest.fixture(scope="module")
def of_table():
    return files_for("table", export_request(info=FROM_LOG), accept_harm=True)


# --- the share of the friction ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["c", "st", "hal", "ros2"])
@pytest.mark.parametrize(
    ("axis", "gain", "distance"), [(AXIS, 0.9, 0.05 * REACH), (WITHOUT_LOOP, 0.8, 0.0)]
)
def test_a_share_from_a_log_fades_and_returns_if_the_stiffness_is_known(name, axis, gain, distance):
    rule = with_share(TARGETS[name], export_request(axis=axis, info=FROM_LOG)).rule
    assert rule == Rule(gain, pytest.approx(distance), 0.5, 0.0, 200.0)


def test_a_friction_that_drives_the_axis_has_no_reach():
    assert reach_for(export_request(PUSHING, info=FROM_LOG)) is None


def test_the_stiffness_of_the_log_takes_the_place_of_an_unknown_controller():
    known = {"treatment": FROM_LOG["treatment"] | {"stiffness": 2e5}}
    product = files_for("c", export_request(axis=WITHOUT_LOOP, info=known))
    claims = (Claim(pytest.approx(3.0 * 40.0 / 2e5), None, 0.3),)
    assert (product.effect.claims, product.effect.along, product.effect.mass) == (claims, (), MASS)
    assert "#define AXIS_X_GAIN 0.8" in product.files["axis_x.h"]


@pytest.mark.parametrize(
    ("name", "info"),
    [
        *((name, FROM_LOG) for name in ("fmu3", "mjcf", "warp", "wasm", "casadi", "cuda")),
        ("c", {}),
        ("table", {}),
    ],
)
def test_a_description_and_a_model_that_is_not_from_a_log_keep_all_of_the_friction(name, info):
    request = export_request(info=info)
    assert with_share(TARGETS[name], request) == request


@pytest.mark.parametrize("name", ["table", "tf5200", "ax8000", "sinumerik"])
def test_values_of_a_drive_contain_a_constant_share_with_the_viscous_part_whole(name):
    request = with_share(TARGETS[name], export_request(info=FROM_LOG))
    assert request.friction == LUGRE
    assert [request.model.values[name] for name in ("F_C", "sigma_0", "sigma_2")] == pytest.approx(
        [32.0, 4e6, 200.0]
    )
    assert reach_for(request) == pytest.approx(REACH)


def test_notes_state_the_share(of_c, of_table):
    # Larger shares promise no moves of three times the reach.
    assert any(
        note == "the feed has 0.7 of the friction, and the constant and the viscous part whole"
        for note in of_c.notes
    )
    assert any(
        note
        == "the values contain 0.7 of the friction, and the constant and the viscous part whole"
        for note in of_table.notes
    )
    unknown = files_for("c", export_request(axis=WITHOUT_LOOP, info=FROM_LOG))
    assert any(
        "the stiffness of the position loop is unknown, so bristle promises nothing" in note
        for note in unknown.notes
    )
    assert unknown.effect is None


# --- the lead -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("delay", "lag", "cycle", "ahead", "late"),
    [
        (0.0, None, None, 1, 0.0),
        (-1.4e-3, None, None, 2, 1.4e-3),
        (-1.6e-3, None, None, 3, 1.6e-3),
        # An effort that is recorded late belongs to the logger.
        (3e-3, None, None, 1, 0.0),
        # The controller counts its own cycles.
        (-1.4e-3, None, "0.25 ms", 7, 1.4e-3),
        (0.0, "2 ms", None, 3, 2e-3),
    ],
)
def test_the_lead_is_one_cycle_plus_the_lateness(delay, lag, cycle, ahead, late):
    controller = SERVO["controller"] | ({} if cycle is None else {"cycle": cycle})
    effort = SERVO["effort"] | ({} if lag is None else {"lag": lag})
    axis = axis_from(SERVO | {"controller": controller, "effort": effort})
    request = export_request(axis=axis, info={"treatment": {"delay": delay}})
    assert (lead_of(request), late_of(request)) == (ahead, pytest.approx(late))
    assert listed(TARGETS["tf5200"].write(request))["reversal_lookahead"] == min(ahead, 4)
    run = loop_for(request).run
    assert run.delay * run.sample_time + run.current_lag == pytest.approx(late)


def test_the_stated_lead_has_the_smallest_error():
    loop = loop_for(export_request(info={"treatment": {"delay": -2e-3}}))
    within = InLoop(loop, Limits(0.1, 1.6), REACH, 2e-3, 1e-5)
    assert within.ahead == 3

    def error(ahead):
        return within._move(
            10.0,
            lambda variant, _: driven_by(effects.drive_of(LUGRE, effects.Shape()))(variant, ahead),
        ).with_it

    assert error(3) < 0.8 * min(error(0), error(6))


def test_a_feed_that_acts_later_is_shifted():
    loop = replace(
        loop_for(export_request()),
        reference=br.references.recorded(position=np.arange(60.0) ** 2, sample_time=DT),
    )
    loop = replace(loop, run=replace(loop.run, duration=40 * DT))
    now = fed_along(lambda x, dt: x, loop, 2)
    assert now[5] == 49.0
    late = fed_along(lambda x, dt: x, loop, 2, 0.5 * DT)
    assert late[5] == pytest.approx(0.5 * (36.0 + 49.0))


# --- cases and the promise ----------------------------------------------------------------------------------------


def drawn(*levels):
    """Return the facts of a model file with draws of the friction level."""
    return {"bands": {"draws": {"F_C": np.array(levels), "F_S": 1.2 * np.array(levels)}}}


def test_cases_cover_distances_rests_paces_levels_and_lateness():
    cases = cases_over(1e-3)
    assert len(cases) == 60
    for times in (*TIMES, 100.0):
        own = [case for case in cases if case.distance == pytest.approx(times * 1e-3)]
        assert (len(own), sum(case.is_brief for case in own)) == (12, 7)
        assert {(case.rest, case.lasting) for case in own} == {
            (rest, lasting) for rest in (0.05, 0.3, 1.0) for lasting in (0.0, 0.1, 1.0)
        }
        quick = [case for case in own if not case.lasting and case.rest <= 0.3]
        assert sorted(case.friction for case in quick) == [-1, -1, 1, 1]
        # Too much force, too late, against an integral that had time to wind, is the hardest case.
        assert any(
            (case.rest, case.is_random, case.friction, case.late) == (0.3, False, -1, 3e-4)
            for case in quick
        )
    assert ({case.late for case in cases}, {case.is_random for case in cases}) == (
        {3e-4, -3e-4},
        {True, False},
    )


def tried(*worse):
    """Return all cases of a reach of 1 mm; those of which one of the `worse` is true get worse."""
    better = {case: 0.4 if case.distance > 2e-2 else 0.5 for case in cases_over(1e-3)}
    return [
        Tried(case, 1.0, 2.0 if any(each(case) for each in worse) else ratio)
        for case, ratio in better.items()
    ]


@pytest.mark.parametrize(
    ("worse", "claims", "hunts"),
    [
        ([], ((3e-3, 1.0, 1.0, 1.5),), False),
        ([lambda case: case.distance < 2e-3 and case.rest == 1.0], ((3e-3, 1.0, 1.0, 1.5),), False),
        (
            [lambda case: 2e-3 < case.distance < 5e-3 and case.rest == 1.0 and not case.lasting],
            ((3e-3, 1.0, 0.3, 1.5),),
            False,
        ),
        (
            [lambda case: 2e-3 < case.distance < 5e-3 and case.lasting == 1.0 and case.rest < 1.0],
            ((3e-2, 1.0, 1.0, 1.875), (3e-3, None, 0.3, 1.5)),
            False,
        ),
        ([lambda case: case.distance < 2e-3], ((3e-3, None, 0.3, 1.5),), True),
        ([lambda case: case.rest == 1.0], ((3e-3, None, 0.3, 1.5),), True),
        ([lambda case: case.distance > 2e-2 and not case.lasting and case.rest == 0.05], (), False),
        ([lambda case: True], (), True),
    ],
)
def test_claims_are_the_moves_that_no_case_shows_to_get_worse(worse, claims, hunts):
    found, is_hunting = claims_of(tried(*worse), 1e-3)
    assert ([tuple(claim) for claim in found], is_hunting) == (
        [(pytest.approx(least), *rest) for least, *rest in claims],
        hunts,
    )


def test_the_promise_of_a_known_axis(of_c, of_table):
    c, table = of_c.effect, of_table.effect
    assert c.claims[0].least_distance <= 3.001 * c.reach == pytest.approx(3.001 * REACH)
    assert (c.as_data()["claims"][0].keys(), c.as_data()["mass"]) == (
        {"least_distance", "slowest_move", "longest_rest", "factor"},
        pytest.approx(MASS),
    )
    assert [each.distance / REACH for each in c.moves] == pytest.approx(TIMES)
    assert (
        c.moves[-1].ratio < 0.5,
        table.moves[-1].ratio < 0.7,
        "simulated following error, peak to peak" in c.lines()[1],
    ) == (True,) * 3
    header = " ".join(re.sub(r"(?m)^\s*\*?", " ", text_of(of_c, ".h")).split())
    assert c.lines()[0] in header


@pytest.mark.parametrize(
    ("info", "more"),
    [
        ({}, 1.13),
        (drawn(39.0, 41.0), 1.0 + np.hypot(0.13, 0.049)),
        (drawn(32.0, 48.0), 1.0 + np.hypot(0.13, 0.392)),
        (drawn(10.0, 90.0), 1.9),
    ],
)
def test_a_case_has_another_friction_the_unexplained_force_and_the_worse_of_two_noises(
    monkeypatch, info, more
):
    seen = []

    def error(variant, effort, starts):
        seen.append((variant.friction.values["F_C"], float(np.mean(variant.disturbance))))
        return float(len(seen))

    monkeypatch.setattr("bristle.exports.cases._error", error)
    monkeypatch.setattr("bristle.exports.cases.cases_over", lambda reach: cases_over(reach)[2:7:2])
    loop = replace(loop_for(export_request(info=info)), disturbance=np.full(50, 7.0))
    tried = InLoop(loop, Limits(0.1, 1.6), REACH, 0.0, 1e-5).tried(lambda x, dt: np.zeros(x.size))
    levels = 2.0 - more, 2.0 - more, more, more, 1.0, 1.0
    assert seen[:6] == [
        (pytest.approx(40.0 * level), pytest.approx(7.0, abs=0.1)) for level in levels
    ]
    assert [(trial.without, trial.with_it) for trial in tried] == [
        (2.0, 7.0),
        (4.0, 8.0),
        (6.0, 9.0),
    ]


def test_the_feed_of_a_case_acts_later_than_expected(monkeypatch):
    efforts = []

    def error(variant, effort, starts):
        efforts.append(effort)
        return 1.0

    monkeypatch.setattr("bristle.exports.cases._error", error)
    # Later, earlier
    monkeypatch.setattr("bristle.exports.cases.cases_over", lambda reach: cases_over(reach)[:2])
    loop = loop_for(export_request())
    InLoop(loop, Limits(0.1, 1.6), REACH, 0.0, 1e-5).tried(
        lambda x, dt: np.arange(x.size, dtype=float)
    )
    samples = 3e-4 / loop.run.sample_time
    assert [effort[50] - 51.0 for effort in efforts if effort is not None] == pytest.approx(
        [-samples, samples]
    )


def test_the_shortest_moves_choose_no_share(monkeypatch):
    monkeypatch.setattr("bristle.exports.cases._error", lambda variant, effort, starts: 1.0)
    within = InLoop(loop_for(export_request()), Limits(0.1, 1.6), REACH, 0.0, 1e-5)
    tried = within.tried(lambda x, dt: np.zeros(x.size), brief=True)
    assert sorted({round(trial.case.distance / REACH) for trial in tried}) == [3, 10, 30, 100]


@pytest.mark.parametrize(
    ("place", "late", "fed"),
    [
        (0, None, (0.9, 0.05 * REACH, 0.5)),
        (1, None, (0.9, 0.05 * REACH, 1.0)),
        (2, None, (0.8, 0.0, 0.5)),
        (3, None, (0.7, 0.0, 0.5)),
        (4, None, (0.6, 0.0, 0.5)),
        # The share with the smallest error promises longer moves only.
        (2, 2, (0.9, 0.05 * REACH, 0.5)),
    ],
)
def test_the_share_with_the_smallest_error_is_taken_by_files_and_loop(
    monkeypatch, place, late, fed
):
    order, far = itertools.cycle(range(5)), Claim(4.0 * REACH, None, 0.3)
    monkeypatch.setattr(effects, "score_of", lambda tried, reach: 0.2 if tried == [place] else 0.5)
    monkeypatch.setattr(
        effects, "claims_of", lambda tried, *lengths: ((far if tried == [late] else QUICK,), False)
    )
    monkeypatch.setattr(
        InLoop, "tried", lambda within, drive, brief=False: [next(order)] if brief else []
    )
    monkeypatch.setattr(InLoop, "promised", lambda within, effect, tried: effect)
    request = replace(with_share(TARGETS["c"], export_request(info=FROM_LOG)), rest="held")
    assert effects.with_best_rule(request)[0].rule == pytest.approx((*fed, 0.0, 200.0))
    share = br.core.Feedforward(
        friction=LUGRE,
        gain=0.9,
        scaled="contact",
        return_distance=request.share.return_distance,
        fade_time=0.5,
    )
    logged = br.core.Experiment(
        "axis", "translational", (replace(loop_for(export_request()), feedforward=share),)
    )
    experiment, promise = effects.compensated_loop(
        logged, None, {}, Compensation(request.share, REACH, ())
    )
    assert [
        getattr(experiment.variants[0].feedforward, name) for name in Rule._fields[:3]
    ] == pytest.approx(fed)
    assert (promise.rule, promise.claims) == (pytest.approx((*fed, 0.0, 200.0)), (QUICK,))


# A drive that feeds 4 % of the effort of 30 m/s^2 too much leaves an error of its own beside each error.
@pytest.mark.parametrize(
    ("scaled", "acceleration", "ratios"),
    [
        ("contact", 1e-3, [0.2]),
        ("contact", 30.0, [0.6]),
        ("contact", 3e3, [0.75]),
        ("force", 1e-3, []),
    ],
)
def test_a_law_promises_for_the_share_of_an_identification_only(
    monkeypatch, scaled, acceleration, ratios
):
    own = 0.08 * 30.0 * MASS / STIFFNESS
    monkeypatch.setattr(
        InLoop,
        "tried",
        lambda within, drive: [Tried(case, own, 0.2 * own) for case in cases_over(within.reach)],
    )
    fed = {"feedforward": br.core.Feedforward(friction=LUGRE, gain=0.9, scaled=scaled)}
    law = replace(
        loop_for(export_request()),
        axis=br.core.Axis(velocity_limit=0.01, acceleration_limit=acceleration, jerk_limit=3.0),
        **fed,
    )
    assert [0.75 / claim.factor for claim in effects.promise_of_law(law)] == pytest.approx(
        ratios, rel=1e-3
    )
    assert effects.loop_of_law(law).limits == pytest.approx((0.01, acceleration, 3.0), rel=1e-3)
    unlimited = replace(law, axis=br.core.Axis(velocity_limit=0.01))
    assert effects.loop_of_law(unlimited).limits == pytest.approx(
        (0.01, 50.0 / MASS, math.inf), rel=1e-3
    )


@pytest.mark.slow
def test_an_export_that_worsens_long_moves_is_refused_unless_accepted():
    # The axis has a quarter of that friction.
    loop = replace(loop_for(export_request()), friction=LUGRE.with_values(F_C=10.0, F_S=12.0))
    with pytest.raises(
        br.core.InputError,
        match=r"makes the error larger .the compensation can harm moves up to .*--accept-harm",
    ):
        files_for("table", export_request(loop=loop))
    product = files_for("table", export_request(loop=loop), accept_harm=True)
    assert (product.effect.is_harmful, product.effect.as_data()["harmful"]) == (True, True)


@pytest.mark.parametrize(("rms", "is_useless"), [(50.0, False), (51.0, True)])
def test_files_that_describe_less_than_half_of_the_friction_are_refused(rms, is_useless):
    target = Target(
        name="mine",
        description="x",
        write=lambda request: Product({"a.txt": "x"}, error={"rms": rms, "largest": 99.0}),
    )
    if is_useless:
        with pytest.raises(
            br.core.InputError,
            match=r"mine: describes the friction with an error of 51 % rms; allowed 50 % or less.*accept-harm",
        ):
            files_for(target, export_request())
    assert files_for(target, export_request(), accept_harm=is_useless).files == {"a.txt": "x"}


# --- the numbers and words of an effect ---------------------------------------------------------------------------


def moved(distance, without, with_it, **others):
    return Along("moves", distance, without, with_it, **others)


def effect_along(*along, kind="translational", claims=(), hunts=False):
    return Effect(along, kind, 1e-5, claims, 1, 0.0, hunts)


@pytest.mark.parametrize(
    ("size", "is_worse"),
    [(0.5, False), (1.04, False), (1.06, True), (math.inf, True), (math.nan, True)],
)
def test_errors_within_five_per_cent_count_as_equal(size, is_worse):
    assert moved(1e-5, 1.0, size).is_worse == is_worse


BETTER, QUICK, SLOW = moved(1e-5, 1.0, 0.2), Claim(3e-5, None, 0.3, 1.59), Claim(3e-4, 1.0, 1.0)


@pytest.mark.parametrize(
    ("effect", "name", "expected"),
    [
        # An export is harmful if moves far longer than the reach or the motion of the log become worse.
        (effect_along(BETTER, moved(9e-5, 1.0, 2.0)), "is_harmful", False),
        (effect_along(BETTER, moved(1e-4, 1.0, 2.0)), "is_harmful", True),
        (effect_along(BETTER, moved(1e-4, 1.0, 2.0), claims=(SLOW,)), "is_harmful", False),
        (effect_along(BETTER, Along("log", 0.0, 1.0, 2.0)), "is_harmful", True),
        # The ratio is the geometric mean.
        (
            effect_along(moved(1e-5, 4.0, 2.0), moved(3e-5, 1.0, 0.125)),
            "ratio",
            pytest.approx(0.25),
        ),
        (effect_along(moved(1e-5, 1.0, np.inf)), "ratio", np.inf),
        (effect_along(BETTER, claims=(SLOW, QUICK)), "least_distance", 3e-5),
        (effect_along(BETTER), "least_distance", np.inf),
    ],
)
def test_numbers_of_an_effect_follow_from_its_motions(effect, name, expected):
    assert getattr(effect, name) == expected


SIZES = "simulated following error, peak to peak, without -> with compensation, worst case: "
MOVES = (BETTER, moved(3e-5, 1.0, 0.5), moved(3e-4, 1.0, 0.1))


@pytest.mark.parametrize(
    ("effect", "place", "words"),
    [
        (
            effect_along(*MOVES, claims=(QUICK,)),
            0,
            "helps quick moves of 30.0 um or more with rests .* smaller.; shorter",
        ),
        (
            effect_along(*MOVES, claims=(QUICK,)),
            1,
            f"^{SIZES}1.00 m -> 500 mm in moves of 30.0 um; 1.00 m -> 100 mm in moves of 300 um$",
        ),
        (
            effect_along(*MOVES, claims=(SLOW, QUICK)),
            0,
            "helps moves of up to 1 s of 300 um or more with rests up to 1 s; shorter",
        ),
        (
            replace(effect_along(*MOVES, claims=(SLOW,)), mass=20.0),
            0,
            " 1 s, in a drive that also feeds the acceleration of 20 kg forward;",
        ),
        (
            effect_along(*MOVES, claims=(SLOW, QUICK)),
            2,
            "^also quick moves of 30.0 um or more with rests up to 0.3 s .error at least 1.5 times smaller.$",
        ),
        (
            effect_along(moved(1e-5, 1.0, 2.0)),
            0,
            "^the compensation can harm moves up to 300 um: do not use it",
        ),
        (
            effect_along(BETTER),
            0,
            "^bristle promises nothing for moves from rest to rest up to 300 um",
        ),
        (
            effect_along(moved(2e-4, 1e-5, np.inf), kind="rotational"),
            1,
            f"^{SIZES}10.0 urad -> diverges in moves of 200 urad",
        ),
        (effect_along(BETTER, hunts=True), -1, "^the axis hunts with rests of 1 s"),
        (
            replace(effect_along(BETTER), assumed=1e-5),
            -1,
            "^the pre-sliding distance is unknown, and bristle assumes 10.0 um: write",
        ),
        (
            effect_along(BETTER, Along("log", 0.0, 0.5, 0.1, not_ahead=0.3)),
            2,
            "^along the motion of the log: 500 mm -> 100 mm, 300 mm if the motion is not fed ahead$",
        ),
    ],
)
def test_lines_state_the_promise_and_the_sizes_in_units_of_the_axis(effect, place, words):
    assert re.search(words, effect.lines()[place])


def test_data_of_an_effect_are_in_si():
    data = plain(
        effect_along(moved(2e-4, 1e-5, np.inf), kind="rotational", claims=(QUICK,)).as_data()
    )
    assert (data["unit"], data["quantity"], data["harmful"], data["least_distance"]) == (
        "rad",
        "following_error",
        False,
        3e-5,
    )
    assert data["claims"] == [
        {"least_distance": 3e-5, "slowest_move": None, "longest_rest": 0.3, "factor": 1.59}
    ]
    assert data["along"] == [
        {
            "motion": "moves",
            "worse": True,
            "distance": 2e-4,
            "without": 1e-5,
            "with": None,
            "not_fed_ahead": None,
        }
    ]


# --- laws ---------------------------------------------------------------------------------------------------------


def loop_along_a_log(**run):
    there = br.references.recorded(position=1e-3 * np.sin(0.02 * np.arange(300)), sample_time=DT)
    loop = loop_for(export_request())
    return replace(loop, reference=there, run=replace(loop.run, duration=0.3, **run))


@pytest.mark.parametrize(("late", "own"), [(2e-3, [3, 0]), (0.0, [1, 0])])
def test_the_log_motion_runs_without_with_and_with_late_feedforward(late, own):
    asked = []

    def compensated(variant, ahead):
        asked.append(ahead)
        return simulate_with(variant, None)

    effect = InLoop(loop_along_a_log(), Limits(0.1, 1.6), REACH, late, 1e-5).effect(compensated)
    assert asked == [own[0]] * len(TIMES) + own
    last = effect.along[-1]
    assert 0.0 < last.with_it == pytest.approx(last.without)


def test_the_reference_loop_of_a_law_feeds_neither_friction_nor_offset(monkeypatch):
    loop = replace(
        loop_along_a_log(delay=2),
        feedforward=br.core.Feedforward(mass=MASS, friction=LUGRE, offset=3.0),
    )
    seen = []

    def judged(within, compensated):
        seen.append(within)
        return Effect((), "translational", REACH, (), 1, 0.0, mass=MASS)

    monkeypatch.setattr(InLoop, "effect", judged)
    monkeypatch.setattr(InLoop, "promised", lambda within, effect, drive: effect)
    assert (effect_of_law(loop).ahead, effect_of_law(loop).mass) == (3, 0.0)
    within, _ = seen
    assert within.loop == replace(loop, feedforward=br.core.Feedforward(mass=MASS))
    assert (within.late, within.limits.velocity) == (
        pytest.approx(2e-3),
        pytest.approx(1e-3 * 0.02 / DT, rel=1e-2),
    )
    assert effect_of_law(within.loop) is None


def test_the_feed_of_a_law_is_that_of_its_share():
    given = br.core.Feedforward(
        friction=LUGRE, gain=0.9, scaled="contact", return_distance=5e-6, fade_time=0.5
    )
    x = 1e-3 * np.sin(0.01 * np.arange(500))
    files = effects.drive_of(LUGRE, effects.Shape(**Rule(0.9, 5e-6, 0.5, 0.0, 200.0)._asdict()))
    np.testing.assert_array_equal(drive_of_law(given)(x, DT), files(x, DT))
    assert drive_of_law(replace(given, along="measured")) is None
