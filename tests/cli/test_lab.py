"""`bristle lab`: a page for all models, or for the given one first; nothing else is ever replaced."""

import os
import subprocess
import sys

import pytest

import bristle as br
from bristle.apps.lab.command import is_sealed, sealed
from bristle.apps.lab.page import MARK
from bristle.apps.lab.server.run import listening_on
from bristle.cli.application import run
from bristle.files.single import write_whole


@pytest.fixture
def page(tmp_path, monkeypatch):
    """What every page begins with is enough here: the pages themselves have their tests."""
    monkeypatch.setattr(
        "bristle.apps.lab.lab_page", lambda *_, **facts: f"{MARK}\n{facts.get('model')}"
    )
    return tmp_path / "lab.html"


def model_in(folder):
    file = folder / "model.toml"
    br.write_model(file, br.plants.inertia(M=3.0), br.friction.coulomb(F_C="20 N"))
    return file


def test_it_writes_a_page_with_or_without_a_model(page, tmp_path, capsys):
    assert run(["lab", "--out", str(page)]) == 0
    assert page.read_text().startswith(MARK)
    assert str(page) in capsys.readouterr().err
    model_in(tmp_path)
    for read in (tmp_path, tmp_path / "model.toml"):
        assert run(["lab", str(read), "--out", str(page), "--force"]) == 0
        assert "coulomb(F_C=20 N" in page.read_text()
    assert sorted(file.name for file in tmp_path.iterdir()) == ["lab.html", "model.toml"]


def test_the_page_gets_the_facts_of_the_file(tmp_path, monkeypatch):
    facts = {}
    monkeypatch.setattr("bristle.apps.lab.lab_page", lambda **values: facts.update(values) or MARK)
    file = model_in(tmp_path)
    file.write_text(
        file.read_text()
        + '\n[uncertainty.F_C]\nstatus = "identified"\ninterval = [18.0, 22.0]\n[treatment]\nvelocity_max = 0.2\n'
    )
    assert run(["lab", str(file), "--out", str(tmp_path / "lab.html")]) == 0
    assert (facts["mass"], facts["fastest"]) == (3.0, 0.2)
    assert facts["uncertainty"]["F_C"]["interval"] == [18.0, 22.0]
    assert facts["source"] == "model.toml"
    assert "model" in " ".join(facts["provenance"])


@pytest.mark.parametrize("options", [[], ["--force"]])
def test_a_foreign_file_is_not_replaced(page, options, capsys):
    page.write_text("mine")
    with pytest.raises(
        br.core.InputError, match="was not written by bristle lab, or was changed later"
    ):
        run(["lab", "--out", str(page), *options])
    assert page.read_text() == "mine"


def test_a_page_is_replaced_only_when_asked_for(page):
    page.write_text(sealed(f"{MARK} old"))
    old = page.read_text()
    with pytest.raises(br.core.InputError, match="already exists"):
        run(["lab", "--out", str(page)])
    assert page.read_text() == old
    assert run(["lab", "--out", str(page), "--force"]) == 0
    assert page.read_text() != old
    assert run(["lab", "--out", str(page), "--force"]) == 0


def test_a_page_with_a_remark_a_link_to_one_and_a_pipe_are_not_replaced(page, tmp_path):
    assert run(["lab", "--out", str(page)]) == 0
    written = page.read_text()
    (tmp_path / "link.html").symlink_to(page)
    os.mkfifo(tmp_path / "pipe.html")
    for name in ("link.html", "pipe.html"):
        with pytest.raises(
            br.core.InputError, match="was not written by bristle lab, or was changed later"
        ):
            run(["lab", "--out", str(tmp_path / name), "--force"])
    page.write_text(written.replace("None", "None, and an hour of work"))
    with pytest.raises(br.core.InputError, match="was not written by bristle lab"):
        run(["lab", "--out", str(page), "--force"])
    assert "an hour of work" in page.read_text()


def test_the_lab_is_served_with_the_given_options(monkeypatch, capsys):
    calls = []

    def serve(*, announce, **chosen):
        calls.append(chosen)
        announce("http://127.0.0.1:1/#token")
        raise KeyboardInterrupt  # Ctrl-C is how it ends

    monkeypatch.setattr("bristle.apps.lab.server.serve", serve)
    monkeypatch.setenv("BRISTLE_SIZE_LIMIT", "2 MB")
    assert run(["lab", "--serve", "--no-open", "--port", "8123"]) == 0
    (chosen,) = calls
    assert (chosen["port"], chosen["opens"], chosen["limits"].file_size) == (8123, False, 2_000_000)
    assert chosen["limits"].total_size == 8_000_000
    printed = capsys.readouterr()
    assert printed.out == "http://127.0.0.1:1/#token\n"
    assert "Ctrl-C" in printed.err


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (["lab"], "--out: is missing"),
        (["lab", "--out", "nowhere/lab.html"], "cannot be written"),
        (["lab", "--port", "8000", "--out", "x.html"], "applies to --serve only"),
        (["lab", "--no-open", "--out", "x.html"], "applies to --serve only"),
        (["lab", "model.toml", "--serve"], "cannot be combined with --serve"),
        (["lab", "--serve", "--out", "x.html"], "cannot be combined with --serve"),
        (["lab", "--serve", "--port", "70000"], "is not a port"),
    ],
)
def test_unsuitable_options_are_refused(page, here, line, words):
    with pytest.raises(br.core.InputError, match=words):
        run(line)


@pytest.mark.parametrize("package", ["starlette", "uvicorn"])
def test_a_missing_package_is_reported_with_its_install_command(monkeypatch, package):
    monkeypatch.setattr(
        "bristle.apps.lab.server.run.find_spec", lambda name: None if name == package else object()
    )
    with pytest.raises(br.core.errors.MissingExtraError, match=r'pip install "bristle\[lab\]"'):
        run(["lab", "--serve"])


def test_the_server_is_loaded_only_if_it_is_installed():
    code = "import sys; sys.modules['starlette'] = sys.modules['uvicorn'] = None; from bristle.apps.lab.server import Limits, serve"
    assert (
        subprocess.run([sys.executable, "-c", code], capture_output=True, check=False).returncode
        == 0
    )


def test_an_occupied_port_is_reported():
    with listening_on(0) as listening:
        address, port = listening.getsockname()
        assert address == "127.0.0.1"
        with pytest.raises(
            br.core.InputError, match=r"cannot be opened: [^()]+; found \d+\. Leave --port out"
        ):
            run(["lab", "--serve", "--no-open", "--port", str(port)])


def test_a_page_that_cannot_be_encoded_is_sealed_as_it_is_written(tmp_path):
    file = write_whole(tmp_path / "page.html", sealed("<p>caf\udce9</p>\n"))
    assert is_sealed(file)
    file.write_bytes(file.read_bytes().replace(b"<p>", b"<b>"))
    assert not is_sealed(file)
