"""Figure 4: the Preisach plane at each turn, and the sums of (14) and (15) beside the operator."""

from __future__ import annotations

from bristle.core.errors import InputError
from bristle.core.typography import number
from bristle.engine import response
from bristle.paper.reproduced import Reproduced, Verdict
from bristle.paper.setting import Setting
from bristle.paper.sums import summed
from bristle.report.table import Table

__all__ = ["figure_4"]

LETTERS = "abcdefgh"


def figure_4(setting: Setting) -> Reproduced:
    """Return figure 4: how the staircase comes about, and the force by (14) and (15)."""
    from bristle.figures import preisach_stages

    operator = setting.operator
    path, arm = setting["path", "turns"].tolist(), setting.arm
    _must_nest(setting, path)
    rows, forces = [], []
    for count in range(2, len(path) + 1):
        by_turns = arm * float(response(operator, path[:count])[-1])
        right, printed = (arm * summed(operator, path[:count], as_printed=one) for one in (False, True))
        forces.append((by_turns, right, printed))
        which = "(14)" if path[count - 1] > path[count - 2] else "(15)"
        cells = (number(1e3 * one, resolution=1.0) for one in (by_turns, right, printed))
        rows.append((f"({LETTERS[count - 2]})", which, *cells))
    apart = max(abs(a - b) for a, b, _ in forces)
    wrong = max(abs(a - c) for a, _, c in forces)
    return Reproduced(
        number=4,
        verdict=_verdict(apart, wrong),
        found=[
            "With relays of ±1 the sums need a factor 2 and the offset of negative saturation; so corrected they are "
            f"the operator, to {'rounding' if apart < 1e-15 else f'{apart:.0e} N·m'}.".replace("e-", "e−"),
            f"As printed they miss by up to {number(1e3 * wrong, digits=3)} mN·m.",
        ],
        draw=lambda: preisach_stages(operator, path[0], path[1:], arm, "rotational"),
        origin=setting.origin,
        numbers={"torque": [one[0] for one in forces], "by_corrected_sums": [one[1] for one in forces],
                 "by_printed_sums": [one[2] for one in forces]},
        tables=(
            Table("Torque in mN·m where the input is at each stage",
                  ("Stage", "Equation", "By turning points", "Sum, corrected", "Sum, as printed"), rows),
        ),
    )  # fmt: skip


def _verdict(apart: float, wrong: float) -> Verdict:
    if apart > 1e-9 * wrong:
        return "does not hold"
    return "holds in part" if wrong > 0.0 else "holds"


def _must_nest(setting: Setting, path: list[float]) -> None:
    """Refuse a history whose turns are not each inside the ones before: the sums stand for those that remain."""
    nested = all(
        min(a, b) < c < max(a, b) for a, b, c in zip(path, path[1:], path[2:], strict=False)
    )  # fmt: skip
    if len(path) < 3 or path[0] >= 0.0 or not nested or abs(path[1]) >= -path[0]:
        raise InputError(
            "must begin far down and turn inside the two before, at least twice", path=f"{setting.source}: path.turns",
            value=setting["path", "turns"].tolist(),
        )  # fmt: skip
