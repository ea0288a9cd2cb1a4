"""Jobs run in processes of their own: what ends one ends nothing else."""

import asyncio
import os
import re
import signal
import time
from dataclasses import replace
from types import SimpleNamespace

import pytest
from tests.apps.lab.browser import awaited
from tests.apps.lab.server.yard import begun, ended, put, served, settled, worker_that

from bristle.apps.lab.server import cases, limits

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
LIMITS = limits.Limits(job_seconds=6.0, grace_seconds=3.0, job_memory=2**30, jobs=2)
SLEEPS = "while True: time.sleep(0.02)"
KEEPS_THE_BEST = """
try:
    with errand.interruptible():
        errand.report(0.5, "half of it")
        while True: time.sleep(0.02)
except KeyboardInterrupt:
    return {"unfinished": "stopped early"}, {}
"""


@pytest.fixture
def client(server):
    with server.client() as client:
        yield client


@pytest.fixture
def case(client):
    path = begun(client)
    put(client, path, b"time,position\n0,1\n")
    yield path
    client.delete(path)


@pytest.fixture
def work(monkeypatch):
    return lambda body: monkeypatch.setattr("bristle.apps.lab.server.cases.CODE", worker_that(body))


def opened_in(server, case):
    (opened,) = [each for each in server.cases if case.endswith(each.identifier)]
    return opened


def started(server, client, case, task="identify"):
    """Start a job and return its process once that runs."""
    assert client.post(f"{case}/jobs", json={"task": task}).status_code == 202
    job = opened_in(server, case).job
    return awaited(lambda: job._process)


def is_gone(process):
    with pytest.raises(ProcessLookupError):
        os.kill(process.pid, 0)
    return True


@pytest.mark.slow
def test_a_killed_worker_is_reported_and_the_next_one_works(server, client, case, work):
    work(SLEEPS)
    os.kill(started(server, client, case).pid, signal.SIGKILL)
    job = settled(client, case)["job"]
    assert job["state"] == "failed"
    assert re.search("signal 9.*Run the job again", job["message"])
    work('return {"word": "done"}, {"number": float("nan")}')
    state = ended(client, case, "check")
    assert state["job"]["state"] == "done"
    assert state["parts"]["checked"]["word"] == "done"
    assert client.get(f"{case}/parts/checked").json() == {"number": None}
    assert len(list(opened_in(server, case).folder.iterdir())) == 2


def test_a_cancelled_job_keeps_its_best_result(server, client, case, work):
    work(KEEPS_THE_BEST)
    started(server, client, case)
    awaited(lambda: client.get(case).json()["job"]["share"] >= 0.5)
    assert client.post(f"{case}/cancel", json={}).json()["job"]["cancelled"]
    state = settled(client, case)
    assert (state["job"]["state"], state["parts"]["identified"]["unfinished"]) == (
        "done",
        "stopped early",
    )


def test_a_job_ends_at_once_on_request(server, client, case, work):
    work(SLEEPS)
    process = started(server, client, case)
    client.post(f"{case}/cancel", json={"at_once": True})
    assert settled(client, case)["job"]["state"] == "cancelled"
    assert is_gone(process)


@pytest.mark.slow
def test_after_its_time_a_job_is_asked_to_end_and_then_killed(server, client, case, work):
    work(KEEPS_THE_BEST)
    begin = time.monotonic()
    assert ended(client, case, "identify")["parts"]["identified"]["unfinished"] == "stopped early"
    assert LIMITS.job_seconds - LIMITS.grace_seconds < time.monotonic() - begin < LIMITS.job_seconds
    work(SLEEPS)
    job = ended(client, case, "look")["job"]
    assert (job["state"], "stopped after 6 s" in job["message"]) == ("failed", True)


@pytest.mark.slow
def test_the_memory_of_a_job_is_limited(client, case, work):
    for size, state, words in (
        (2**31, "failed", "there is not enough memory for this job. Use a shorter log"),
        (2**28, "done", ""),
    ):
        work(f"bytearray({size})\nreturn {{}}, {{}}")
        job = ended(client, case, "look")["job"]
        assert (job["state"], job["message"]) == (state, words)


def test_a_library_with_endless_output_does_no_harm(client, case, work):
    work('print("x" * 200000); sys.stderr.write("y" * 200000 + "\\nthe end\\n"); os._exit(3)')
    assert (
        ended(client, case, "look")["job"]["message"]
        == "the process of this job ended with code 3. the end"
    )


@pytest.mark.slow
def test_a_request_waits_for_a_short_job_and_a_current_log_is_not_read_again(
    server, client, case, work
):
    work("time.sleep(0.5)\nreturn {'axis_text': 'schema = 1', 'ready': True}, {}")
    assert client.post(f"{case}/jobs", json={"task": "look"}).status_code == 202
    answer = client.post(f"{case}/jobs", json={"task": "check"})
    assert (answer.status_code, list(answer.json()["parts"]), answer.json()["job"]["task"]) == (
        202,
        ["looked"],
        "check",
    )
    answer = client.post(f"{case}/jobs", json={"task": "look"})
    assert (answer.status_code, sorted(answer.json()["parts"])) == (200, ["checked", "looked"])
    answer = client.post(
        f"{case}/jobs", json={"task": "look", "options": {"edits": {"kind": "rotational"}}}
    )
    assert answer.status_code == 202
    settled(client, case)


def test_a_worker_ends_with_its_server(work):
    with served(LIMITS) as server, server.client() as client:
        case = begun(client)
        work(SLEEPS)
        process = started(server, client, case)
    awaited(lambda: process.returncode is not None, 10.0)
    assert is_gone(process)


OBEYS = """
import json, sys
sys.stdin.readline()
assert sys.stdin.readline() == "cancel\\n"
print(json.dumps({"facts": {"best": "until then"}}))
"""


@pytest.mark.parametrize(
    ("code", "seconds", "state", "facts"),
    [
        (OBEYS, 20.0, "done", {"best": "until then"}),
        ("import time; time.sleep(30.0)", 0.7, "failed", {}),
    ],
)
def test_a_job_that_takes_too_long_is_asked_to_end_and_killed_if_it_does_not(
    monkeypatch, code, seconds, state, facts
):
    monkeypatch.setattr("bristle.apps.lab.server.cases.CODE", code)
    # Asked after 0.2 s.
    job = cases.Job("identify", limits.Limits(job_seconds=seconds, grace_seconds=seconds - 0.2))
    asyncio.run(asyncio.wait_for(job.run({}), 25.0))
    assert (job.state, job.facts, job.as_data()["cancelled"]) == (state, facts, True)


RESTORES = """
errand.report(0.5, "moving")
until = time.monotonic() + 20.0
while not errand.is_cancelled() and time.monotonic() < until: time.sleep(0.02)
if time.monotonic() > until: raise TimeoutError
time.sleep(0.3)
(errand.folder.parent.parent.parent / "restored").write_text("yes")
return {"outcome": "restored"}, {}
"""


def moving(server, client, case):
    """Start a run on a machine, and return its process and the file that shows its restored machine."""
    opened = opened_in(server, case)
    opened.machine = SimpleNamespace(file="machine.toml", folder="tuned", names={})
    opened.keep("planned", cases.Part(1, opened.folder / "job", {}, opened.inputs_of("planned")))
    process = started(server, client, case, "tune")
    awaited(lambda: client.get(case).json()["job"]["share"] >= 0.5)
    return process, opened.folder.parent.parent / "restored"


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("end", [{}, {"at_once": True}])
def test_a_stopped_run_restores_its_machine(temporary, work, end):
    work(RESTORES)
    with served(LIMITS) as server, server.client() as client:
        case = begun(client)
        _, file = moving(server, client, case)
        assert client.post(f"{case}/cancel", json=end).json()["job"]["cancelled"]
        state = settled(client, case)
        assert (state["job"]["state"], state["parts"]["tuned"]["outcome"]) == ("done", "restored")
        assert file.exists()


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(("closes", "grace"), [(True, 3.0), (False, 3.0), (False, 0.05)])
def test_a_run_restores_its_machine_when_its_analysis_or_its_server_ends(
    temporary, work, closes, grace
):
    work(RESTORES)
    with served(replace(LIMITS, grace_seconds=grace)) as server, server.client() as client:
        case = begun(client)
        process, file = moving(server, client, case)
        if closes:
            client.delete(case)
    assert file.read_text() == "yes"
    assert is_gone(process)


def test_a_run_restores_its_machine_when_its_server_ends_at_once(temporary, work):
    work(RESTORES)
    job, folder = cases.Job("tune", LIMITS), temporary / "a" / "b" / "c"
    folder.mkdir(parents=True)

    async def scenario():
        running = asyncio.create_task(
            job.run({"folder": str(folder), "memory": 2**33, "logs": [], "options": {}})
        )
        while job.share < 0.5:
            assert job.runs, job.message
            await asyncio.sleep(0.02)
        running.cancel()
        await asyncio.wait([running])

    asyncio.run(asyncio.wait_for(scenario(), 30.0))
    assert (temporary / "restored").exists()


def test_a_run_stopped_before_its_process_exists_does_not_move(temporary, work):
    work(
        "return {'was_cancelled': errand.is_cancelled() or time.sleep(0.3) or errand.is_cancelled()}, {}"
    )
    job = cases.Job("tune", LIMITS)
    job.kill()
    request = {"folder": str(temporary), "memory": 2**33, "logs": [], "options": {}}
    assert asyncio.run(job.run(request))
    assert job.facts == {"was_cancelled": True}
    assert cases.Job("tune", LIMITS)._limits.job_seconds > 3600.0
