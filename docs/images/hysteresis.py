"""Draw the pictures of hysteresis operators: ``python docs/images/hysteresis.py``."""

from __future__ import annotations

from pathlib import Path

from bristle import figures, hysteresis

HERE = Path(__file__).parent
S, F_P, X_R = "100 N*m/rad", "150 mN*m", 7.5e-3


def main() -> None:
    """Write the pictures beside this file."""
    exact = hysteresis.preisach(kernel="reformed_dahl_exact", s=S, f_p=F_P)
    built = hysteresis.transition_branches(s=100.0, f_p=0.15, x_r=X_R, kind="rotational").operator()
    pictures = {
        "preisach-plane": figures.preisach_plane(exact, [5.4e-3, -3.6e-3, 3.0e-3, -0.6e-3, 1.8e-3]),
        "everett-surface": figures.everett_surface(exact, X_R),
        "transition-curves": figures.transition_curves({"reformed_dahl_exact": exact, "100 transition branches": built}, X_R),
    }
    for name, figure in pictures.items():
        figure.savefig(HERE / f"{name}.svg", metadata={"Date": None}, facecolor="white")


if __name__ == "__main__":
    main()
