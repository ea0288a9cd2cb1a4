"""Structured Text of a friction model or an operator: a function block with its functions, and a self-test.

A block contains its state and its parameters; its functions receive both by reference. Its results are identical to
those of bristle, except for the sign of a zero, which the language cannot detect.
"""

from collections.abc import Collection
from typing import Any

from bristle.apps.targets import st_project
from bristle.apps.targets.st_code import Printer
from bristle.apps.targets.st_parts import (
    LREAL,
    REAL,
    WITHIN,
    Array as ArrayPart,
    Names,
    Pou,
    Variable,
    checked,
    real_literal,
)
from bristle.apps.targets.st_project import (
    FARTHEST,
    Tuned,
    body_lines,
    call_text,
    interface,
    set_lines,
)
from bristle.core.variable import unit_of, variables_of
from bristle.engine.translation.tree import Array, Struct, Type
from bristle.exports.described import Request, Source, meaning_of, model_facts, plain
from bristle.exports.feed import Feed, with_feed
from bristle.exports.law import (
    INPUTS,
    PER_VELOCITY,
    Law,
    law_facts,
    law_walk,
    settled_law,
    tunable_law,
)
from bristle.exports.subject import (
    COMMIT,
    COUNT,
    TRIAL,
    Subject,
    arguments_left,
    settled_subject,
    subject_of,
    walk_of,
)
from bristle.exports.targets import Product
from bristle.exports.tunable import CONSTANTS, Tunable, single_note, tunable_of
from bristle.models.controllers.feedforward import Rule
from bristle.prediction.drive_units import CommandUnits, command_units

# Inputs of a block for the rule of its feed, with the largest values.
TUNED = {"gain": 1.0, "return_distance": 1e6, "fade_time": 1e6}
# By whether the block is that of an operator.
IN = {False: "position", True: "excitation"}
OUT = {False: "force", True: "response"}
MEANINGS = {
    False: ("position of the axis", "mean friction force of the last step"),
    True: ("input of the operator", "output of the operator"),
}
OWN = """
position period restart clear force refused overflow begun prepared usable done last_position command place state memory motion
parameters tried after feed gain return_distance fade_time rule fed share speed
"""


SCALARS = {False: LREAL, True: REAL}  # type of real numbers, by single precision


NOTHING_TUNABLE = Tunable("translational", {}, {}, {})


def st_files(subject: Subject, request: Request) -> dict[str, str]:
    """Return the text of each file of a friction model or an operator by its name."""
    name = request.name
    single = request.single
    operator = subject.is_operator
    around = (subject.state, subject.move, subject.parameters, Array(subject.memory_size))
    unit = subject.unit
    feed = None
    walk = walk_of(subject, request.dt)
    x = walk.positions(COUNT)
    last_call = f"{IN[operator]} := {real_literal(10.0 * FARTHEST)}"
    if operator:
        outputs = subject.outputs(x)
        farthest = st_project.FARTHEST_OF_OPERATOR
    else:
        with_it, feed = with_feed(subject)
        unit = with_it.unit
        around += (subject.motion,)
        if feed is not None:
            around += (feed.rule, feed.result)
        outputs = subject.forces(x, request.dt)
        farthest = FARTHEST
        last_call += f", period := {real_literal(request.dt)}"
    printer = Printer(unit, name, around, SCALARS[single])
    judged = st_project.Judged(name, outputs, single)
    facts = st_project.commented_facts(
        model_facts(
            subject, name, request.source, request.dt, single=single, tunable=request.tunable
        )
    )
    facts |= {
        "unit_in": plain(facts["unit_x"]),
        "unit_out": plain(facts["unit_force"]),
        "input": IN[operator],
        "count": COUNT,
        "output": OUT[operator],
        "result": OUT[operator],
    }
    facts |= st_project.bounds(single=single, farthest=farthest)
    block = _block(subject, feed, request, printer, facts)
    body = body_lines(
        "st/selftest.st",
        facts
        | st_project.walk_facts(walk, printer, "count")
        | judged.facts()
        | {"last_call": last_call},
    )
    test = Pou("PROGRAM", f"{name}_selftest", "", tuple(judged.variables()), body)
    return st_project.project_files(
        name, printer, facts, block, test, judged.arrays(walk), "st/head.st", request.source
    )


def _block(
    subject: Subject, feed: Feed | None, request: Request, printer: Printer, facts: dict[str, Any]
) -> Pou:
    operator = subject.is_operator
    kind = subject.model.kind
    names = Names(OWN.split())
    units = None
    if not operator:
        units = command_units(request.axis, kind)
    signals = {signal: names.of(signal, signal) for signal in subject.signals}
    tried = subject.trial.result
    assert isinstance(tried, Struct)
    handed = {
        "dt": printer.narrowed("period"),
        "p": "parameters",
        "input": printer.narrowed(IN[True]),
        "move": f"tried.{printer.field(tried, '_1')}",
    }
    trial = arguments_left(subject.trial, TRIAL[operator])
    commit = []
    committed = ""
    if subject.commits:
        commit = arguments_left(subject.commit, COMMIT)
        values = [handed.get(name, name) for name in commit]
        committed = call_text(printer, subject.commit, values, "after")
    needed = {*trial, *commit}
    if subject.state.fields:
        needed.add("state")
    memories = {}
    if "memory" in needed and subject.memory_size:
        memories = {"memory": subject.memory_size}
    tunable = NOTHING_TUNABLE
    if request.tunable:
        tunable = tunable_of(subject.model)
    tuned = Tuned.of(tunable, names)
    start = []
    tuned_lines = []
    if "p" in needed:
        p = subject.parameters
        start += set_lines("parameters", subject.model.parameters, p, printer, tunable.places)
        tuned_lines += tuned.lines("parameters", p, printer)
    start += set_lines("state", subject.virgin, subject.state, printer)
    motion = []
    if "motion" in trial:
        motion = _motion(subject, printer, signals, single=request.single)
    facts = (
        facts
        | {"start": start, "zero": printer.real(0.0), "memories": memories}
        | {"state": bool(subject.state.fields), "commit": committed}
        | {"ranges": [*tuned.ranges(printer)], "tuned": tuned_lines}
        | {"signals": list(signals.values())}
        | {"motion": motion, "within": printer.helper(WITHIN, LREAL)}
        | {
            "trial": call_text(
                printer, subject.trial, [handed.get(name, name) for name in trial], "tried"
            )
        }
        | {"tried": printer.widened(f"tried.{printer.field(tried, '_0')}")}
        | {"drive": _divisor(units), "feed": False}
    )
    of_feed: list[Variable] = []
    if feed is not None:
        facts |= _feed_facts(feed, request, printer)
        of_feed = _feed_variables(feed, request, printer)
    own = _own_variables(subject, needed)
    meanings = variables_of(subject.motion.cls)
    meaning_in, meaning_out = MEANINGS[operator]
    period = []
    flags = ["prepared", "usable", "done"]
    last = []
    if not operator:
        period = [Variable("period", "LREAL", "time since the last call [s]", "VAR_INPUT")]
        flags = ["prepared", "begun", "usable", "done"]
        last = [Variable("last_position", "LREAL")]
    if memories:
        last.append(Variable("place", "DINT"))
    variables = [
        Variable(IN[operator], "LREAL", f"{meaning_in} [{facts['unit_in']}]", "VAR_INPUT"),
        *period,
        *(
            Variable(
                name,
                "LREAL",
                meaning_of(meanings[key], subject.model.kind),
                "VAR_INPUT",
                real_literal(subject.usual[key]),
            )
            for key, name in signals.items()
        ),
        *tuned.inputs(printer),
        *st_project.interface(
            "virgin contact, no sample yet",
            OUT[operator],
            f"{meaning_out} [{facts['unit_out']}]",
            units,
        ),
        *of_feed,
        *(Variable(name, printer.type_name(kind)) for name, kind in own),
        *(Variable(name, "BOOL") for name in flags),
        *last,
    ]
    return Pou(
        "FUNCTION_BLOCK", request.name, "", tuple(variables), body_lines("st/block.st", facts)
    )


def _divisor(units: CommandUnits | None) -> str:
    """Return the effort of one unit of a drive in SI units; empty without such units."""
    if units is None:
        return ""
    return real_literal(units.effort.si)


def _own_variables(subject: Subject, needed: Collection[str]) -> list[tuple[str, Type]]:
    """Return the variables that a block keeps, with their types."""
    held: dict[str, tuple[str, Type]] = {
        "state": ("state", subject.state),
        "memory": ("memory", Array(subject.memory_size)),
        "motion": ("motion", subject.motion),
        "p": ("parameters", subject.parameters),
    }
    own = [pair for key, pair in held.items() if key in needed]
    own.append(("tried", subject.trial.result))
    if subject.commits:
        own.append(("after", subject.state))
    return own


def _feed_facts(feed: Feed, request: Request, printer: Printer) -> dict[str, Any]:
    """Return the facts of the feed for the block: the lines that set its rule, its call, and the ranges of its inputs."""
    inputs = {(name,) for name in TUNED}
    handed = [printer.narrowed("force"), "share", "speed", printer.narrowed("period"), "rule"]
    call = call_text(printer, feed.portion, handed, "fed")
    return {
        "feed": {
            "start": [*set_lines("rule", request.share, feed.rule, printer, inputs)],
            "tuned": [f"rule.{printer.field(feed.rule, name)} := {name};" for name in TUNED],
            "ranges": [
                f"({name} >= {printer.real(0.0)}) AND ({name} <= {printer.real(most)})"
                for name, most in TUNED.items()
            ],
            "speed": _speed(printer, single=request.single),
            "call": call,
            "share": f"fed.{printer.field(feed.result, 'share')}",
            "effort": printer.widened(f"fed.{printer.field(feed.result, 'effort')}"),
            "zero": printer.real(0.0),
        }
    }


def _feed_variables(feed: Feed, request: Request, printer: Printer) -> list[Variable]:
    """Return the inputs and the output of the feed, and its own variables."""
    meanings = variables_of(Rule)
    kind = request.model.kind
    values = request.share._asdict()
    inputs = [
        Variable(
            name,
            printer.scalar,
            meaning_of(meanings[name], kind),
            "VAR_INPUT",
            printer.real(values[name]),
        )
        for name in TUNED
    ]
    output = Variable(
        "feed",
        "LREAL",
        f"effort to feed forward along the desired motion [{unit_of('force', kind)}]",
        "VAR_OUTPUT",
    )
    own = [
        Variable("rule", printer.type_name(feed.rule)),
        Variable("fed", printer.type_name(feed.result)),
    ]
    return [
        *inputs,
        output,
        *own,
        Variable("share", printer.scalar),
        Variable("speed", printer.scalar),
    ]


def _speed(printer: Printer, *, single: bool) -> str:
    """Return the text of the velocity of a step."""
    if not single:
        return "(position - last_position) / period"
    return f"{printer.narrowed('position - last_position')} / {printer.narrowed('period')}"


def _motion(
    subject: Subject, printer: Printer, signals: dict[str, str], *, single: bool
) -> list[str]:
    # A sum with 0.0 turns -0.0 into 0.0: a step of length 0 has no sign.
    v = f"{_speed(printer, single=single)} + {printer.real(0.0)}"
    values = {"v": v, "x": printer.narrowed("position")}
    values |= {name: printer.real(usual) for name, usual in subject.usual.items()}
    values |= {name: printer.narrowed(signal) for name, signal in signals.items()}
    motion = subject.motion
    return [f"motion.{printer.field(motion, name)} := {values[name]};" for name, _ in motion.fields]


def write(request: Request) -> Product:
    """Return the function block, its self-test, and both as XML."""
    checked(request.name)
    fixed = None
    if request.single:
        fixed = CONSTANTS
    subject = subject_of(request.sampled, fixed)
    places = ()
    if request.tunable:
        places = tunable_of(subject.model).places
    files = st_files(settled_subject(subject, places, single=request.single), request)
    notes = ["a velocity of -0.0 counts as 0.0, because the language cannot distinguish them"]
    if request.single:
        notes += [single_note(OUT[subject.is_operator])]
    return Product(dict(files), tuple(notes))


OWN_OF_LAW = """
restart clear effort command refused overflow parameters lasting now memory table_memory leads prepared begun usable done place
"""
ALONG_WALK = {
    "velocity": "speed",
    "acceleration": f"{PER_VELOCITY!r} * speed",
    "position": "places[count]",
}


def st_law_files(law: Law, name: str, source: Source) -> dict[str, str]:
    """Return the files of a control law in Structured Text, text by name."""
    checked(name)
    law = settled_law(law)
    facts = st_project.commented_facts(law_facts(law, name, source))
    around = (
        *law.types,
        *(Array(memory.size) for memory in law.memories.values()),
        Array(law.samples_ahead),
    )
    facts |= {"output": "effort", "operator": False, "unit_in": facts["unit_x"], "count": COUNT}
    facts |= st_project.bounds(single=law.single, farthest=st_project.FARTHEST_OF_LAW)
    printer = Printer(law.unit, name, around, SCALARS[law.single])
    block = _law_block(law, name, printer, facts)
    test, arrays = _law_selftest(law, name, printer, facts)
    return st_project.project_files(
        name, printer, facts, block, test, arrays, "st/law_head.st", source
    )


def _law_block(law: Law, name: str, printer: Printer, facts: dict[str, Any]) -> Pou:
    lasting, p = law.types
    units = command_units(law.variant.axis, law.variant.controller.kind)
    now = law.entry.result
    assert isinstance(now, Struct)
    needed = [parameter.name for parameter in law.entry.parameters]
    ahead_names = [fed["name"] for fed in facts["inputs"] if fed["several"]]
    arrays = []
    if law.single:
        arrays = ahead_names
    handed = {name: printer.narrowed(name) for name in law.inputs if name not in ahead_names}
    handed |= {"dt": printer.real(law.dt), "p": "parameters"} | {
        name: f"narrowed_{name}" for name in arrays
    }
    tunable = NOTHING_TUNABLE
    if law.tunable:
        tunable = tunable_law(law)
    tuned = Tuned.of(
        tunable, Names([*OWN_OF_LAW.split(), *INPUTS, *(f"narrowed_{name}" for name in INPUTS)])
    )
    memories = {
        name: memory for name, memory in law.memories.items() if name in needed and memory.size
    }
    start = [
        *set_lines("parameters", law.p, p, printer, tunable.places),
        *set_lines("lasting", law.lasting, lasting, printer),
    ]
    of_block = (
        {"divisor": _divisor(units), "start": start}
        | {"memories": {name: memory.size for name, memory in memories.items()}}
        | {"within": printer.helper(WITHIN, LREAL), "zero": printer.real(0.0)}
        | {
            "ranges": [*tuned.ranges(printer)],
            "tuned": [*tuned.lines("parameters", p, printer)],
            "after": f"now.{printer.field(now, '_1')}",
        }
        | {
            "narrowed": [
                f"narrowed_{name}[place] := {printer.narrowed(f'{name}[place]')};"
                for name in arrays
            ]
        }
        | {
            "remembered": [
                f"{name}[{i}] := {printer.real(x)};"
                for name, memory in memories.items()
                for i, x in enumerate(memory.tolist())
                if x
            ]
        }
        | {
            "command": call_text(
                printer, law.entry, [handed.get(name, name) for name in needed], "now"
            )
        }
        | {"commanded": printer.widened(f"now.{printer.field(now, '_0')}")}
    )
    own = [("parameters", p), ("lasting", lasting), ("now", now)]
    own += [(name, Array(memory.size)) for name, memory in memories.items()]
    own += [(f"narrowed_{name}", Array(law.samples_ahead)) for name in arrays]
    types = {True: printer.array(law.samples_ahead, LREAL), False: "LREAL"}
    counted = []
    if memories or ahead_names:
        counted = [Variable("place", "DINT")]
    variables = [
        *(
            Variable(
                fed["name"],
                types[fed["several"]],
                plain(f"{fed['told']} [{fed['unit']}]"),
                "VAR_INPUT",
            )
            for fed in facts["inputs"]
        ),
        *tuned.inputs(printer),
        *interface(
            "the law takes over the desired motion",
            "effort",
            f"command for the drive [{facts['unit_force']}]",
            units,
        ),
        *(Variable(name, printer.type_name(kind)) for name, kind in own),
        *(Variable(name, "BOOL") for name in ("prepared", "begun", "usable", "done")),
        *counted,
    ]
    return Pou(
        "FUNCTION_BLOCK", name, "", tuple(variables), body_lines("st/law.st", facts | of_block)
    )


def _law_selftest(
    law: Law, name: str, printer: Printer, facts: dict[str, Any]
) -> tuple[Pou, tuple[ArrayPart, ...]]:
    walk, positions, efforts = law_walk(law, COUNT)
    judged = st_project.Judged(name, efforts, law.single)
    of_test = {
        "told": ", ".join(f"{name} := {ALONG_WALK.get(name, name)}" for name in law.inputs),
        "positions": positions,
        "per_velocity": real_literal(PER_VELOCITY),
        "last_call": f"measured := {real_literal(10.0 * FARTHEST)}",
    }
    body = body_lines(
        "st/law_selftest.st",
        facts | st_project.walk_facts(walk, printer, "each") | judged.facts() | of_test,
    )
    arrays_ahead = [fed["name"] for fed in facts["inputs"] if fed["several"]]
    counted = []
    if arrays_ahead:
        counted = [Variable("ahead", "DINT")]
    variables = [
        *judged.variables(),
        *counted,
        *(Variable(name, "LREAL") for name in ("speed", "measured")),
        *(Variable(name, printer.array(law.samples_ahead, LREAL)) for name in arrays_ahead),
        Variable("places", f"{name}_Places"),
    ]
    arrays = judged.arrays(walk, ArrayPart(f"{name}_Places", positions, LREAL))
    return Pou("PROGRAM", f"{name}_selftest", "", tuple(variables), body), arrays
