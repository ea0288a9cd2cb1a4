"""Units that differ from SI by a power of ten, which are converted exactly and without a library."""

from __future__ import annotations

_PLAIN = {
    "s": {"s": 0, "ms": -3, "us": -6},
    "1/s": {"1/s": 0},
    "Hz": {"Hz": 0, "kHz": 3},
    "kg": {"kg": 0, "g": -3},
    "kg*m^2": {"kg*m^2": 0, "kg*cm^2": -4, "g*cm^2": -7},
    "K": {"K": 0},
    "V": {"V": 0, "mV": -3},
    "A": {"A": 0, "mA": -3},
    "count": {"count": 0},
    "count/s": {"count/s": 0},
    "rated": {"rated": 0, "%": -2, "‰": -3},
}
_MOVEMENTS = {"m": {"m": 0, "cm": -2, "mm": -3, "um": -6, "nm": -9}, "rad": {"rad": 0, "mrad": -3, "urad": -6}}
_FORCES = {"N": 0, "mN": -3, "uN": -6, "kN": 3}
_ARMS = {"m": 0, "cm": -2, "mm": -3}


def _decimal_units() -> dict[str, tuple[str, int]]:
    """Return units that differ from SI by a power of ten: their SI unit and that power."""
    powers = {name: (si, power) for si, names in _PLAIN.items() for name, power in names.items()}
    for si, names in _MOVEMENTS.items():
        for name, power in names.items():
            powers |= {f"{name}{per}": (f"{si}{per}", power) for per in ("", "/s", "/s^2", "/s^3")}
            for gain in ("V", "V*s", "A", "A*s"):  # of a controller, in the units of its drive
                powers[f"{gain}/{name}"] = (f"{gain}/{si}", -power)
    efforts = {name: ("N", power) for name, power in _FORCES.items()}
    for force, power in _FORCES.items():
        efforts |= {f"{force}*{arm}": ("N*m", power + more) for arm, more in _ARMS.items()}
        for length, less in _MOVEMENTS["m"].items():
            powers[f"{force}/{length}"] = ("N/m", power - less)
            powers[f"{force}*s/{length}"] = ("N*s/m", power - less)
    for effort, (si, power) in efforts.items():
        powers |= {f"{effort}/{drive}": (f"{si}/{drive}", power) for drive in ("V", "A", "count", "rated")}
        powers |= {f"{effort}{per}": (f"{si}{per}", power) for per in ("/rad", "*s/rad") if si == "N*m"}
    return powers | efforts


DECIMAL_UNITS = _decimal_units()
"""Unit -> its SI unit, and the power of ten between them."""
