"""Whatever writes, renames or removes a file goes through the owners of folders and files; all others are listed."""

import ast
from pathlib import Path

import pytest

import bristle

ROOT = Path(bristle.__file__).parent
OWNERS = {
    "files/folder.py",
    "files/owned.py",
    "files/growing.py",
    "files/results.py",
    "files/single.py",
}
OTHERS = {
    "engine/compilation.py": {"os.replace", "os.unlink", "unlink", "open"},  # the cache of kernels
    "files/permission.py": {"write_text", "unlink"},  # the state of a person: which code may run
    "apps/lab/server/cases.py": {"shutil.rmtree", "open", "unlink"},
    "apps/lab/server/gate.py": {"os.open", "unlink"},  # a file in the folder of a server
    # That of this server, of dead ones.
    "apps/lab/server/run.py": {"os.open", "os.unlink", "os.rmdir", "shutil.rmtree"},
    "apps/lab/server/routes.py": {"shutil.rmtree", "unlink"},
    "apps/lab/server/worker.py": {"write_text", "open"},
    "exports/c.py": {"write_text"},  # temporary folders, gone when they are left
    "apps/targets/fmu.py": {"write_text"},
    "exports/walk.py": {"os.replace", "unlink", "write_text"},  # the cache of kernels
    "cli/terminal.py": {"open", "os.open"},  # the null device
    "apps/study/store.py": {"write_table"},
    "apps/study/holder.py": {"os.open"},  # the null device
    "apps/tune/journal.py": {"os.open"},  # appended only
    "apps/tune/linuxcnc/hal.py": {"write_text"},  # temporary folders, for the compiler of HAL
    "apps/tune/linuxcnc/machine.py": {"unlink"},  # the files that it saved
    "contract/readers.py": {"savez"},  # into a buffer
}
FUNCTIONS = {
    "os": {
        "replace",
        "rename",
        "renames",
        "unlink",
        "remove",
        "rmdir",
        "removedirs",
        "link",
        "symlink",
        "truncate",
        "open",
    },
    "shutil": {"move", "copy", "copy2", "copyfile", "copytree", "rmtree"},
}
METHODS = {
    "unlink",
    "rename",
    "rmdir",
    "write_text",
    "write_bytes",
    "touch",
    "symlink_to",
    "hardlink_to",
    "to_csv",
    "to_parquet",
    "to_netcdf",
    "to_zarr",
}
IN_MEMORY = {"savefig", "write_table", "savetxt", "savez", "savez_compressed", "save"}
"""What writes into a buffer, which an owner then takes: their target must not be a path."""
BUFFERS = {"out", "sink", "file"}


def name_of(call):
    """Return what is called, ``os.replace`` or the name of a method."""
    function = call.func
    if isinstance(function, ast.Name):
        return function.id
    if not isinstance(function, ast.Attribute):
        return ""
    if isinstance(function.value, ast.Name) and function.attr in FUNCTIONS.get(
        function.value.id, ()
    ):
        return f"{function.value.id}.{function.attr}"
    return function.attr


def modes_of(call):
    texts = [*call.args[:2], *(keyword.value for keyword in call.keywords if keyword.arg == "mode")]
    return [
        text.value
        for text in texts
        if isinstance(text, ast.Constant) and isinstance(text.value, str)
    ]


def writes(call):
    """Return what a call does to a file; empty where it does nothing, or only to a buffer in memory."""
    name = name_of(call)
    if name == "open":
        is_method = isinstance(call.func, ast.Attribute)
        modes = [text for text in modes_of(call) if len(text) <= 3 and set(text) <= set("rwxabt+")]
        return (
            name
            if any(set(mode) & set("wxa+") for mode in modes) and (is_method or call.args)
            else ""
        )
    if name == "os.open":
        return (
            name
            if any(
                getattr(part, "attr", "").startswith(("O_WR", "O_RDWR", "O_CREAT"))
                for part in ast.walk(call)
            )
            else ""
        )
    if name.startswith(("os.", "shutil.")) or name in METHODS:
        return name
    if (
        name == "replace"
        and len(call.args) == 1
        and not call.keywords
        and isinstance(call.func, ast.Attribute)
    ):
        return ""  # of texts and data classes; Path.replace is looked for by its owners' tests
    if name in IN_MEMORY and isinstance(call.func, ast.Attribute):
        targets = [ast.unparse(part) for part in call.args]
        return "" if BUFFERS & set(targets) or name in ("save", "savefig") else name
    return "File" if name == "File" and "w" in modes_of(call) else ""


@pytest.mark.slow
def test_each_call_that_changes_a_file_is_in_an_owner_or_listed():
    result = {}
    for path in sorted(ROOT.rglob("*.py")):
        module = path.relative_to(ROOT).as_posix()
        if module in OWNERS:
            continue
        calls = {
            writes(node)
            for node in ast.walk(ast.parse(path.read_text()))
            if isinstance(node, ast.Call)
        } - {""}
        if calls:
            result[module] = calls
    assert {
        name: calls - OTHERS.get(name, set())
        for name, calls in result.items()
        if calls - OTHERS.get(name, set())
    } == {}
    assert {name for name in OTHERS if name not in result} == set()


def test_the_search_finds_calls_that_change_files():
    seen = """
open(path, "w"); path.open("ab"); os.replace(a, b); path.unlink(); path.write_bytes(b""); shutil.rmtree(x)
os.open(path, os.O_WRONLY | os.O_CREAT); parquet.write_table(table, path); h5py.File(path, "w"); np.savetxt(path, a)
"""
    calls = [writes(node) for node in ast.walk(ast.parse(seen)) if isinstance(node, ast.Call)]
    assert len(calls) == 10
    assert all(calls)
    unseen = 'open(path); path.open("rb"); text.replace("a", "b"); parquet.write_table(table, sink); os.open(p, os.O_RDONLY)'
    assert not any(
        writes(node) for node in ast.walk(ast.parse(unseen)) if isinstance(node, ast.Call)
    )
