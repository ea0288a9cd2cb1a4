"""The equations of the paper, (1) to (23): how each stands here, what computes it, what tests it, how to see it."""

from __future__ import annotations

from typing import Literal, NamedTuple

__all__ = ["EQUATIONS", "SETUP", "Equation"]

Stands = Literal["as printed", "corrected", "completed"]

DRIFT = "papers/test_source_paper_drift.py"
PREISACH = "papers/test_source_paper_preisach.py"
ERRATA_TESTS = "papers/test_source_paper_errata.py"
LAW = "papers/test_source_paper_sliding_mode.py"
SURFACE = "papers/test_source_paper_surface.py"
CANUDAS = "papers/test_canudas_1995.py"

# What the lines of Python in `run` build on.
SETUP = (
    "import bristle as br",
    "from bristle.bridges.equations import contact_equations",
    "from bristle.paper import sums, surface",
    'sliding = dict(F_C="34 mN*m", F_S="40 mN*m", v_S="0.5 rad/s", sigma_1="30 mN*m*s/rad", sigma_2="3 mN*m*s/rad")',
    'lugre = br.friction.lugre(sigma_0="22 N*m/rad", **sliding)',
    'printed = br.friction.preisach_lugre(transition="paper", s="57 N*m/rad", f_p="62 mN*m", **sliding)',
    'operator = br.hysteresis.preisach(kernel="reformed_dahl_exact", s="57 N*m/rad", f_p="62 mN*m")',
    'branch = br.friction.reformed_dahl(s="57 N*m/rad", f_p="62 mN*m")',
    "slow = [1e-6 * k for k in range(20_000)]  # a microradian in each second",
    "fast = [0.1 * k for k in range(100)]",
)


class Equation(NamedTuple):
    """One equation of the paper."""

    number: int
    title: str
    printed: str
    stands: Stands
    formula: str
    file: str
    test: str
    run: str
    gives: str = ""


STRIBECK = r"F_c + (F_s - F_c)\,e^{-(v/v_s)^2}"

EQUATIONS = (
    Equation(
        1,
        "LuGre: force",
        r"F = \sigma_0 z + \sigma_1\dot z + \sigma_2 v",
        "as printed",
        "",
        "friction/lugre.py",
        f"{CANUDAS}::test_presliding_is_a_spring_of_stiffness_sigma_0",
        "round(contact_equations(lugre)([0, 1e-3], 0.1)[0], 5)",
        "0.02364",
    ),
    Equation(
        2,
        "LuGre: bristles",
        r"\dot z = v\left(1 - \frac{\sigma_0 z}{g(v)}\operatorname{sgn} v\right)",
        "corrected",
        r"\dot z = v\left(1 - \frac{\sigma_0 z}{G(v)}\operatorname{sgn} v\right),\quad G = \sigma_0 g",
        "friction/lugre.py",
        f"{CANUDAS}::test_a_bristle_equation_with_the_stiffness_counted_twice_misses_its_own_steady_state",
        "contact_equations(lugre)([0, 1e-3], 0.1)[1].round(4)",
        "[0.1    0.0447]",
    ),
    Equation(
        3,
        "LuGre: Stribeck curve",
        rf"\sigma_0 g(v) = {STRIBECK}",
        "as printed",
        "",
        "friction/lugre.py",
        f"{CANUDAS}::test_steady_sliding_gives_the_stribeck_curve_between_its_limits",
        "br.response(lugre, slow, dt=1)[-1].round(3)",
        "0.04",
    ),
    Equation(
        4,
        "LuGre: steady sliding",
        r"F_{ss} = F_c\operatorname{sgn} v + (F_s - F_c)\,e^{-(v/v_s)^2}\operatorname{sgn} v + \sigma_2 v",
        "as printed",
        "",
        "friction/lugre.py",
        f"{CANUDAS}::test_steady_sliding_gives_the_stribeck_curve_between_its_limits",
        "br.response(lugre, fast, dt=0.1)[-1].round(4)",
        "0.0371",
    ),
    Equation(
        5,
        "Proposed model: force",
        r"F_p = f_h(z) + \sigma_1\dot z + \sigma_2 v",
        "as printed",
        "",
        "friction/preisach_lugre.py",
        f"{DRIFT}::test_its_loops_close_in_z_which_is_what_its_figure_10_can_show",
        "br.response(printed, [0, 1e-3, 0, 1e-3], dt=1).round(4)",
        "[ 0.      0.0146 -0.0014  0.0065]",
    ),
    Equation(
        6,
        "Proposed model: bristles",
        r"\dot z = v\left(1 - \frac{f_h(z)}{G(v)}\operatorname{sgn} v\right)",
        "completed",
        r"\dot z = v\left[1 - \Phi\left(\frac{f_h}{G(v)}\operatorname{sgn} v\right)\right],\quad f_p > F_s",
        "friction/preisach_lugre.py",
        f"{DRIFT}::test_with_a_gate_in_its_place_both_hold",
        "bristle paper --figure 10",
    ),
    Equation(
        7,
        "Proposed model: Stribeck curve",
        rf"G(v) = {STRIBECK}",
        "as printed",
        "",
        "friction/preisach_lugre.py",
        f"{DRIFT}::test_steady_sliding_is_that_of_lugre_for_every_composite",
        "br.response(printed, slow, dt=1)[-1].round(3)",
        "0.04",
    ),
    Equation(
        8,
        "Sliding: the bristles rest",
        r"\dot z = 0,\quad v \ne 0",
        "completed",
        r"\dot z \to 0,\quad v \ne 0 \text{ constant}",
        "friction/preisach_lugre.py",
        f"{ERRATA_TESTS}::test_8_z_turns_back_where_G_falls_though_v_does_not",
        "bristle paper --figure 8",
    ),
    Equation(
        9,
        "Sliding: the ratio is one",
        r"1 = \frac{f_h(z)}{G(v)}\operatorname{sgn} v",
        "completed",
        r"1 = \frac{f_h(z)}{G(v)}\operatorname{sgn} v,\quad f_p > F_s",
        "friction/preisach_lugre.py",
        f"{ERRATA_TESTS}::test_9_with_f_p_for_coulomb_friction_has_no_solution_and_z_grows_for_ever",
        "(br.response(printed, slow, dt=1)[-1] / 40e-3).round(3)",
        "0.995",
    ),
    Equation(
        10,
        "Sliding: hysteretic force",
        r"f_h(z) = G(v)\operatorname{sgn} v",
        "as printed",
        "",
        "friction/preisach_lugre.py",
        f"{DRIFT}::test_steady_sliding_is_that_of_lugre_for_every_composite",
        "br.response(printed, fast, dt=0.1)[-1].round(4)",
        "0.0371",
    ),
    Equation(
        11,
        "Sliding: friction",
        rf"F_p = G(v) + \sigma_2 v = \left[{STRIBECK}\right]\operatorname{{sgn}} v + \sigma_2 v",
        "corrected",
        r"F_p = G(v)\operatorname{sgn} v + \sigma_2 v",
        "friction/preisach_lugre.py",
        f"{DRIFT}::test_steady_sliding_is_that_of_lugre_for_every_composite",
        "br.response(printed, [-x for x in fast], dt=0.1)[-1].round(4)",
        "-0.0371",
    ),
    Equation(
        12,
        "Preisach operator",
        r"f_h(z) = \iint_{\alpha\geq\beta}\mu(\alpha,\beta)\,\gamma_{\alpha\beta}z(t)\,d\alpha\,d\beta",
        "completed",
        r"f_h[z] = \iint_{\alpha\geq\beta}\mu(\alpha,\beta)\,\gamma_{\alpha\beta}[z]\,d\alpha\,d\beta,"
        r"\quad\gamma = \pm 1,\ \mu < 0 \text{ off } \alpha = \beta",
        "hysteresis/relay_grid.py",
        "hysteresis/test_preisach.py::test_turning_points_are_the_relays_at_extremes_on_their_grid",
        "br.response(br.hysteresis.relays_of(operator, 4e-3, 40), [2e-3, 1e-3, 2e-3]).round(4)",
        "[ 0.0337 -0.002   0.0337]",
    ),
    Equation(
        13,
        "Its relays that are up",
        r"f_h(z) = \sum_k\iint_{S^+}\mu(\alpha,\beta)\,d\alpha\,d\beta",
        "corrected",
        r"f_h = 2\sum_k\iint_{Q_k}\mu\,d\alpha\,d\beta - \iint_{\alpha\geq\beta}\mu\,d\alpha\,d\beta",
        "paper/sums.py",
        f"{PREISACH}::test_13_sums_trapezoids_and_not_the_whole_of_S_plus",
        "round(sums.summed(operator, [-4e-3, 2e-3, 1e-3, 1.5e-3, 1.2e-3]), 4)",
        "0.0091",
    ),
    Equation(
        14,
        "The same, rising",
        r"f_h = \sum_{k=1}^{N}\left[F(\alpha_k,\beta_{k-1}) - F(\alpha_k,\beta_k)\right] + F(z,\beta_N)",
        "completed",
        r"f_h = 2\left(\sum_{k=1}^{N}\left[E(\alpha_k,\beta_{k-1}) - E(\alpha_k,\beta_k)\right] + E(z,\beta_N)\right)"
        r" - E(\alpha_0,\beta_0)",
        "paper/sums.py",
        f"{PREISACH}::test_14_and_15_as_printed_are_right_for_relays_of_0_and_1_but_for_one_constant",
        "round(sums.summed(operator, [-4e-3, 2e-3, 1e-3, 1.5e-3]), 4)",
        "0.0236",
    ),
    Equation(
        15,
        "The same, falling",
        r"f_h = \sum_{k=1}^{N-1}\left[F(\alpha_k,\beta_{k-1}) - F(\alpha_k,\beta_k)\right] + F(\alpha_N,\beta_{N-1})"
        r" - F(\alpha_N,z)",
        "completed",
        r"f_h = 2\left(\sum_{k=1}^{N-1}\left[E(\alpha_k,\beta_{k-1}) - E(\alpha_k,\beta_k)\right]"
        r" + E(\alpha_N,\beta_{N-1}) - E(\alpha_N,z)\right) - E(\alpha_0,\beta_0)",
        "paper/sums.py",
        f"{PREISACH}::test_14_and_15_with_factor_2_and_offset_are_the_turning_points",
        "round(sums.summed(operator, [-4e-3, 2e-3, 1e-3]), 4)",
        "0.0018",
    ),
    Equation(
        16,
        "Reformed Dahl, falling",
        r"f_{\dot x<0} = \frac{f_r(f_p + f_r) - s f_p(x_r - x)}{f_p + f_r + s(x_r - x)}",
        "as printed",
        "",
        "hysteresis/everett.py",
        f"{PREISACH}::test_16_and_17_every_symmetric_loop_is_that_of_the_exact_kernel",
        "br.response(operator, [1e-3, 0, -1e-3], history=[1e-3]).round(4)",
        "[ 0.0246 -0.0098 -0.0246]",
    ),
    Equation(
        17,
        "Reformed Dahl, rising",
        r"f_{\dot x>0} = \frac{-f_r(f_p + f_r) + s f_p(x_r + x)}{f_p + f_r + s(x_r + x)}",
        "completed",
        r"f = f_\beta + \frac{P s d}{P + s d},\quad P = f_p - f_\beta,\ d = x - \beta",
        "friction/reformed_dahl.py",
        f"{ERRATA_TESTS}::test_16_and_17_are_the_branch_from_a_general_reversal",
        "br.response(branch, [0, 1e-3, 0, 1e-3], dt=1).round(4)",
        "[0.     0.018  0.0093 0.0131]",
    ),
    Equation(
        18,
        "What is driven",
        r"J\ddot\theta = u - F_p",
        "as printed",
        "",
        "plants/inertia.py",
        "physics/test_lugre.py::test_driven_mass_converges_to_the_differential_equation_with_order_two",
        "bristle paper --figure 2",
    ),
    Equation(
        19,
        "Sliding surface",
        r"S = \dot e + \lambda e,\quad e = \theta_d - \theta",
        "corrected",
        r"\varsigma = \dot e + \lambda e",
        "controllers/sliding_mode.py",
        f"{LAW}::test_the_surface_is_reached_in_the_time_that_the_reaching_condition_gives",
        "bristle models sliding_mode",
    ),
    Equation(
        20,
        "Lyapunov function",
        r"V = \tfrac12 s^2",
        "completed",
        r"V = \tfrac12\varsigma^2,\quad\dot V \leq -K_1\varsigma^2"
        r" - (K_2 - \sup\lvert F_p - \hat F\rvert/J)\,\lvert\varsigma\rvert",
        "paper/surface.py",
        f"{SURFACE}::test_what_is_left_of_friction_holds_the_state_off_the_surface_by_no_more_than_the_bound",
        "round(surface.ultimate_bound(K_1=340, K_2=60, residual=80), 4)",
        "0.0588",
    ),
    Equation(
        21,
        "How the surface is approached",
        r"\dot s = -K_1 s - K_2\operatorname{sgn} s",
        "completed",
        r"\dot\varsigma = -K_1\varsigma - K_2\operatorname{sgn}\varsigma + (F_p - \hat F)/J",
        "paper/surface.py",
        f"{SURFACE}::test_the_surface_is_reached_no_later_than_the_reaching_condition_says",
        "round(surface.reaching_time(0.1, K_1=340, K_2=100, residual=80), 4)",
        "0.0029",
    ),
    Equation(
        22,
        "Its derivative",
        r"\dot s = \ddot\theta_d - \frac1J(u + F_p) + \lambda\dot e",
        "corrected",
        r"\dot\varsigma = \ddot\theta_d - \frac1J(u - F_p) + \lambda\dot e",
        "controllers/sliding_mode.py",
        f"{ERRATA_TESTS}::test_22_friction_holds_the_table_back",
        "bristle paper --figure 11",
    ),
    Equation(
        23,
        "Control law",
        r"u = J\left[\ddot\theta_d + \lambda\dot e + K_1 s + K_2\operatorname{sgn} s\right] + F_p",
        "completed",
        r"u = J\left[\ddot\theta_d + \lambda\dot e + K_1\varsigma + K_2\operatorname{sat}(\varsigma/\phi)\right]"
        r" + \hat F",
        "controllers/sliding_mode.py",
        f"{ERRATA_TESTS}::test_23_the_surface_is_reached_only_with_K_2_above_what_is_not_compensated",
        "bristle paper --figure 12",
    ),
)
