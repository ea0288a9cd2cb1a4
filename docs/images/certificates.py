"""Draw the pictures of friction with memory, and print the table: ``python docs/images/certificates.py``.

The setting is a ball screw with a lead of 5 mm, everything counted at the table.
"""

from __future__ import annotations

import math
import pathlib

import numpy as np
from matplotlib.figure import Figure

import bristle as br
from bristle import figures
from bristle.core.contracts import Model
from bristle.simulation.certificates import Certificate, Path, traced

ARM = 5e-3 / (2.0 * math.pi)  # [m] of travel for each radian of the screw
F_C, F_S = 0.100 / ARM, 0.130 / ARM
STIFFNESS, F_P = 100.0 / ARM**2, 1.2 * F_S
SLIDING = {"F_C": F_C, "F_S": F_S, "v_S": 0.3 * ARM}
DAMPING = {"sigma_1": 0.1 / ARM**2, "sigma_2": 0.03 / ARM**2}
SHARES = np.array([0.10, 0.18, 0.24, 0.24, 0.24])
REACHES = F_S / STIFFNESS * np.array([0.4, 0.9, 1.6, 2.8, 5.0])  # where each element of GMS slips
RIPPLE = (0.040 / ARM, 0.080 / ARM)
LOOP = (3e-6, 1.5e-6)


def composite(transition: str, **values: float) -> Model:
    """Return the Preisach-LuGre model with one of its transitions."""
    return br.friction.preisach_lugre(
        s=STIFFNESS, f_p=F_P, transition=transition, **SLIDING, **DAMPING, **values
    )


MODELS = {
    "LuGre": br.friction.lugre(sigma_0=STIFFNESS, **SLIDING, **DAMPING),
    "source paper": composite("paper"),
    "Leuven, n = 2": composite("leuven", n=2.0),
    "Leuven, n = 8": composite("leuven", n=8.0),
    "GMS": br.friction.gms(**SLIDING, C=1e5, k_i=SHARES * F_S / REACHES, nu_i=SHARES),
    "gate, ρ = 0.9": composite("elastoplastic"),
}
OTHERS = {
    "Dahl": br.friction.dahl(sigma_0=STIFFNESS, F_C=F_S),
    "Bouc-Wen, n = 2": br.friction.bouc_wen(s=STIFFNESS, F_C=F_S),
    "elastoplastic": br.friction.elastoplastic(
        sigma_0=STIFFNESS, z_ba=0.9 * F_C / STIFFNESS, **SLIDING, **DAMPING
    ),
    "Maxwell slip": br.friction.maxwell_slip(F_C=F_S, k_i=SHARES * F_S / REACHES, nu_i=SHARES),
    "Coulomb": br.friction.coulomb(F_C=F_C),
}


def certificates() -> dict[str, dict[str, Certificate]]:
    """Return the certificates of every model."""
    return {
        name: br.check(one, force_ripple=RIPPLE, loop=LOOP)
        for name, one in (MODELS | OTHERS).items()
    }


def table(found: dict[str, dict[str, Certificate]]) -> str:
    """Return the certificates as rows of a table in Markdown; what fails stands in bold."""
    rows = []
    for name, answers in found.items():
        cells = [
            _cell(answers["well_posed"], 1e6, "µm" if answers["well_posed"].unit == "m" else "ok"),
            _cell(answers["passive"], 1.0, "needs"),
            _cell(answers["drift"], 1e6, "µm"),
            _cell(answers["closure"], 100.0, "%"),
            _cell(answers["dissipation"], 1.0, "ok"),
        ]
        rows.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(rows)


def _cell(one: Certificate, factor: float, unit: str) -> str:
    if not one.applies or one.value is None:
        return "–"
    if unit == "needs":
        text = f"{one.threshold * ARM**2 / 0.1:.2f} σ₁" if one.threshold else "passes"
        text = "no σ₂ is enough" if one.threshold == math.inf else text
    elif unit == "ok":
        text = "passes" if one.passed else "fails"
    else:
        value = one.value * factor
        text = "0" if abs(value) < 1e-8 else f"{value:.3g} {unit}".replace("-", "−")
    return text if one.passed else f"**{text}**"


def drift(found: dict[str, dict[str, Certificate]]) -> Figure:
    """Return the picture of drift."""
    levels = [RIPPLE[1], *(RIPPLE * 8)]
    traces = {name: traced(model, Path.to_force, levels) for name, model in MODELS.items()}
    return figures.drift(traces, {name: found[name]["drift"].value or 0.0 for name in MODELS})


def closure(found: dict[str, dict[str, Certificate]]) -> Figure:
    """Return the picture of closure."""
    traces = {
        name: traced(model, Path.to_position, [*LOOP, LOOP[0]]) for name, model in MODELS.items()
    }
    return figures.closure(traces, {name: found[name]["closure"].value or 0.0 for name in MODELS})


def loops() -> Figure:
    """Return the picture of a large loop with smaller ones inside."""
    turns = [5e-6, -5e-6, 1e-6, -2e-6, 1e-6, 3e-6, 0.5e-6, 3e-6, 5e-6, -5e-6, 5e-6]
    return figures.minor_loops(
        {name: traced(model, Path.to_position, turns) for name, model in MODELS.items()}
    )


def main() -> None:
    """Write every picture beside this file, and print the table."""
    found = certificates()
    pictures = {
        "certificates-drift": drift(found),
        "certificates-closure": closure(found),
        "certificates-loops": loops(),
    }
    for name, picture in pictures.items():
        picture.savefig(
            pathlib.Path(__file__).with_name(f"{name}.svg"),
            facecolor="white",
            metadata={"Date": None},
        )
    print(table(found))


if __name__ == "__main__":
    main()
