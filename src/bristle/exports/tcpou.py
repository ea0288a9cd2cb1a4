"""Parts of a PLC program as files of TwinCAT 3: one for each POU and each data type, to be added to a project."""

from __future__ import annotations

import uuid
from collections.abc import Iterable
from xml.sax.saxutils import quoteattr

from bristle.exports.described import Source
from bristle.exports.identity import rights_lines
from bristle.exports.st_parts import Array, Pou, Record, declaration_text, part_text

__all__ = ["twincat_files"]

HEAD = """<?xml version="1.0" encoding="utf-8"?>
<TcPlcObject Version="1.1.0.1" ProductVersion="3.1.4024.12">
"""
POU = """  <POU Name={name} Id={id} SpecialFunc="None">
    <Declaration>{declaration}</Declaration>
    <Implementation>
      <ST>{body}</ST>
    </Implementation>
  </POU>
"""
DUT = """  <DUT Name={name} Id={id}>
    <Declaration>{declaration}</Declaration>
  </DUT>
"""
TAIL = "</TcPlcObject>\n"


def twincat_files(parts: Iterable[Array | Record | Pou], source: Source) -> dict[str, str]:
    """Return the text of a file for each part, by its name: ``.TcPOU`` of a POU, ``.TcDUT`` of a data type.

    A part has the same identifier in each export of its name: one that is exported again replaces it in a project.
    """
    rights = "\n".join([*rights_lines(source, ".st"), ""])
    return {f"{part.name}.{'TcPOU' if isinstance(part, Pou) else 'TcDUT'}": _text(part, rights) for part in parts}


def _text(part: Array | Record | Pou, rights: str) -> str:
    names = {"name": quoteattr(part.name), "id": quoteattr(f"{{{uuid.uuid5(uuid.NAMESPACE_URL, part.name)}}}")}
    if not isinstance(part, Pou):
        return HEAD + DUT.format(**names, declaration=_as_cdata(rights + part_text(part))) + TAIL
    body = _as_cdata("\n".join([*part.body, ""]))
    return HEAD + POU.format(**names, declaration=_as_cdata(rights + declaration_text(part)), body=body) + TAIL


def _as_cdata(text: str) -> str:
    """Return text that a reader of XML takes as it stands."""
    return f"<![CDATA[{text.replace(']]>', ']]]]><![CDATA[>')}]]>"
