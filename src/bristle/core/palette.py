"""The colours of report, lab, figures, terminal and notebook, as variables of a page in light, in dark and on paper.

A line has the same colour everywhere: `measured` ochre, `without` friction feedforward grey, `with` friction feedforward blue,
which is also the colour of a model. `usable`, `care` and `alert` are the colours of the three verdicts.
"""

LIGHT = {
    "ink": "#1b2430",
    "soft": "#545f6c",
    "rule": "#d5dae0",
    "shade": "#e9ecf0",
    "ground": "#ffffff",
    "card": "#f4f6f8",
    "accent": "#0b3c6f",
    "ghost": "#8d97a3",
    "measured": "#e0a83c",
    "without": "#7b8591",
    "with": "#0b3c6f",
    "third": "#00836a",
    "fourth": "#a3356f",
    "fifth": "#555e69",
    "usable": "#1a6b3c",
    "care": "#8a4b08",
    "alert": "#b3261e",
    "band": "#dbe6f2",
}
DARK = {
    "ink": "#e8ecf1",
    "soft": "#a9b3be",
    "rule": "#39424d",
    "shade": "#262f3a",
    "ground": "#12171d",
    "card": "#1a2129",
    "accent": "#7db8ff",
    "ghost": "#7b8794",
    "measured": "#b98527",
    "without": "#8f9aa6",
    "with": "#8cc2ff",
    "third": "#3ec9a7",
    "fourth": "#e583b8",
    "fifth": "#a3adb8",
    "usable": "#6fd08f",
    "care": "#f0b060",
    "alert": "#ff8a80",
    "band": "#1f3a57",
}


def colour_variables(root: str = ":root, :host") -> str:
    """Return the colours as variables of a style sheet: light, dark where the reader prefers it, and always light on paper."""
    light, dark = (
        "".join(f"--{name}:{colour};" for name, colour in colours.items())
        for colours in (LIGHT, DARK)
    )
    return f"{root}{{color-scheme:light dark;{light}}}@media screen and (prefers-color-scheme:dark){{{root}{{{dark}}}}}\n"


def notebook_style() -> str:
    """Return the style of a result in a notebook: the colours of its theme, those of the system elsewhere, light ones on paper."""
    colours = "".join(
        f"--{name}:light-dark({colour},{DARK[name]});" for name, colour in LIGHT.items()
    )
    themes = (
        ('data-jp-theme-light="true"', "vscode-light", "light"),
        ('data-jp-theme-light="false"', "vscode-dark", "dark"),
    )
    chosen = "".join(
        f":is([{lab}],.{code}) .bristle{{color-scheme:{scheme};}}" for lab, code, scheme in themes
    )
    own = "color-scheme:light dark;color:var(--ink);background:var(--ground);"
    return f".bristle{{{colours}{own}}}{chosen}@media print{{.bristle{{color-scheme:light !important;}}}}\n"


# A terminal has a theme of its own.
TERMINAL = {
    "gain": "bold",
    "usable": "bold green",
    "with_care": "bold yellow",
    "measure_again": "bold red",
}
