"""What figures say of numbers: what is missing at a return, where friction breaks away, what more branches bring."""

import math
from types import SimpleNamespace
from typing import ClassVar

import numpy as np
import pytest

from bristle import friction, hysteresis
from bristle.apps.paper import drift, economy, loops, paths, plane, reproduced, tracking
from bristle.apps.paper.bench import Record, Sensed, Walk
from bristle.core.errors import InputError
from bristle.engine import response


class Told(dict):
    """Numbers of an experiment by table and key."""

    source = "x.toml"


def led(*torques, x=None, turns=None):
    """A walk with these torques at its turns."""
    places = np.arange(len(torques)) if turns is None else np.array(turns)
    return Walk(
        np.arange(float(len(torques))) if x is None else np.array(x),
        np.array(torques, dtype=float),
        places,
    )


# --- returns ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("turns", [[1.0, 2.0], [1.0, 2.0, 3.0]])
def test_a_path_that_does_not_return_is_refused(turns):
    with pytest.raises(
        InputError, match=r"x\.toml: path\.turns.*its entries 1 and 3 must be equal"
    ):
        paths._must_return(Told({("path", "turns"): np.array(turns)}), ((0, 2),))
    paths._must_return(Told({("path", "turns"): np.array([1.0, 2.0, 1.0])}), ((0, 2),))


def test_a_model_is_compared_with_the_rig_over_the_position_leg_by_leg():
    up, down = np.linspace(0.0, 1.0, 11), np.linspace(1.0, 0.0, 21)[1:]
    x = np.concatenate([up, down])
    torque = np.concatenate([4.0 * up, 4.0 * down - 2.0])
    rig = Walk(x, torque, np.array([10, 30]))
    fine = np.concatenate([np.linspace(0.0, 1.0, 101), np.linspace(1.0, 0.0, 51)[1:]])
    same = Walk(
        fine, np.concatenate([4.0 * fine[:101], 4.0 * fine[101:] - 2.0]), np.array([100, 150])
    )
    away = paths._apart(same, rig)
    assert away["as_it_is"] == pytest.approx(0.0, abs=0.03)  # the corner of a leg
    shifted = paths._apart(Walk(fine, same.torque - 1.0, same.turns), rig)
    assert shifted["offset"] == pytest.approx(1.0, abs=0.1)
    assert shifted["as_it_is"] == pytest.approx(0.25, rel=0.1)
    assert shifted["with_offset"] == pytest.approx(away["with_offset"])


# --- ripple -------------------------------------------------------------------------------------------------------


def ripple(**changed):
    values = {"break_away": 4.0, "low": 1.0, "high": 3.0, "period": 8 * 2.5e-4, "cycles": 3}
    return Told({("torque", key): value for key, value in (values | changed).items()})


def test_a_torque_rises_falls_back_and_goes_up_and_down():
    torque, cycles = drift.torque_of(ripple())
    assert cycles.tolist() == [48, 56, 64, 72]
    assert torque.size == 73
    assert torque[:33:8].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]  # over four periods
    assert torque[32:49:8].tolist() == [4.0, 3.5, 3.0]  # over two
    assert torque[48:57].tolist() == [3.0, 2.5, 2.0, 1.5, 1.0, 1.5, 2.0, 2.5, 3.0]
    assert torque[cycles].tolist() == [3.0] * 4


@pytest.mark.parametrize("changed", [{"low": 3.0}, {"low": 3.5}, {"high": 4.0}, {"high": 4.5}])
def test_levels_of_a_ripple_are_in_order(changed):
    with pytest.raises(InputError, match="must satisfy low < high < break_away"):
        drift.torque_of(ripple(**changed))


def rippled(steps, width=10.0):
    """What a torque does that moves a contact by these steps in its cycles."""
    ends = np.concatenate([[0.0], np.cumsum(steps)])
    x = np.column_stack([ends[:-1], ends[:-1] + width]).ravel()
    x = np.append(x, ends[-1])
    return drift.Rippled(np.arange(x.size), x, x, x, 2 * np.arange(len(steps) + 1))


def test_the_settled_cycles_are_those_of_the_second_half():
    run = rippled([9.0, 5.0, 3.0, 2.0, 1.0])
    assert run.settled.tolist() == [3.0, 2.0, 1.0]
    assert rippled([9.0, 5.0, 3.0, 2.0]).settled.tolist() == [3.0, 2.0]
    assert run.width == 10.0


@pytest.mark.parametrize(
    ("lugre", "other", "verdict", "words"),
    [
        (1e-6, 1.2e-6, "found", "other: 20 % more than LuGre."),
        (1e-6, 0.7e-6, "found", "other: 30 % less than LuGre."),
        (1e-6, -0.5e-6, "found", "other: −0.5 µm per cycle."),
        (1e-8, 2e-8, "refuted", "other: 100 % more than LuGre."),
    ],
)
def test_lugre_drifts_where_it_walks_by_more_than_a_share_of_its_orbit(
    monkeypatch, lugre, other, verdict, words
):
    runs = {"a": rippled([lugre] * 4, 1e-6), "b": rippled([other] * 4, 1e-6)}
    monkeypatch.setattr(drift, "rippled", lambda setting, model: runs[model])
    item = drift.figure_2(Bench([], LuGre="a", other="b"))
    assert (item.number, item.verdict) == (2, verdict)
    assert item.found[-1].replace("500 nm", "0.5 µm") == words
    assert item.numbers["drift_per_cycle"] == {
        "LuGre": pytest.approx(lugre),
        "other": pytest.approx(other),
    }


# --- economy ------------------------------------------------------------------------------------------------------


def cost(dahl, stops, surface, floor=2.0):
    """Errors by way, one row for each number of branches."""
    errors = {
        name: np.array(rows, dtype=float)
        for name, rows in zip(economy.WAYS, (dahl, stops, surface), strict=True)
    }
    return economy.Economy([1, 100][: len(dahl)], errors, floor, 3.5)


@pytest.mark.parametrize(
    ("dahl", "stops", "surface", "verdict"),
    [
        (3.0, 4.0, 2.1, "found"),
        (3.0, 2.9, 2.1, "found in part"),
        (3.0, 4.0, 1.9, "refuted"),
        (3.0, 2.0, 1.9, "refuted"),
    ],
)
def test_economy_holds_where_few_branches_do_about_as_well_as_many(dahl, stops, surface, verdict):
    item = cost([[dahl], [9.0]], [[stops], [9.0]], [[math.nan], [surface]])
    assert economy.verdict(item) == verdict


def test_means_are_over_seeds():
    item = cost([[1.0, 3.0], [2.0, 2.0]], [[1.0, 1.0]] * 2, [[math.nan] * 2, [4.0, 6.0]])
    assert item.means["reformed Dahl"].tolist() == [2.0, 2.0]
    assert math.isnan(item.means["tabulated surface"][0])
    numbers = economy.numbers(item, item)
    assert numbers["branches"] == [1, 100]
    assert numbers["error_deviation_percent"]["reformed Dahl"] == pytest.approx(
        [math.sqrt(2.0), 0.0]
    )
    assert numbers["scatter_percent"] == 2.0
    single = cost([[1.0]], [[2.0]], [[3.0]])
    assert economy.numbers(single, single)["error_deviation_percent"]["reformed Dahl"].tolist() == [
        0.0
    ]


def test_the_gain_of_more_branches_is_stated():
    item = cost([[3.0, 3.2], [3.1, 3.3]], [[2.0, 3.4], [1.5, 1.6]], [[math.nan] * 2, [2.0, 2.2]])
    first, nearer, scatter, still = economy.sentences(item, cost([[1.0]], [[0.5]], [[0.25]]))
    assert first.startswith(
        "On unseen motions: from 1 branch reformed Dahl 3.10 ± 0.14 %, Prandtl-Ishlinskii"
    )
    assert "; from 100 branches reformed Dahl 3.20 ± 0.14 %" in first
    assert "tabulated surface" not in first.partition(";")[0]
    assert first.endswith("One branch takes 3.5 s.")
    assert (
        "Prandtl-Ishlinskii is better than reformed Dahl in 1 of 2 repetitions, by 0.40 ± 0.85 %"
        in nearer
    )
    assert scatter == "The scatter of the rig alone is 2.0 %, a lower bound for every model."
    assert "from 1 branch reformed Dahl 1.0 %, Prandtl-Ishlinskii 0.50 %" in still
    assert len(economy.sentences(cost([[1.0]], [[0.5]], [[0.25]]), item)) == 3


def test_a_table_has_a_row_for_each_number_of_branches():
    item = cost([[3.0, 3.2], [3.1, 3.3]], [[2.0, 3.4], [1.5, 1.6]], [[1.0, 1.0], [2.0, 2.2]])
    table = economy.table(item, cost([[1.0], [2.0]], [[0.5], [0.5]], [[0.25], [0.25]]))
    assert [row[0] for row in table.rows] == ["1", "100"]
    assert table.rows[0][1] == "3.10 ± 0.14"
    assert table.heads[1:] == (*economy.WAYS, *(f"{name}, no scatter" for name in economy.WAYS))
    assert len(table.rows[0]) == 7


SCATTERING = friction.maxwell_stribeck(
    F_C=20.0, F_S=28.0, v_S=2e-3, k_i=[6e6, 3e6], nu_i=[0.5, 0.5], scatter=0.05, seed=4
)


def test_a_contact_is_repeated_with_other_seeds():
    contacts = economy.repeated(Told({("measurement", "seeds"): 3.0}), SCATTERING)
    assert [contact.values["seed"] for contact in contacts] == [4, 5, 6]
    assert contacts[0] == SCATTERING
    plain = friction.coulomb(F_C=3.0)
    assert economy.repeated(Told({("measurement", "seeds"): 2.0}), plain) == [plain, plain]
    assert economy.quiet(SCATTERING).values["scatter"] == 0.0
    assert economy.quiet(plain) == plain


def test_branches_from_the_lower_end_are_judged_on_motions_that_were_not_measured(monkeypatch):
    asked, told = [], []

    class Read:
        """What is read of a contact, by its seed."""

        def __init__(self, seed):
            self.x, self.torque = (
                np.zeros(2),
                np.array([0.0, {1: 10.0, 2: 8.0}.get(seed // 100, 5.0)]),
            )

        def since(self, turn):
            assert turn == 2  # the way to the lower end is left out
            return self

    def measured(setting, model, turns, generator):
        asked.append((model.values["seed"], [round(1e6 * turn, 9) for turn in turns]))
        return Read(model.values["seed"])

    def fit(record, arm):
        assert (record.torque[1], arm) == (5.0, ARM)
        return (
            None
            if len(asked[-1][1]) == 5
            else SimpleNamespace(torque=lambda x: np.array([0.0, 9.0]))
        )

    monkeypatch.setattr(economy, "measured", measured)
    monkeypatch.setattr(economy, "WAYS", {"way": fit})
    setting = Told(
        {
            ("measurement", "branches"): [1.0, 4.0],
            ("measurement", "extent"): 4e-6,
            ("measurement", "speed"): 2e-6,
        }
    )
    setting.arm = ARM
    item = economy.economy(setting, SCATTERING, 2, lambda share, text: told.append((share, text)))
    unseen, branches = asked[:12], asked[12:]
    assert [seed for seed, _ in unseen] == [
        seed + index for index in range(6) for seed in (100, 200)
    ]
    for (_, path), (_, again) in zip(unseen[::2], unseen[1::2], strict=True):
        assert path == again
        assert path[:3] == [-4.0, 4.0, -4.0]
        assert len(path) == 27
        assert 2.0 < max(map(abs, path[3:])) <= 3.6
    assert len({tuple(path) for _, path in unseen}) == 6
    many = [-4.0, 4.0, -4.0, 4.0, -4.0, 2.0, -4.0, 0.0, -4.0, -2.0, -4.0]
    assert branches == [(seed, path) for path in (many[:5], many) for seed in (0, 1)]
    assert told == [
        (k / 4.0, f"branches measured: {count}") for k, count in enumerate((1, 1, 4, 4))
    ]
    assert item.errors["way"] == pytest.approx(
        np.array([[math.nan] * 2, [100.0 * math.sqrt(0.5) / 10.0] * 2]), nan_ok=True
    )
    # Two runs differ by the scatter of both.
    assert item.floor == pytest.approx(100.0 * math.sqrt(2.0) / 8.0 / math.sqrt(2.0))
    assert (item.counts, item.duration) == ([1, 4], pytest.approx(4.0))


ARM = 2e-3


def record_of(operator, offset):
    """What is read of an operator along branches that leave its lower end."""
    tops = [4e-6, 3e-6, 2e-6, 1e-6]
    path, turns = [np.array([-4e-6])], [0]
    for top in tops:
        for a, b in ((-4e-6, top), (top, -4e-6)):
            path.append(np.linspace(a, b, 161)[1:])
            turns.append(turns[-1] + 160)
    x = np.concatenate(path)
    torque = offset + ARM * response(operator, x, history=[x[0]])
    return Record(x, torque, np.array(turns), Walk(x, torque, np.array(turns)))


def test_each_way_finds_the_operator_that_was_measured():
    truth = hysteresis.preisach(kernel="reformed_dahl_exact", s=1.2e7, f_p=20.0)
    record = record_of(truth, 5e-3)
    item = economy.fitted_reformed_dahl(record, ARM)
    assert (item.operator.values["s"], item.operator.values["f_p"]) == (
        pytest.approx(1.2e7, rel=1e-4),
        pytest.approx(20.0, rel=1e-4),
    )
    assert (item.offset, item.arm) == (pytest.approx(5e-3, rel=1e-3), ARM)
    largest = np.max(np.abs(record.torque))
    for fit, near in (
        (economy.fitted_reformed_dahl, 1e-5),
        (economy.fitted_stops, 0.02),
        (economy.fitted_table, 0.03),
    ):
        left = record.torque - fit(record, ARM).torque(record.x)
        assert np.sqrt(np.mean(left**2)) < near * largest


def test_stops_may_have_an_offset_of_either_sign():
    truth = hysteresis.prandtl_ishlinskii(thresholds=[1e-6, 3e-6], weights=[4e6, 2e6], spring=0.0)
    for offset in (8e-3, -8e-3):
        item = economy.fitted_stops(record_of(truth, offset), ARM)
        assert item.offset == pytest.approx(offset, rel=0.05)
        assert min(item.operator.values["weights"]) >= 0.0


def test_operators_are_compared_with_a_record_from_its_first_position(monkeypatch):
    record, begun = (
        record_of(hysteresis.prandtl_ishlinskii(thresholds=[1e-6], weights=[2e6], spring=0.0), 0.0),
        [],
    )
    monkeypatch.setattr(
        economy,
        "response",
        lambda operator, x, history: begun.append((*history, x[0], x.size)) or 2.0 * x,
    )
    assert economy._with_offset("operator", record, 0.5).offset == pytest.approx(
        np.mean(record.torque - record.x)
    )
    economy.fitted_stops(record, ARM)
    economy.fitted_reformed_dahl(record, ARM)
    economy.Fitted("operator", 0.25, 0.5).torque(record.x)
    assert len(begun) > economy.STOPS + 2
    assert {(first, x) for first, x, _ in begun} == {(record.x[0], record.x[0])}
    assert economy.Fitted("operator", 0.25, 0.5).torque(np.array([1.0, 3.0])).tolist() == [
        1.25,
        3.25,
    ]


def test_a_single_branch_makes_no_surface():
    record = record_of(hysteresis.stop(r=1e-6), 0.0)
    assert economy.fitted_table(record._replace(turns=record.turns[:3]), ARM) is None
    assert economy.fitted_table(record._replace(turns=record.turns[:5]), ARM) is not None


# --- words ---------------------------------------------------------------------------------------------------------


def tips(*torques):
    """Records of loops with these torques at their forward tips."""
    return [SimpleNamespace(torque=np.array([-0.2, torque])) for torque in torques]


SHORT = led(0.0, 0.02, 0.03, x=[0.0, 5e-6, 14e-6])
RETURNS = led(4.0, -8.0, 5.0, 1.0, 3.0, 2.0)
LEVEL = led(0.0, 2.0, 3.0, 3.0, 2.0, x=[0.0, 1e-6, 2e-6, 3e-6, 4e-6])


@pytest.mark.parametrize(
    ("told", "given", "words"),
    [
        (reproduced.percent, (0.1234,), "12.3 %"),
        (reproduced.percent, (0.1234, 1.0), "12 %"),
        (reproduced.in_micrometres, (1.234e-6,), "1.23 µm"),
        (reproduced.in_micrometres, (1.234e-6, 2), "1.2 µm"),
        (reproduced.in_millinewtons, (0.0391474, 5), "39.147 mN·m"),
        (reproduced.spread, ([1.0, 1.0, 1.0], 0.0), "1.000"),
        (reproduced.spread, ([1.0, 1.0 + 1e-12], 0.0), "1.000"),
        (reproduced.spread, ([2.0], 0.1), "2.00"),
        (reproduced.spread, ([1.0, 3.0], 0.0), "2.0 ± 1.4"),
        (reproduced.spread, ([1.0, 1.0001], 0.1), "1.00"),  # less than a hundredth of the step
        (reproduced.spread, ([1.0, 1.01], 0.1), "1.0050 ± 0.0071"),
        (plane._rounding, (9e-16,), "rounding"),
        (plane._rounding, (2e-15,), "2e−15 N·m"),
        (tracking.with_spread, (1.4562, 0.0343), "1.456 ± 0.034"),
        (tracking.with_spread, (1.4562, math.nan), "1.456"),
        (tracking.with_spread, (12.342, 0.56, 0.1), "12.34 ± 0.56"),
        (loops._tips, (tips(0.0041, 0.0043, 0.0046), np.max), "4.33 ± 0.25"),
        (loops._tips, (tips(0.1234), np.max), "123.4"),
        (paths._comes_back, (0.0049, "D"), "closes at D"),
        (paths._comes_back, (-0.0049, "D"), "closes at D"),
        (
            paths._comes_back,
            (-0.123, "D"),
            "on return to D, the torque is 12.3 % of the largest torque too small",
        ),
        (
            paths._comes_back,
            (0.05, "D"),
            "on return to D, the torque is 5.0 % of the largest torque too large",
        ),
        (paths._at_return, (0.0049,), "closes"),
        (paths._at_return, (-0.0049,), "closes"),
        (paths._at_return, (-0.123,), "−12.3 % at the return"),
        (paths._at_return, (0.05,), "5.0 % at the return"),
        # The missing torque is a share of the largest one, and the worse of two returns is in the title.
        (paths._missing_at, (RETURNS, (0, 2)), pytest.approx(1.0 / 8.0)),
        (
            paths._missing_of,
            (RETURNS,),
            {"D": pytest.approx(-2.0 / 8.0), "B": pytest.approx(-2.0 / 8.0)},
        ),
        (paths._worst, ({"rig": {"D": 0.01, "B": -0.2}},), {"rig": "−20.0 % at the return"}),
        (paths._worst, ({"gate": {"D": 0.0, "B": 0.001}},), {"gate": "closes"}),
        # A torque is reached where the walk first has it.
        (paths._reached, (LEVEL, 3.0), 2e-6),
        (paths._reached, (LEVEL, 2.5), 2e-6),
        (paths._reached, (LEVEL, 3.1), pytest.approx(math.nan, nan_ok=True)),
        # An error is a root mean square in percent of the largest torque, and long signals are thinned.
        (
            economy._percent,
            (np.array([3.0, -4.0]), np.array([1.0, -50.0])),
            pytest.approx(100.0 * math.sqrt(12.5) / 50.0),
        ),
        (lambda count: economy._decimated(np.arange(count)).size, (7999,), 7999),
        (lambda count: economy._decimated(np.arange(count))[:3].tolist(), (12_001,), [0, 3, 6]),
        # A contact without break-away gives its last force.
        (
            paths._breaks_away,
            ("rig", SHORT, 0.04, math.nan),
            "rig breaks away at 40.0 mN·m, and reaches 75 % of it after 14.0 µm.",
        ),
        (
            paths._breaks_away,
            ("rig", SHORT, 0.04, 7e-6),
            "rig breaks away at 40.0 mN·m, and reaches 95 % of it after 7.00 µm.",
        ),
    ],
)
def test_numbers_of_figures_and_how_they_are_told(told, given, words):
    assert told(*given) == words


class Loop:
    """A loop with a spread over its runs."""

    spread: ClassVar = {"following_error": {"peak_to_peak": 2e-8}, "runs": 3}

    def as_dict(self):
        return {"following_error": {"peak_to_peak": 1.5e-6, "mean": 1e-7}, "effort": {"rms": 0.5}}


def test_a_number_of_a_loop_is_quoted_in_micrometres_with_its_spread():
    assert tracking.spread_of(Loop(), "following_error", "peak_to_peak") == 2e-8
    for keys in (("following_error", "mean"), ("effort", "rms"), ("runs",), ("runs", "deeper")):
        assert math.isnan(tracking.spread_of(Loop(), *keys))
    assert tracking.quoted(Loop(), "following_error", "peak_to_peak") == "1.500 ± 0.020"
    assert tracking.quoted(Loop(), "following_error", "mean") == "0.100"
    assert tracking.quoted(Loop(), "effort", "rms", factor=1e3, step=0.1) == "500.00"


# --- figures of made-up walks ----------------------------------------------------------------------------------------


class Bench(Told):
    """An experiment on a bench, with contacts."""

    origin, arm = None, ARM
    operator = hysteresis.preisach(kernel="reformed_dahl_exact", s=1.2e7, f_p=20.0)

    def __init__(self, turns, **contacts):
        super().__init__({("path", "turns"): np.array(turns), ("path", "speed"): 1e-6})
        self.contacts = {name.replace("_", " "): model for name, model in contacts.items()}

    def contact(self, name):
        return self.contacts[name]


def test_4_corrected_sums_are_the_operator_and_printed_sums_have_a_constant_or_a_factor_too_much():
    path = [-6e-6, 4e-6, -3e-6, 2e-6]
    item = plane.figure_4(Bench(path))
    torque, unit, signed = (
        np.array(item.numbers[key])
        for key in (
            "torque",
            "by_printed_sums_of_relays_0_and_1",
            "by_printed_sums_of_relays_of_both_signs",
        )
    )
    half = ARM * response(Bench.operator, [-6e-6, 6e-6])[-1]
    assert torque == pytest.approx(ARM * response(Bench.operator, path)[1:])
    assert item.numbers["by_corrected_sums"] == pytest.approx(torque)
    assert item.numbers["half_of_the_saturation_loop"] == pytest.approx(half)
    assert unit == pytest.approx(torque + half)
    assert signed == pytest.approx(0.5 * unit)
    assert (item.number, item.verdict) == (4, "found in part")
    words = f"Torque in mN·m at the input of each stage; half the saturation loop is {reproduced.in_millinewtons(half, 5)}"
    assert item.tables[0].caption == words
    assert [row[:2] for row in item.tables[0].rows] == [
        ("(a)", "(14)"),
        ("(b)", "(15)"),
        ("(c)", "(14)"),
    ]
    assert [float(row[4].replace("−", "-")) for row in item.tables[0].rows] == pytest.approx(
        [1e3 * half] * 3, abs=0.006
    )
    assert item.found[0].endswith("at every stage, to rounding.")
    assert (
        f"an error of up to {reproduced.in_millinewtons(float(np.max(np.abs(signed - torque))))} "
        in item.found[1]
    )


@pytest.mark.parametrize(
    ("path", "fits"),
    [
        ([-6e-6, 4e-6], False),
        ([-6e-6, 4e-6, -5.9e-6], True),
        ([-6e-6, 4e-6, -6e-6], False),
        ([-6e-6, 4e-6, 5e-6], False),
        ([-6e-6, 6e-6, 1e-6], False),
        ([-6e-6, 5.9e-6, 1e-6], True),
        ([0.0, -1e-6, -0.5e-6], False),
    ],
)
def test_4_a_path_begins_far_down_and_turns_inside_the_two_before(path, fits):
    if fits:
        assert len(plane.figure_4(Bench(path)).numbers["torque"]) == 2
    else:
        with pytest.raises(
            InputError,
            match=r"x\.toml: path\.turns.*must start at its most negative position, and each of",
        ):
            plane.figure_4(Bench(path))


@pytest.mark.parametrize(
    ("rig", "verdict"),
    [(0.019, "built in in part"), (-0.019, "built in in part"), (0.021, "refuted")],
)
def test_1_the_gap_of_lugre_is_much_larger_than_that_of_the_rig(monkeypatch, rig, verdict):
    walks = {"LuGre": led(5.0, 10.0, 4.0), "virtual rig": led(5.0, 10.0, 5.0 + 10.0 * rig)}
    monkeypatch.setattr(paths, "_walks_of", lambda setting, *names: walks)
    item = paths.figure_1(Bench([3e-6, 1e-6, 3e-6]))
    assert (item.number, item.verdict) == (1, verdict)
    assert item.numbers["missing_at_return"] == pytest.approx({"LuGre": -0.1, "virtual rig": rig})


def on_bench(monkeypatch, walk_of):
    """Let a contact that is led be this walk, and its sensor read it as it is."""
    monkeypatch.setattr(
        paths,
        "led",
        lambda setting, model, *path: SimpleNamespace(
            sensor=walk_of(model), friction=walk_of(model), sensed=None
        ),
    )
    monkeypatch.setattr(paths, "repeated", lambda setting, model: [model, model])
    monkeypatch.setattr(paths, "bench_of", lambda setting: None)
    monkeypatch.setattr(paths, "sensor_numbers", lambda runs: {"runs": len(runs)})
    monkeypatch.setattr(
        paths, "sensor_says", lambda bench, numbers, condition: f"{condition}: {numbers['runs']}"
    )


@pytest.mark.parametrize(
    ("at", "verdict"),
    [(5.9, "refuted"), (6.0, "calibrated"), (8.0, "calibrated"), (8.1, "refuted")],
)
def test_8_the_rig_breaks_away_after_seven_micrometres(monkeypatch, at, verdict):
    path = led(0.0, 0.94, 0.95, 1.0, x=[0.0, 1e-6, at * 1e-6, 2e-5])
    on_bench(monkeypatch, lambda model: path)
    monkeypatch.setattr(
        paths, "_walks_of", lambda setting, *names: {"virtual rig": path, "other": path}
    )
    monkeypatch.setattr(paths, "holding_of", lambda model: SimpleNamespace(forward=model / ARM))
    item = paths.figure_8(Bench([1e-5], virtual_rig=0.5, other=1.2))
    assert (item.number, item.verdict) == (8, verdict)
    # The larger of limit and top.
    assert item.numbers["break_away"] == {"virtual rig": 1.0, "other": pytest.approx(1.2)}
    assert item.numbers["positions_of_runs"] == [at * 1e-6] * 2
    assert math.isnan(item.numbers["position_at_95_percent"]["other"])
    with pytest.raises(InputError, match="must contain positive positions only"):
        paths.figure_8(Bench([0.0], virtual_rig=0.5))


@pytest.mark.parametrize(
    ("share", "verdict"),
    [(0.099, "built in"), (-0.099, "built in"), (0.101, "refuted"), (-0.101, "refuted")],
)
def test_9_no_run_misses_a_return_by_more_than_the_scatter(monkeypatch, share, verdict):
    walks = {
        "rig": led(10.0, 0.0, 5.0, 1.0, 5.0, 10.0),
        "other": led(8.0, 0.0, 5.0, 1.0, 5.0 + 10.0 * share, 8.0, 10.0, turns=range(6)),
    }
    on_bench(monkeypatch, walks.get)
    item = paths.figure_9(
        Bench([6e-6, 0.0, 4e-6, 1e-6, 4e-6, 6e-6], virtual_rig="rig", other="other")
    )
    assert (item.number, item.verdict) == (9, verdict)
    assert item.numbers["missing_at_return"]["other"] == pytest.approx({"D": share, "B": 0.0})
    assert [len(runs) for runs in item.numbers["missing_of_runs"].values()] == [2, 2]
    assert item.found[-1] == "At this speed: 4"


@pytest.mark.parametrize(
    ("shares", "verdict"),
    [
        ((0.0, 0.0), "found"),
        ((0.0049, 0.0049), "found"),
        ((0.0, 0.0051), "found in part"),
        ((0.0, -0.0051), "found in part"),
        ((0.0051, 0.0), "refuted"),
        ((0.01, 0.01), "refuted"),
    ],
)
def test_10_branches_close_their_loops_and_equations_do_or_do_not(monkeypatch, shares, verdict):
    def walk(share):
        return led(10.0, 0.0, 5.0, 1.0, 5.0 + 10.0 * share, 10.0, turns=range(6))

    on_bench(monkeypatch, lambda model: walk(0.0))
    branches = SimpleNamespace(
        inputs=np.arange(5.0), operator=lambda: "operator", corner_error=0.125, symmetry_error=0.25
    )
    asked, drawn = [], []
    monkeypatch.setattr(
        paths.hysteresis,
        "transition_branches",
        lambda *numbers, count: asked.append((*numbers, count)) or branches,
    )
    monkeypatch.setattr(
        paths,
        "follow",
        lambda operator, turns, arm: asked.append((operator, arm)) or walk(shares[0]),
    )
    monkeypatch.setattr(
        paths, "_walks_of", lambda setting: {"virtual rig": walk(0.0), "printed": walk(shares[1])}
    )
    monkeypatch.setattr(
        paths, "marked_path", lambda *passed, **compared: drawn.append((passed, compared))
    )
    bench = Bench([6e-6, 0.0, 4e-6, 1e-6, 4e-6, 6e-6], virtual_rig="rig")
    bench |= {
        ("transition_branches", key): value
        for key, value in {"s": 1e7, "f_p": 20.0, "x_r": 5e-6, "count": 3.0}.items()
    }
    item = paths.figure_10(bench)
    assert (item.number, item.verdict) == (10, verdict)
    assert asked == [(1e7, 20.0, 5e-6, 3), ("operator", ARM)]
    name = "4 branches, over z"
    assert list(item.numbers["missing_at_return"]) == [name, "printed"]
    assert item.numbers["missing_at_return"][name]["D"] == pytest.approx(shares[0])
    assert [row[0] for row in item.tables[0].rows] == [name, "printed"]
    assert item.tables[0].rows[1][1] == reproduced.number(100.0 * shares[1], resolution=1.0)
    assert "the 4 do not belong to an operator" in item.found[2]
    assert "12.5 % of the tip is missing, and the two directions differ by 25 %" in item.found[
        2
    ].replace("25.0 %", "25 %")
    item.draw()
    ((passed, compared),) = drawn
    assert (passed[1][name], passed[2], passed[4:]) == (
        [0, *range(6)],
        "ABCDEDBF",
        ("translational", "rotational"),
    )
    assert passed[3]["printed"] == f"printed: {paths._at_return(shares[1])}"
    assert (list(compared["beneath"]), compared["names"]) == (
        [name, "printed"],
        ("virtual rig, torque sensor", "model"),
    )


@pytest.mark.parametrize(
    ("step", "verdict"), [(0.19e-6, "built in"), (-0.19e-6, "built in"), (0.21e-6, "refuted")]
)
def test_3_an_orbit_is_closed_to_a_fiftieth_and_encloses_the_work_of_its_torque(
    monkeypatch, step, verdict
):
    run, width = rippled([step] * 4, 10e-6), 10e-6
    side = np.sign(np.diff(run.x))
    # Before the first cycle it is pushed over break-away.
    beside = np.where(np.arange(side.size) < 2, 6.0, 3.0)
    run = run._replace(cycles=run.cycles[1:], sensed=Sensed(2.0 * side, 2.0 * side, beside * side))
    monkeypatch.setattr(drift, "rippled", lambda setting, model: run)
    monkeypatch.setattr(drift, "bench_of", lambda setting: None)
    monkeypatch.setattr(drift, "sensor_says", lambda *passed: "")
    item = drift.figure_3(Bench([], virtual_rig="rig"))
    assert (item.number, item.verdict) == (3, verdict)
    assert item.numbers["share_of_the_orbit"]["virtual rig"] == pytest.approx(abs(step) / run.width)
    # There and back, but for the step that stays.
    assert item.numbers["work_of_friction"] == pytest.approx([2.0 * (2.0 * width - step) / ARM] * 2)
    assert item.numbers["work_by_torque_sensor"] == pytest.approx(
        [3.0 * (2.0 * width - step) / ARM] * 2
    )
    assert [
        item.numbers[f"torque_sensor{part}"]["apart"] for part in ("", "_at_break_away")
    ] == pytest.approx([0.5, 2.0])


@pytest.mark.parametrize(
    ("bottom", "tops", "verdict"),
    [
        (-0.03, (0.04, 0.042), "built in"),
        (-0.0395, (0.04, 0.042), "refuted"),
        (-0.03, (0.04, 0.0405), "refuted"),
        (-0.05, (0.04, 0.042), "built in"),
    ],
)
def test_5_loops_of_the_rig_are_uneven_and_scatter_by_more_than_the_noise(
    monkeypatch, bottom, tops, verdict
):
    small, large = (
        SimpleNamespace(torque=np.array(ends)) for ends in ((-0.01, 0.01), (bottom, 0.04))
    )
    again = [SimpleNamespace(torque=np.array([bottom, top])) for top in tops]
    asked = []
    monkeypatch.setattr(
        loops, "_loops", lambda setting, rounds: {1e-6: [small] * rounds, 4e-6: [large] * rounds}
    )
    monkeypatch.setattr(
        loops,
        "measured_loop",
        lambda setting, model, amplitude, rounds, generator: (
            asked.append((amplitude, rounds)) or again
        ),
    )
    monkeypatch.setattr(
        loops,
        "led",
        lambda setting, model, turns, speed: asked.append(turns) or SimpleNamespace(sensed=None),
    )
    for name in ("bench_of", "sensor_numbers"):
        monkeypatch.setattr(loops, name, lambda passed: None)
    monkeypatch.setattr(loops, "sensor_says", lambda *passed: "")
    bench = Bench([], virtual_rig="rig")
    bench |= {
        ("measurement", "repeats"): 2.0,
        ("measurement", "noise"): 1e-4,
        ("measurement", "speed"): 1e-6,
    }
    item = loops.figure_5(bench)
    assert (item.number, item.verdict, asked) == (5, verdict, [(4e-6, 2), [4e-6, -4e-6, 4e-6]])
    assert item.numbers["largest_loop"] == [bottom, 0.04]
    assert item.numbers["forward_tips"] == list(tops)
    assert [row[:2] for row in item.tables[0].rows] == [("1.0", "2"), ("4.0", "2")]
