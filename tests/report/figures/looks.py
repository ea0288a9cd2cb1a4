"""What a figure shows, as plain data: its panels to the inch, and each line, area, mark and text in them with its look.

``python -m tests.report.figures.looks`` freezes the figures of the gallery as they are, after a change that is meant.
"""

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.ticker import AutoLocator
from tests.report.figures.gallery import gallery

FROZEN = Path(__file__).with_name("looks.json")
SHARE = 1e-4  # by which numbers may differ: letters are not as wide everywhere to the last digit
Shown = dict[str, Any]


def frozen() -> Shown:
    """Return the figures as they were frozen."""
    return json.loads(FROZEN.read_text(encoding="utf-8"))


def look_of(figure: Figure) -> Shown:
    """Return the size of a figure [inch], its legends, and what each panel shows."""
    size = [float(side) for side in figure.get_size_inches()]
    return {
        "size": size,
        "legends": [_legend(item) for item in figure.legends],
        "panels": [_panel(axes) for axes in figure.axes],
    }


def differences(was: Any, now: Any, path: str = "") -> Iterator[str]:
    """Yield where two looks differ, numbers by more than a share of the largest beside them."""
    if isinstance(was, dict) and isinstance(now, dict) and was.keys() == now.keys():
        for key in was:
            yield from differences(was[key], now[key], f"{path}/{key}")
    elif isinstance(was, list) and isinstance(now, list) and len(was) == len(now):
        if was and all(isinstance(item, float) for item in was + now):
            top = max(map(abs, was))
            if not all(
                math.isclose(a, b, rel_tol=SHARE, abs_tol=SHARE * top)
                for a, b in zip(was, now, strict=True)
            ):
                yield f"{path}: {was} became {now}"
        else:
            for place, (a, b) in enumerate(zip(was, now, strict=True)):
                yield from differences(a, b, f"{path}/{place}")
    elif was != now:
        yield f"{path}: {was} became {now}"


def _panel(axes: Axes) -> Shown:
    box = axes.get_position()
    sides = {word: _axis(axes, word) for word in "xy"}
    titles = [
        [place, axes.get_title(loc=place)]
        for place in ("left", "center", "right")
        if axes.get_title(loc=place)
    ]
    artists = [
        *map(_line, axes.lines),
        *map(_collection, axes.collections),
        *map(_patch, axes.patches),
        *map(_text, axes.texts),
    ]
    legend = axes.get_legend()
    return {
        "box": [float(edge) for edge in (box.x0, box.y0, box.width, box.height)],
        "shown": [
            axes.get_visible(),
            axes.axison,
            axes.get_aspect() if isinstance(axes.get_aspect(), str) else "equal",
        ],
        "titles": titles,
        **sides,
        "legend": None if legend is None else _legend(legend),
        "artists": artists,
    }


def _axis(axes: Axes, word: str) -> Shown:
    axis = getattr(axes, f"{word}axis")
    chosen = not isinstance(axis.get_major_locator(), AutoLocator)
    ticks = axis.get_majorticklocs() if chosen else ()
    labels = axis.get_major_formatter().format_ticks(ticks) if chosen else []
    how = axis.get_tick_params()
    return {
        "label": [
            axis.label.get_text(),
            axis.label.get_visible(),
            axis.get_scale(),
            how.get("labelleft" if word == "y" else "labelbottom"),
        ],
        "limits": [float(end) for end in getattr(axes, f"get_{word}lim")()],
        "ticks": [float(tick) for tick in ticks],
        "names": labels,
        "length": [float(how.get("length", -1.0)), float(axis.labelpad)],
    }


def _span(values: Any) -> list[float]:
    """Return first, last, smallest and largest of values."""
    finite = np.asarray(values, dtype=float).ravel()
    finite = finite[np.isfinite(finite)]
    return (
        [float(v) for v in (finite[0], finite[-1], finite.min(), finite.max())]
        if finite.size
        else []
    )


def _line(line: Any) -> list[Any]:
    ends = [_span(line.get_xdata()), _span(line.get_ydata())]
    look = [
        to_hex(line.get_color()),
        str(line._unscaled_dash_pattern),
        str(line.get_marker()),
        line.get_fillstyle(),
    ]
    sizes = [
        float(v)
        for v in (
            line.get_linewidth(),
            line.get_markersize(),
            line.get_markeredgewidth(),
            line.get_zorder(),
        )
    ]
    return [
        "line",
        line.get_label(),
        *look,
        str(line.get_markerfacecolor()),
        sizes,
        len(line.get_xdata()),
        *ends,
    ]


def _collection(item: Any) -> list[Any]:
    colors = [
        [to_hex(color, keep_alpha=True) for color in side[:2]]
        for side in (item.get_facecolor(), item.get_edgecolor())
    ]
    points = (
        item.get_offsets()
        if len(item.get_offsets()) > 1 or not item.get_paths()
        else item.get_paths()[0].vertices
    )
    sizes = [float(v) for v in np.atleast_1d(item.get_linewidth())[:1]] + [float(item.get_zorder())]
    area = [float(v) for v in getattr(item, "get_sizes", list)()[:1]]
    return [
        type(item).__name__,
        item.get_label(),
        *colors,
        sizes,
        area,
        len(item.get_paths()),
        *map(_span, np.transpose(points)),
    ]


def _patch(patch: Any) -> list[Any]:
    colors = [
        to_hex(color, keep_alpha=True) for color in (patch.get_facecolor(), patch.get_edgecolor())
    ]
    path = patch.get_patch_transform().transform_path(patch.get_path()).vertices
    sizes = [float(patch.get_linewidth()), float(patch.get_zorder())]
    return [
        type(patch).__name__,
        patch.get_label(),
        *colors,
        patch.get_hatch(),
        sizes,
        *map(_span, np.transpose(path)),
    ]


def _text(text: Any) -> list[Any]:
    place = [float(v) for v in text.get_position()]
    about = [
        text.get_text(),
        text.get_ha(),
        text.get_va(),
        to_hex(text.get_color()),
        str(text.get_weight()),
        text.get_style(),
    ]
    aside = [float(v) for v in getattr(text, "xyann", place)]
    box = text.get_bbox_patch()
    return [
        "text",
        *about,
        [float(text.get_fontsize())],
        place,
        aside,
        None if box is None else _patch(box)[2:6],
    ]


def _legend(legend: Any) -> list[Any]:
    names = [text.get_text() for text in legend.get_texts()]
    corner = legend.get_bbox_to_anchor()
    sizes = [
        float(v)
        for v in (
            legend.handlelength,
            legend.handletextpad,
            legend.columnspacing,
            legend.borderpad,
            legend.borderaxespad,
        )
    ]
    return [
        names,
        legend._ncols,
        legend._loc,
        legend.get_frame_on(),
        sizes,
        [float(corner.x0), float(corner.y1)],
    ]


def main() -> None:
    """Freeze all figures of the gallery."""
    lines = []
    for name, draw in gallery().items():
        shown = look_of(draw())
        panels = ",\n  ".join(_written(panel) for panel in shown.pop("panels"))
        lines.append(
            f'{json.dumps(name)}: {{"size": {_short(shown["size"])}, "legends": {_short(shown["legends"])}, "panels": [\n  {panels}]}}'
        )
    FROZEN.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


def _written(panel: Shown) -> str:
    artists = ",\n    ".join(map(_short, panel["artists"]))
    head = _short({key: value for key, value in panel.items() if key != "artists"})
    return f'{head[:-1]}, "artists": [\n    {artists}]}}'


def _short(value: Any) -> str:
    def rounded(item: Any) -> Any:
        if isinstance(item, float):
            return float(f"{item:.7g}")
        if isinstance(item, dict):
            return {key: rounded(part) for key, part in item.items()}
        return [rounded(part) for part in item] if isinstance(item, (list, tuple)) else item

    return json.dumps(rounded(value), ensure_ascii=False)


if __name__ == "__main__":
    main()
