"""Hooks that make the site of the documentation from these pages: ``mkdocs build --strict``.

Some pages are outside of this folder and link to code. The site includes these pages, replaces links to code by names,
writes equations as MathML, and adds the lab.
"""

from __future__ import annotations

import html
import inspect
import os
import posixpath
import re
import shutil
from pathlib import Path
from typing import Any

from latex2mathml.converter import convert
from mkdocs.plugins import event_priority
from mkdocs.structure.files import File

ROOT = Path(__file__).parent.parent
TAKEN = (
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "examples/README.md",
    "examples/*/README.md",
    "examples/*.py",
    "examples/*.ipynb",
    "examples/*/*.png",
    "examples/*/*.svg",
    "examples/*/*.toml",
    "examples/source_paper/*.py",
    "examples/*/*.ipynb",
)
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^)\s]+)\)")
EQUATION = re.compile(r'<(span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</\1>', re.DOTALL)
SEARCH = '<div class="md-search" data-md-component="search" role="dialog" aria-label="Search">'
LAB = """# The lab

Every friction model on one page that computes in your browser. [Open it in the whole window](lab.html), or
[read how to use it](how-to/lab.md).

<iframe src="../lab.html" title="Friction models, moved by the mouse" style="width: 100%; height: 80vh; border: 0"></iframe>
"""


def on_config(config: Any) -> Any:
    """Offer the list of versions only where `mike` deploys it: without its file every page would ask for it in vain."""
    if "MIKE_DOCS_VERSION" in os.environ:
        config["extra"]["version"] = {"provider": "mike"}
    return config


@event_priority(100)
def on_files(files: Any, config: Any) -> Any:
    """Include pages from outside of this folder, and write the pages that only the site has."""
    taken = ROOT / "build" / "taken"  # copies: a notebook that is run writes beside itself
    shutil.rmtree(taken, ignore_errors=True)
    for pattern in TAKEN:
        for file in sorted(ROOT.glob(pattern)):
            name = file.relative_to(ROOT).as_posix()
            (taken / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(file, taken / name)
            files.append(File(name, str(taken), config.site_dir, config.use_directory_urls))
    for name, content in {
        "lab.md": LAB,
        "reference/in-full.md": in_full(),
        "lab.html": lab(),
    }.items():
        files.append(File.generated(config, name, content=content))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Any) -> str:
    """Redirect links and images out of this folder to what is included, and remove links to code."""
    place = posixpath.dirname(page.file.src_uri)
    below = posixpath.join("docs", place) if (ROOT / "docs" / page.file.src_uri).exists() else place
    known = {file.src_uri for file in files}

    def led(match: re.Match[str]) -> str:
        image, text, target = match.groups()
        address, _, anchor = target.partition("#")
        if not address or "://" in address or address.startswith("mailto:"):
            return match[0]
        named = posixpath.normpath(posixpath.join(below, address)).removeprefix("docs/")
        for candidate in (named, posixpath.join(named, "README.md")):
            if candidate in known:
                return f"{image}[{text}]({posixpath.relpath(candidate, place or '.')}{'#' + anchor if anchor else ''})"
        is_code = not image and (ROOT / named).exists()
        return text if is_code else match[0]

    if not page.file.src_uri.endswith(".md"):
        return markdown
    # Words for tests, not for readers.
    markdown = re.sub(r"^```(\w+) [\w -]+$", r"```\1", markdown, flags=re.MULTILINE)
    parts = re.split(r"(^```.*?^```$)", markdown, flags=re.DOTALL | re.MULTILINE)
    return "".join(part if part.startswith("```") else LINK.sub(led, part) for part in parts)


def on_page_content(content: str, page: Any, config: Any, files: Any) -> str:
    """Write equations as MathML, and link each friction model to the lab."""
    content = EQUATION.sub(lambda match: mathml(match[3], match[2] == "["), content)
    return beside_lab(content) if page.file.src_uri == "reference/models.md" else content


def on_post_page(output: str, page: Any, config: Any) -> str:
    """Name the search for readers of the screen, which the theme leaves out."""
    return output.replace(
        '<div class="md-search" data-md-component="search" role="dialog">', SEARCH
    )


def mathml(latex: str, block: bool) -> str:
    """Return an equation as browsers draw it."""
    drawn = convert(html.unescape(latex).strip(), display="block" if block else "inline")
    return f'<div class="equation" tabindex="0">{drawn}</div>' if block else drawn


def beside_lab(content: str) -> str:
    """Add to the heading of each friction model a link to the lab that shows it."""
    from bristle.models.friction import MODELS

    for name in MODELS:
        link = f'<p><a href="../../lab.html#model={name}">Try this model in the lab</a></p>'
        content, count = re.subn(rf'(<h3 id="{name}">.*?</h3>)', rf"\1{link}", content, count=1)
        if count != 1:
            raise SystemExit(f"reference/models.md: no heading of {name}")
    return content


def in_full() -> str:
    """Return the page of all public functions, from their docstrings."""
    import bristle

    words = "Every public function with its parameters, units, shapes and errors. In short: [Python](python.md)."
    parts = [f"# Python, in full\n\n{words}\n"]
    for name in sorted(bristle.__all__):
        value = getattr(bristle, name)
        if inspect.isfunction(value) or inspect.isclass(value):
            parts.append(f"::: {value.__module__}.{value.__qualname__}\n")
    return "\n".join(parts)


def lab() -> str:
    """Return the page of the lab."""
    from bristle.apps.lab import lab_page

    return lab_page()
