"""Draw the picture of a hysteresis operator: ``python docs/images/hysteresis.py``."""

from __future__ import annotations

from pathlib import Path

from bristle import figures, hysteresis

HERE = Path(__file__).parent


def main() -> None:
    """Write the picture beside this file."""
    exact = hysteresis.preisach(kernel="reformed_dahl_exact", s="100 N*m/rad", f_p="150 mN*m")
    figure = figures.preisach_plane(exact, [5.4e-3, -3.6e-3, 3.0e-3, -0.6e-3, 1.8e-3])
    figure.savefig(HERE / "preisach-plane.svg", metadata={"Date": None}, facecolor="white")


if __name__ == "__main__":
    main()
