"""Parts of a PLC program as XML of PLCopen (TC6, version 2.01) and as files of TwinCAT 3."""

from __future__ import annotations

import uuid
from collections.abc import Iterable, Sequence
from xml.etree import ElementTree
from xml.sax.saxutils import quoteattr

from bristle.exports.described import Source, rights_lines, version
from bristle.exports.st_parts import INDENT, Array, Pou, Record, Variable, declaration_text, part_text

NAMESPACE = "http://www.plcopen.org/xml/tc6_0201"
XHTML = "http://www.w3.org/1999/xhtml"
POU_TYPES = {"FUNCTION": "function", "FUNCTION_BLOCK": "functionBlock", "PROGRAM": "program"}
SECTIONS = {"VAR_INPUT": "inputVars", "VAR_OUTPUT": "outputVars", "VAR_IN_OUT": "inOutVars", "VAR": "localVars"}
NEVER = "1970-01-01T00:00:00"  # the same model gives the same file
Element = ElementTree.Element


def project_text(name: str, head: str, types: Sequence[Array | Record], pous: Sequence[Pou]) -> str:
    """Return a project with data types, functions, blocks and programs."""
    ElementTree.register_namespace("", NAMESPACE)
    ElementTree.register_namespace("xhtml", XHTML)
    project = Element(f"{{{NAMESPACE}}}project")
    _add(project, "fileHeader", companyName="bristle", productName="bristle", productVersion=version(), creationDateTime=NEVER)
    content = _add(project, "contentHeader", name=name)
    _add(content, "Comment").text = head.strip().removeprefix("(*").removesuffix("*)").strip()
    coordinates = _add(content, "coordinateInfo")
    for language in ("fbd", "ld", "sfc"):
        _add(_add(coordinates, language), "scaling", x="1", y="1")
    inside = _add(project, "types")
    data_types, units = _add(inside, "dataTypes"), _add(inside, "pous")
    for part in types:
        base = _add(_add(data_types, "dataType", name=part.name), "baseType")
        if isinstance(part, Array):
            array = _add(base, "array")
            _add(array, "dimension", lower="0", upper=str(part.size - 1))
            _type(_add(array, "baseType"), part.of)
        else:
            _variables(_add(base, "struct"), part.fields)
    for pou in pous:
        unit = _add(units, "pou", name=pou.name, pouType=POU_TYPES[pou.kind])
        interface = _add(unit, "interface")
        if pou.returns:
            _type(_add(interface, "returnType"), pou.returns)
        for section, element in SECTIONS.items():
            if pou.declared(section):
                _variables(_add(interface, element), pou.declared(section))
        _text(_add(_add(unit, "body"), "ST"), "\n".join(line.removeprefix(INDENT) for line in pou.body))
        if pou.meaning:
            _text(_add(unit, "documentation"), pou.meaning)
    _add(_add(project, "instances"), "configurations")
    ElementTree.indent(project)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ElementTree.tostring(project, encoding="unicode") + "\n"


def _variables(parent: Element, variables: Sequence[Variable]) -> None:
    for variable in variables:
        element = _add(parent, "variable", name=variable.name)
        _type(_add(element, "type"), variable.type)
        if variable.initial:
            _add(_add(element, "initialValue"), "simpleValue", value=variable.initial)
        if variable.meaning:
            _text(_add(element, "documentation"), variable.meaning)


def _type(parent: Element, name: str) -> None:
    if name in ("LREAL", "REAL", "DINT", "LINT", "BOOL"):
        _add(parent, name)
    else:
        _add(parent, "derived", name=name)


def _text(parent: Element, text: str) -> None:
    ElementTree.SubElement(parent, f"{{{XHTML}}}p").text = text


def _add(parent: Element, tag: str, /, **attributes: str) -> Element:
    return ElementTree.SubElement(parent, f"{{{NAMESPACE}}}{tag}", attributes)


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
    files = {}
    for part in parts:
        names = {"name": quoteattr(part.name), "id": quoteattr(f"{{{uuid.uuid5(uuid.NAMESPACE_URL, part.name)}}}")}
        if isinstance(part, Pou):
            body = _as_cdata("\n".join([*part.body, ""]))
            text = POU.format(**names, declaration=_as_cdata(rights + declaration_text(part)), body=body)
        else:
            text = DUT.format(**names, declaration=_as_cdata(rights + part_text(part)))
        files[f"{part.name}.{'TcPOU' if isinstance(part, Pou) else 'TcDUT'}"] = HEAD + text + TAIL
    return files


def _as_cdata(text: str) -> str:
    """Return text that a reader of XML takes as it stands."""
    return f"<![CDATA[{text.replace(']]>', ']]]]><![CDATA[>')}]]>"
