"""What in the paper cannot stand as printed, or not in every reading: what is right, and the test that shows it."""

from __future__ import annotations

from typing import Literal, NamedTuple

__all__ = ["ERRATA", "KINDS", "Erratum", "errata_of"]

Kind = Literal["misprint", "gap", "reading", "remark"]
KINDS: dict[Kind, str] = {
    "misprint": "A sign, a symbol, a word or a number that is wrong as printed.",
    "gap": "Something that is needed and not there.",
    "reading": "Right under one reading, wrong under another.",
    "remark": "No error of the paper: what it does not say, or what is worth knowing beside it.",
}

DRIFT = "papers/test_source_paper_drift.py"
PREISACH = "papers/test_source_paper_preisach.py"
ERRATA_TESTS = "papers/test_source_paper_errata.py"
SURFACE = "papers/test_source_paper_surface.py"
FIGURES = "paper/test_figures.py"


class Erratum(NamedTuple):
    """One place of the paper."""

    kind: Kind
    location: str
    printed: str
    correct: str
    test: str


def errata_of(kind: Kind) -> list[Erratum]:
    """Return the errata of a kind, in the order of the paper."""
    return [erratum for erratum in ERRATA if erratum.kind == kind]


ERRATA = (
    Erratum(
        "misprint",
        "(2), (3)",
        "σ₀ is counted twice: (3) makes σ₀ g the Stribeck curve G, and (2) divides σ₀ z by g alone. The bristles then "
        "settle at G/σ₀², and sliding friction at G/σ₀ instead of (4).",
        "ż = v (1 − σ₀ z sgn v / G(v)), or ż = v − |v| z / g(v) with σ₀ g = G.",
        "papers/test_canudas_1995.py::test_a_bristle_equation_with_the_stiffness_counted_twice_misses_its_own_steady_state",
    ),
    Erratum(
        "misprint",
        "(11), first line",
        "G(v) without the sign of v; the second line has it.",
        "F_p = G(v) sgn v + σ₂ v, in both directions.",
        f"{DRIFT}::test_steady_sliding_is_that_of_lugre_for_every_composite",
    ),
    Erratum(
        "misprint",
        "(13)",
        "A sum over k of the integral over S⁺, which does not depend on k: N links would count all of S⁺ N times.",
        "The sum is over the trapezoids Q_k that S⁺ is made of, as the line below it says: Σ ∬ μ over Q_k.",
        f"{PREISACH}::test_13_sums_trapezoids_and_not_the_whole_of_S_plus",
    ),
    Erratum(
        "misprint",
        "below (14)",
        "F(α_k, β_k) is called the integral over Q_k, which is a trapezoid. (14) and (15) take differences of F.",
        "F(α, β) is the integral over the triangle between α and β; a trapezoid is the difference of two.",
        f"{PREISACH}::test_13_sums_trapezoids_and_not_the_whole_of_S_plus",
    ),
    Erratum(
        "misprint",
        "below (17), f_r",
        "Written with f_s and S beside f_p and s, as if they were others.",
        "The loop closes only with f_s = f_p and S = s: f_r = f_p/2 [√((1+k)² + 4k) − (1+k)], k = s x_r/f_p. With "
        "f_s = 0.9 f_p or 1.1 f_p it misses, at k = 2, by 5.3 % of f_p one way and 5.0 % the other.",
        f"{PREISACH}::test_17_closes_with_no_other_tip",
    ),
    Erratum(
        "misprint",
        "(19)–(21)",
        "S, s and s(t) name the stiffness of (16) and the sliding surface.",
        "Two quantities, two names: here s is the stiffness and ς = ė + λ e the surface.",
        f"{ERRATA_TESTS}::test_22_friction_holds_the_table_back",
    ),
    Erratum(
        "misprint",
        "(22)",
        "(u + F_p)/J, which contradicts (18) and (23): friction would push the table ahead of its command.",
        "ς̇ = θ̈_d − (u − F_p)/J + λ ė.",
        f"{ERRATA_TESTS}::test_22_friction_holds_the_table_back",
    ),
    Erratum(
        "misprint",
        "figure 13",
        "“Standard deviation … from −0.2 to 0.9 µm” with the compensator: a range, which is 1.1 µm wide where figure "
        "12 has 0.69 µm. “Mean 2.3 µm” without it: outside its own range of −0.4 to 1 µm.",
        "Range −0.2 to 0.49 µm and mean 0.15 µm with it; range −0.4 to 1 µm and mean 0.23 µm without.",
        f"{FIGURES}::test_13_the_range_and_the_mean_are_those_printed_once_read_right",
    ),
    Erratum(
        "misprint",
        "names",
        "“Homogenous” loops; Lorenz and Lorenze Messtechnik; a deformed and a reformed Dahl model.",
        "The property is congruency: loops of one width are alike at every force. Reformed Dahl by itself does not "
        "have it. Lorenz; reformed.",
        f"{ERRATA_TESTS}::test_loops_of_one_width_are_congruent_for_a_masing_kernel_and_not_for_16_and_17",
    ),
    Erratum(
        "gap",
        "(9)",
        "Asks that f_h reaches G(v). That it can is a condition on the operator, which is not given.",
        "The saturation of the operator must exceed the break-away force, f_p > F_s; else z grows for as long as the body slides.",
        f"{ERRATA_TESTS}::test_6_the_deflection_is_bounded_only_with_f_p_above_F_S",
    ),
    Erratum(
        "gap",
        "(18), figures",
        "(18) is written in torque and angle, the figures in torque and micrometres; the lead is not told.",
        "x = θ ℓ/2π with the lead ℓ: at 5 mm one micrometre is 1.2566 mrad, and s, σ₁, σ₂ convert with its square.",
        f"{ERRATA_TESTS}::test_a_micrometre_of_the_table_is_1_2566_milliradians_at_5_mm_lead",
    ),
    Erratum(
        "gap",
        "(20), (21)",
        "V̇ < 0 is had from (21), where nothing is left of friction; below K₂ = sup |F_p − F̂|/J it is not had.",
        "V̇ ≤ −K₁ ς² − (K₂ − sup |F_p − F̂|/J) |ς|: the surface is reached, or |ς| ends below (sup |F_p − F̂|/J − K₂)/K₁.",
        f"{SURFACE}::test_what_is_left_of_friction_holds_the_state_off_the_surface_by_no_more_than_the_bound",
    ),
    Erratum(
        "gap",
        "(23)",
        "Right once (22) is, but feeds F_p forward as if it were known, and takes (21) for what then happens.",
        "u contains an estimate F̂, and ς̇ = −K₁ ς − K₂ sgn ς + (F_p − F̂)/J: the surface is reached only where K₂ exceeds sup |F_p − F̂|/J.",
        f"{ERRATA_TESTS}::test_23_the_surface_is_reached_only_with_K_2_above_what_is_not_compensated",
    ),
    Erratum(
        "reading",
        "below (3)",
        "σ₁ is called the viscous friction of the bristles, and σ₂ the viscous friction.",
        "Right of the bristles: σ₁ damps them while they stretch. It is no friction of the body: in steady sliding it does nothing.",
        "papers/test_canudas_1995.py::test_micro_damping_is_not_viscous_friction",
    ),
    Erratum(
        "reading",
        "(5)–(7), loops",
        "That f_h makes the model have non-local memory is right over z. Over the position, as in figures 1 and 9, "
        "minor loops stay open: over 0, 3, 1.5 and 3 µm by 17 % of F_s, with the setting of (5)–(7), z.",
        "ż = v (1 − Φ) with a gate: below it z is the position, and loops close over both.",
        f"{DRIFT}::test_its_minor_loop_is_open_in_the_position",
    ),
    Erratum(
        "reading",
        "(5)–(7), z",
        "z is “the position in the pre-sliding region”: f_h is identified from records over the position, and then "
        "driven by z. Right where nothing slips; by (6) something always does. With dahl_masing of exponent 2 for f_h, "
        "s = 158 N/µm, F_c = 126 N, F_s = 163 N and f_p = 1.2 F_s, the body has moved 15.5 µm at 0.9 F_s, the bristles "
        "3.7 µm.",
        "With the gate they are one, up to the gate.",
        f"{DRIFT}::test_z_is_not_the_position",
    ),
    Erratum(
        "reading",
        "(8)–(10)",
        "z rests while the body slides: right at constant speed. Where the speed rises, G falls and z runs backward "
        "without any reversal of the velocity.",
        "Turning points belong to the sign of ż, not of v.",
        f"{ERRATA_TESTS}::test_8_z_turns_back_where_G_falls_though_v_does_not",
    ),
    Erratum(
        "reading",
        "(12), γ z(t)",
        "Reads like a product of γ and a z(t) that is “monotonically increased or decreased”.",
        "γ[z] is an operator on the path of z, and z is monotone by pieces: at one z there is one force after each history.",
        f"{PREISACH}::test_12_the_force_belongs_to_the_path_and_not_to_z",
    ),
    Erratum(
        "reading",
        "(14), (15)",
        "Which values the relays have is not said. With 0 and 1 the sums are right but for one constant: friction is "
        "alike in both directions only with the offset of half the saturation loop, E(α₀, β₀). With the operator of "
        "figure 4, reformed_dahl_exact of 36.3 N/µm and 77.9 N, and α₀ = −β₀ = 6 µm it is 39.147 mN·m at a lead of "
        "5 mm. With relays of ±1 a factor 2 is missing too.",
        "Relays of 0 and 1: f = sums − F(α₀, β₀)/2. Relays of ±1: f = 2 sums − F(α₀, β₀).",
        f"{PREISACH}::test_14_and_15_as_printed_are_right_for_relays_of_0_and_1_but_for_one_constant",
    ),
    Erratum(
        "reading",
        "(16), (17), reversals",
        "x_r is “the linear position at the velocity reversal”. Right, with f′ = s ((f_p − f)/(f_p + f_r))², where the "
        "loop is that between ±x_r; f_r is not the force at any other reversal.",
        "From a reversal at β with the force f_β: f = f_β + P s d/(P + s d), P = f_p − f_β, d = x − β; mirrored descending.",
        f"{ERRATA_TESTS}::test_16_and_17_are_the_branch_from_a_general_reversal",
    ),
    Erratum(
        "reading",
        "below (17), f_p",
        "Defined as “the steady state rolling Coulomb friction force”. Right for (16) and (17) by themselves. As the "
        "saturation of f_h in (6) it leaves f_h < F_C ≤ G(v): (9) has no solution at any speed, and z grows without "
        "bound: with f_p = F_C and the rest as in (5)–(7), z, to 242 µm after 1 mm and 2.3 mm after 10 mm at 1 µm/s.",
        "Two quantities: F_C is the friction of sliding, f_p the force that the bristles could give, f_p ≥ 1.05 F_s.",
        f"{ERRATA_TESTS}::test_9_with_f_p_for_coulomb_friction_has_no_solution_and_z_grows_for_ever",
    ),
    Erratum(
        "reading",
        "section 4, 100 branches",
        "A Preisach plane from 100 branches of (16) and (17). Taken as branches that leave one outer loop, they belong "
        "to no operator: corner and symmetry fail by 12 % and 6 % at k = 1, more beyond.",
        "Taken literally, (16) at each reversal α with its own x_r = α and f_r(x_r), E(α, β) = [f_r(α) − f₁₆(β)]/2, "
        "mirrored by (17), they are an operator, to rounding: reformed_dahl_exact, whose E has a closed form.",
        f"{PREISACH}::test_100_branches_each_of_its_own_loop_are_the_exact_kernel",
    ),
    Erratum(
        "reading",
        "sections 2 and 4",
        "The encoder has 40,000 pulses per revolution, and 10,000: the same, if 10,000 lines give four counts "
        "each. If not, it depends on the lead, which is not told: at 5 mm 10,000 are 0.5 µm, and the bench stays "
        "above 1.2 µm; at 2 mm they are 0.2 µm, with which it has 0.66 to 0.83 µm, and 0.69 µm can be had.",
        "10,000 lines, four counts each: 0.125 µm at a lead of 5 mm. Or a lead of 2 mm.",
        f"{ERRATA_TESTS}::test_10000_counts_a_revolution_do_at_a_lead_of_2_mm_and_not_at_5",
    ),
    Erratum(
        "remark",
        "(4)",
        "Right, and equal to (11), as is said. From (2) and (3) it follows once σ₀ is counted once.",
        "F_ss = G(v) sgn v + σ₂ v.",
        "papers/test_canudas_1995.py::test_steady_sliding_gives_the_stribeck_curve_between_its_limits",
    ),
    Erratum(
        "remark",
        "(5)–(7), origin",
        "The hysteresis of (6) is a Preisach operator; but bristles whose stiffness remembers, and slip by f_h/G, are older.",
        "The model of Leuven (J. Swevers and others, 2000) with exponent 1.",
        "papers/test_swevers_2000.py::test_the_exponent_one_is_the_source_paper",
    ),
    Erratum(
        "remark",
        "(5)–(7), drift",
        "LuGre drifts, the rig does not, “thus” (5)–(7) are proposed. That they do not drift is not said, and does not "
        "follow: they slip in proportion to the torque, as LuGre does, and with the setting of (5)–(7), z, drift by a "
        "sixth more: 0.455 µm a cycle between 50.3 and 100.5 N, LuGre with σ₀ = s 0.389 µm.",
        "ż = v (1 − Φ) with Φ = 0 up to a share of G(v): a gate on f_h sgn v / G(v).",
        f"{DRIFT}::test_the_printed_model_drifts_more_than_the_one_that_it_mends",
    ),
    Erratum(
        "remark",
        "(12), μ",
        "The sign of μ is not said. In magnetism, where the model is taken from, it is positive.",
        "Friction needs μ < 0 off the diagonal and a positive line on it; with μ ≥ 0 a loop gives energy back.",
        f"{PREISACH}::test_12_a_measure_of_friction_cannot_be_positive",
    ),
    Erratum(
        "remark",
        "(16), (17), memory",
        "The paper makes a Preisach plane of them and does not chain them, branch after branch.",
        "Chained they remember the last reversal only: a loop inside a larger one does not close.",
        f"{ERRATA_TESTS}::test_16_and_17_chained_do_not_return_to_the_outer_loop",
    ),
    Erratum(
        "remark",
        "(16), slope",
        "Dahl's model “reformed” is not Dahl's model with exponent 2, whose slope at a reversal is s (1 + f_r/f_p)².",
        "Its slope at a reversal is s for every f_r, as is said below (17).",
        f"{ERRATA_TESTS}::test_16_reverses_with_the_slope_s_and_dahl_2_does_not",
    ),
    Erratum(
        "remark",
        "(17), virgin",
        "The first loading is not spoken of. The branch from f_r = 0 is not the line on which the tips of the loops lie.",
        "For a Preisach operator the virgin curve must be that line; they differ by up to 0.106 f_p.",
        f"{ERRATA_TESTS}::test_17_the_virgin_branch_is_not_the_locus_of_the_tips",
    ),
    Erratum(
        "remark",
        "(21), sampled",
        "Between samples u stands still, and acts late: no computer keeps (21) to the letter.",
        "The surface is reached to a band, near (m + 1) T (K₂ + sup |F_p − F̂|/J) with m samples of delay.",
        f"{SURFACE}::test_sampled_and_late_the_state_stays_in_the_band_and_fills_most_of_it",
    ),
)
