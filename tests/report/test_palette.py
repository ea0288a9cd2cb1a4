"""The colours of all pages: letters stay readable on their grounds in light and dark, and paper is light."""

import re

import pytest

from bristle.palette import DARK, LIGHT, colour_variables

LETTERS = ("ink", "soft", "accent", "with", "usable", "care", "alert")


def luminance(colour):
    channels = [int(colour[place : place + 2], 16) / 255.0 for place in (1, 3, 5)]
    linear = [channel / 12.92 if channel <= 0.04045 else ((channel + 0.055) / 1.055) ** 2.4 for channel in channels]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(first, second):
    """Contrast of two colours by WCAG 2.1."""
    dark, light = sorted((luminance(first), luminance(second)))
    return (light + 0.05) / (dark + 0.05)


@pytest.mark.parametrize("colours", [LIGHT, DARK], ids=["light", "dark"])
@pytest.mark.parametrize("name", LETTERS)
def test_letters_are_readable_on_page_and_card(colours, name):
    assert min(contrast(colours[name], colours[ground]) for ground in ("ground", "card")) >= 4.5


def test_dark_has_every_colour_and_paper_is_light():
    assert list(LIGHT) == list(DARK)
    light, dark = colour_variables(":root").split("@media")
    assert dict(re.findall(r"--([a-z]+):(#[0-9a-f]{6});", light)) == LIGHT
    assert dict(re.findall(r"--([a-z]+):(#[0-9a-f]{6});", dark)) == DARK
    assert dark.startswith(" screen and (prefers-color-scheme:dark)")
