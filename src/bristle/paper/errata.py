"""What in the paper cannot stand as printed: each with what is right, and the test that shows it."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["ERRATA", "Erratum"]

DRIFT = "papers/test_source_paper_drift.py"
PREISACH = "papers/test_source_paper_preisach.py"
ERRATA_TESTS = "papers/test_source_paper_errata.py"
FIGURES = "paper/test_figures.py"


class Erratum(NamedTuple):
    """One place of the paper.

    Parameters
    ----------
    place : str
        Number of an equation or figure, or a section.
    printed : str
        What is printed, and what is wrong with it.
    correct : str
        What is right.
    test : str
        File and name of the test, below ``tests``.
    """

    place: str
    printed: str
    correct: str
    test: str


ERRATA = (
    Erratum(
        "(2), (3)",
        "σ₀ is counted twice: (3) makes σ₀ g the Stribeck curve G, and (2) divides σ₀ z by g alone. The bristles then "
        "settle at G/σ₀², and sliding friction at G/σ₀ instead of (4).",
        "ż = v (1 − σ₀ z sgn v / G(v)), or ż = v − |v| z / g(v) with σ₀ g = G.",
        "papers/test_canudas_1995.py::test_a_bristle_equation_with_the_stiffness_counted_twice_misses_its_own_steady_state",
    ),
    Erratum(
        "(4), (11)",
        "Equal, as is said, but only with (2) and (3) corrected; the first line of (11) lacks the sign of v.",
        "F = G(v) sgn v + σ₂ v, in both directions.",
        f"{DRIFT}::test_steady_sliding_is_that_of_lugre_for_every_composite",
    ),
    Erratum(
        "below (3)",
        "σ₁ is called the viscous friction of the bristles, and v_s the velocity of the position.",
        "σ₁ damps the bristles while they stretch and does nothing in steady sliding; σ₂ is the viscous friction.",
        "papers/test_canudas_1995.py::test_micro_damping_is_not_viscous_friction",
    ),
    Erratum(
        "figures",
        "(18) is written in torque and angle, the figures in torque and micrometres.",
        "x = θ ℓ/2π with the lead ℓ: at 5 mm one micrometre is 1.2566 mrad, and s, σ₁, σ₂ convert with its square.",
        f"{ERRATA_TESTS}::test_a_micrometre_of_the_table_is_1_2566_milliradians_at_5_mm_lead",
    ),
    Erratum(
        "(5)–(7), drift",
        "LuGre drifts, the rig does not, “thus” (5)–(7) are proposed. That they do not drift is not said, and does not "
        "follow: they slip in proportion to the torque, as LuGre does, and drift by a sixth more.",
        "ż = v (1 − Φ) with Φ = 0 up to a share of G(v): a gate on f_h sgn v / G(v).",
        f"{DRIFT}::test_the_printed_model_drifts_more_than_the_one_that_it_mends",
    ),
    Erratum(
        "(5)–(7), loops",
        "The memory is in z. Minor loops close in z, and stay open over the position, by 17 % of F_s on the loop of "
        "the test.",
        "With the gate z is the position below the gate, and loops close over both.",
        f"{DRIFT}::test_its_minor_loop_is_open_in_the_position",
    ),
    Erratum(
        "(5)–(7), z",
        "f_h is identified from records over the position and then driven by z, as if both were one. At 0.9 F_s the "
        "body has moved 15.5 µm, the bristles 3.7 µm.",
        "With the gate they are one, up to the gate.",
        f"{DRIFT}::test_z_is_not_the_position",
    ),
    Erratum(
        "(6), f_p",
        "(9) asks that f_h reaches G(v). Nothing says that it can.",
        "The saturation of the operator must exceed the break-away force, f_p > F_s; else z grows for as long as the "
        "body slides.",
        f"{ERRATA_TESTS}::test_6_the_deflection_is_bounded_only_with_f_p_above_F_S",
    ),
    Erratum(
        "(8)–(10)",
        "z is taken to rest while the body slides. It does at constant speed; where the speed rises, G falls and z "
        "runs backward without any reversal of the velocity.",
        "Turning points belong to the sign of ż, not of v.",
        f"{ERRATA_TESTS}::test_8_z_turns_back_where_G_falls_though_v_does_not",
    ),
    Erratum(
        "(12), μ",
        "A distribution, taken for positive as in magnetism, with γ z(t) like a product.",
        "γ[z] is an operator. Friction needs μ < 0 off the diagonal and a positive line on it; with μ ≥ 0 a loop gives "
        "energy back.",
        f"{PREISACH}::test_12_a_measure_of_friction_cannot_be_positive",
    ),
    Erratum(
        "(12), input",
        "z is called monotonically increased or decreased.",
        "Piecewise: a monotone input has no hysteresis to speak of.",
        f"{PREISACH}::test_14_and_15_with_factor_2_and_offset_are_the_turning_points",
    ),
    Erratum(
        "(13)",
        "A sum over k before an integral over S⁺, and no S⁻: at negative saturation the force would be zero.",
        "f_h = ∬ μ over S⁺ − ∬ μ over S⁻ = 2 ∬ μ over S⁺ − ∬ μ over both.",
        f"{PREISACH}::test_13_needs_the_relays_that_are_down_too",
    ),
    Erratum(
        "(14), (15)",
        "No factor 2 and no offset for relays of ±1; F(α, β) is called the integral over a trapezoid.",
        "Both, with F the integral over a triangle, the trapezoid being the difference of two.",
        f"{PREISACH}::test_14_as_printed_is_not",
    ),
    Erratum(
        "(16), (17), reversals",
        "Right, with f′ = s ((f_p − f)/(f_p + f_r))², but only for a reversal at ±x_r.",
        "From a reversal at β with the force f_β: f = f_β + P s d/(P + s d), P = f_p − f_β, d = x − β; mirrored "
        "descending.",
        f"{ERRATA_TESTS}::test_16_and_17_are_the_branch_from_a_general_reversal",
    ),
    Erratum(
        "(16), (17), memory",
        "Chained, they are taken for a hysteresis with non-local memory.",
        "They remember the last reversal only: a loop inside a larger one does not close.",
        f"{ERRATA_TESTS}::test_16_and_17_chained_do_not_return_to_the_outer_loop",
    ),
    Erratum(
        "f_r",
        "Written with f_s and S beside f_p and s, as if they were others.",
        "The loop closes only with f_s = f_p and S = s: f_r = f_p/2 [√((1+k)² + 4k) − (1+k)], k = s x_r/f_p.",
        f"{PREISACH}::test_17_closes_with_no_other_tip",
    ),
    Erratum(
        "(16), name",
        "The “reformed” Dahl model is taken for Dahl's with exponent 2.",
        "Its slope at a reversal is s for every f_r; that of Dahl's with exponent 2 is s (1 + f_r/f_p)².",
        f"{ERRATA_TESTS}::test_16_reverses_with_the_slope_s_and_dahl_2_does_not",
    ),
    Erratum(
        "(17), virgin",
        "The branch from f_r = 0 is the first loading of the model, and not the line on which the tips of its loops "
        "lie.",
        "For a Preisach operator the virgin curve must be that line; they differ by up to 0.106 f_p.",
        f"{ERRATA_TESTS}::test_17_the_virgin_branch_is_not_the_locus_of_the_tips",
    ),
    Erratum(
        "section 4, 100 branches",
        "A Preisach plane from 100 branches of (16) and (17).",
        "These branches belong to no operator: corner and symmetry fail by 12 % and 6 % at k = 1, more beyond. "
        "An Everett function in closed form has the same symmetric loops.",
        f"{PREISACH}::test_100_transition_branches_describe_no_operator",
    ),
    Erratum(
        "(19)–(21)",
        "S, s and s(t) name the stiffness of (16) and the sliding surface.",
        "Two quantities, two names: here s is the stiffness and ς = ė + λ e the surface.",
        f"{ERRATA_TESTS}::test_22_friction_holds_the_table_back",
    ),
    Erratum(
        "(22)",
        "(u + F_p)/J, which contradicts (18) and (23): friction would push the table ahead of its command.",
        "ς̇ = θ̈_d − (u − F_p)/J + λ ė.",
        f"{ERRATA_TESTS}::test_22_friction_holds_the_table_back",
    ),
    Erratum(
        "(23)",
        "Feeds F_p forward as if it were known, and takes (21) for what then happens.",
        "u contains an estimate F̂, and ς̇ = −K₁ ς − K₂ sgn ς + (F_p − F̂)/J: the surface is reached only where K₂ "
        "exceeds sup |F_p − F̂|/J.",
        f"{ERRATA_TESTS}::test_23_the_surface_is_reached_only_with_K_2_above_what_is_not_compensated",
    ),
    Erratum(
        "sections 2 and 4",
        "The encoder has 40,000 pulses per revolution, and 10,000.",
        "10,000 lines, four counts each: 0.125 µm at a lead of 5 mm. One count a line, 0.5 µm, cannot give 0.69 µm.",
        f"{ERRATA_TESTS}::test_10000_counts_a_revolution_would_not_do",
    ),
    Erratum(
        "figure 13",
        "“Standard deviation … from −0.2 to 0.9 µm” with the compensator: a range, which is 1.1 µm wide where figure "
        "12 has 0.69 µm. “Mean 2.3 µm” without it: outside its own range of −0.4 to 1 µm.",
        "Range −0.2 to 0.49 µm and mean 0.15 µm with it; range −0.4 to 1 µm and mean 0.23 µm without.",
        f"{FIGURES}::test_13_the_range_and_the_mean_are_those_printed_once_read_right",
    ),
    Erratum(
        "section 4, 53 %",
        "Right: 1 − 0.69/1.46.",
        "52.7 %. But that is a compensator with two thirds of the friction; one that is identified well takes 72 %.",
        f"{FIGURES}::test_12_the_error_falls_by_half_and_by_more_with_a_compensator_that_is_identified",
    ),
    Erratum(
        "names",
        "“Homogenous” loops; Lorenz and Lorenze Messtechnik.",
        "The property is congruency: loops of one width are alike at every force. Reformed Dahl does not have it.",
        f"{ERRATA_TESTS}::test_loops_of_one_width_are_congruent_for_a_masing_kernel_and_not_for_16_and_17",
    ),
)
