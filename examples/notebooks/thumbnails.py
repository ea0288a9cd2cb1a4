"""Run the notebooks of the gallery and save the first figure of each: ``python examples/notebooks/thumbnails.py``."""

from __future__ import annotations

import ast
import contextlib
import io
import json
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

HERE = Path(__file__).parent
NOTEBOOKS = sorted(HERE.glob("*.ipynb"))
WIDTH = 320  # [pixels] of a thumbnail


def values_of(notebook: Path) -> list[Any]:
    """Run the cells of a notebook, and return what each of them would show."""
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    names: dict[str, Any] = {}
    shown = []
    for code in ("".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"):
        body = ast.parse(code).body
        last = body.pop() if isinstance(body[-1], ast.Expr) else None
        exec(compile(ast.Module(body, []), str(notebook), "exec"), names)
        if isinstance(last, ast.Expr):
            shown.append(eval(compile(ast.Expression(last.value), str(notebook), "eval"), names))
    return shown


def main() -> None:
    """Write the thumbnails beside the notebooks."""
    for notebook in NOTEBOOKS:
        with contextlib.redirect_stdout(io.StringIO()):
            figure = next(value for value in values_of(notebook) if isinstance(value, Figure))
        file = notebook.with_suffix(".png")
        figure.savefig(
            file, dpi=WIDTH / figure.get_figwidth(), facecolor="white", metadata={"Software": None}
        )
        print(file.name, file.stat().st_size)


if __name__ == "__main__":
    main()
