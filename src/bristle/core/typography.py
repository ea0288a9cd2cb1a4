"""Format numbers and units for display: a suitable multiple of the unit, and digits according to the uncertainty."""

import math
import re
from typing import Any, NamedTuple

# Multiples in use: symbol, power of ten, and smallest magnitude [SI] for its use.
_METRE = (("{}", 0, 1.0), ("m{}", -3, 1e-3), ("µ{}", -6, 1e-6), ("n{}", -9, 1e-9))
_NEWTON = (("k{}", 3, 1e4), *_METRE[:3])
_MULTIPLES = (
    dict.fromkeys(("m", "rad", "s"), _METRE)
    | dict.fromkeys(("N", "V", "A"), _NEWTON)
    | {"Hz": _NEWTON[:2]}
)
_WHOLE_UNITS = {
    "kg*m^2": (("kg*m^2", 0, 0.1), ("kg*cm^2", -4, 1e-5), ("g*cm^2", -7, 0.0)),
    "kg": (("kg", 0, 0.1), ("g", -3, 0.0)),
}
LARGEST_WRITTEN_OUT = 1e12  # larger numbers are written with a power of ten


class Scale(NamedTuple):
    """A multiple of a unit: `factor` times a number in SI units is a number in `unit`, in display form."""

    factor: float
    unit: str

    def label(self, word: str) -> str:
        """Return a word with its unit, as a label of an axis or a column."""
        return f"{word} [{self.unit}]" if self.unit else word


def escaped(text: str) -> str:
    """Return text that can be encoded: undecodable bytes of a file name become escape sequences."""
    # Surrogates of `os.fsdecode`
    return re.sub("[\udc80-\udcff]", lambda byte: f"\\x{ord(byte[0]) - 0xDC00:02x}", text)


def printable(text: str) -> str:
    """Return printable text; the name of a file or column may contain any characters."""
    return "".join(letter if letter.isprintable() else " " for letter in escaped(text))


def typeset(unit: str) -> str:
    """Return the display form of a unit; empty for a plain number."""
    if unit == "1":
        return ""
    unit = re.sub(r"\bu(?=(m|rad|s|N)\b)", "µ", unit).replace("*", "·")
    return re.sub(r"\^2(?!\.)", "²", unit)


def scale_of(unit: str, magnitude: float) -> Scale:
    """Return the most readable multiple of an SI unit for a number of this magnitude.

    Examples
    --------
    >>> scale_of("m", 7e-6), scale_of("N*m", 0.04), scale_of("kg*m^2", 4e-4)
    (Scale(factor=1000000.0, unit='µm'), Scale(factor=1000.0, unit='mN·m'), Scale(factor=10000.0, unit='kg·cm²'))
    """
    magnitude = abs(magnitude)
    if magnitude == 0.0 or not math.isfinite(magnitude):
        return Scale(1.0, typeset(unit))
    # A power would also apply to a prefix.
    symbol = re.match(r"(?:[A-Za-z]+(?![A-Za-z^]))?", unit)[0]  # type: ignore[index]
    steps = _WHOLE_UNITS.get(unit) or _MULTIPLES.get(symbol, _METRE[:1])
    pattern, power, _ = next(
        (step for step in steps if magnitude >= step[2] * (1 - 1e-12)), steps[-1]
    )
    return Scale(float(f"1e{-power}"), typeset(pattern.format(unit)))


def number(value: float, resolution: float | None = None, digits: int = 4) -> str:
    """Format a number to two digits of `resolution`, for example its standard error; without it, to `digits` significant digits."""
    if not math.isfinite(value):
        return "–" if math.isnan(value) else f"{value}".replace("inf", "∞").replace("-", "−")
    if resolution is not None and 0.0 < resolution < math.inf:
        decimals = 1 - math.floor(math.log10(resolution))
    elif value == 0.0:
        decimals = 0
    else:
        decimals = digits - 1 - math.floor(math.log10(abs(value)))
    if resolution is not None and decimals < 0:
        value = round(value, decimals)
    if decimals > 9 or abs(value) >= LARGEST_WRITTEN_OUT:
        return f"{value:.{digits - 1}e}".replace("-", "−")
    text = f"{value:.{max(decimals, 0)}f}".replace("-", "−")
    return text if any(digit in text for digit in "123456789") else text.removeprefix("−")


def typed(value: Any) -> str:
    """Return a value as typed input: a number in six digits, a list in brackets, a name unchanged."""
    if isinstance(value, str):
        return value
    if hasattr(value, "__len__"):
        return "[" + ", ".join(f"{number:.6g}" for number in value) + "]"
    return f"{value:.6g}"


def with_unit(value: float, unit: str, digits: int = 3) -> str:
    """Format a number in SI units with a suitable multiple of its unit, to at most `digits` digits."""
    scale = scale_of(unit, value)
    text = number(value * scale.factor, digits=digits)
    if "." in text and "e" not in text:
        text = text.rstrip("0").rstrip(".")
    return f"{text} {scale.unit}".rstrip()
