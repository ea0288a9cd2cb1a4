"""The requests of the page."""

import asyncio
import secrets
import shutil
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import Route

from bristle.apps.lab.server.cases import (
    ROLES,
    Case,
    Cases,
    Job,
    Part,
    StoredFile,
    announced_by,
    json_of,
    label_of,
    stored,
)
from bristle.apps.lab.server.errand import DATA
from bristle.apps.lab.server.gate import ENTRANCE, HAS_TOKEN, Opening
from bristle.apps.lab.server.limits import RESTORING, Limits, RefusedRequestError
from bristle.apps.lab.server.tune import TunedMachine

REPORT, LONGEST_REPORT_TICKET = "report.html", 60.0  # [s]
# Job -> its result.
LEAVES = {
    "look": "looked",
    "check": "checked",
    "identify": "identified",
    "predict": "predicted",
    "compensate": "compensated",
    "export": "exported",
    "excite": "excited",
    "plan": "planned",
    "tune": "tuned",
    "undo": "undone",
}
# Jobs that the next request waits for.
SHORT = ("look", "check", "predict", "compensate", "export", "plan", "undo")
# Result of a job -> its archive; an export names its own.
DOWNLOADS = {"identified": "results.zip", "exported": "export.zip", "excited": "motion.zip"}
REPORTS = {"identified": Path("results") / REPORT, "excited": Path("motion") / REPORT}
# A report is a separate page. It runs isolated from this page and from the server, and requests no data.
SHOWN_POLICY = (
    "sandbox allow-scripts allow-downloads; default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline' "
    "'wasm-unsafe-eval'; img-src data:; frame-ancestors 'self'"
)


class Routes:
    """The answers to the requests of the page."""

    def __init__(
        self, cases: Cases, opening: Opening, limits: Limits, page: Response, entrance: Response
    ) -> None:
        self._cases, self._opening, self._limits, self._page, self._entrance = (
            cases,
            opening,
            limits,
            page,
            entrance,
        )
        self._work: set[asyncio.Task[None]] = set()
        self._tickets: dict[str, tuple[Path, float]] = {}
        self._home = Path.cwd()

    def all(self) -> list[Route]:
        """Return all routes."""
        case = "/api/cases/{case}"
        return [
            Route("/", self.page, methods=["GET"]),
            Route(f"{ENTRANCE}{{ticket}}", self.enter, methods=["GET"]),
            Route("/shown/{ticket}", self.show_report, methods=["GET"]),
            Route("/api/cases", self.begin, methods=["POST"]),
            Route(case, self.state, methods=["GET"]),
            Route(case, self.close, methods=["DELETE"]),
            Route(f"{case}/files", self.receive, methods=["PUT"]),
            Route(f"{case}/files/{{number:int}}", self.remove, methods=["DELETE"]),
            Route(f"{case}/files/{{number:int}}/role", self.assign, methods=["POST"]),
            Route(f"{case}/jobs", self.start, methods=["POST"]),
            Route(f"{case}/cancel", self.cancel, methods=["POST"]),
            Route(f"{case}/parts/{{part}}", self.part, methods=["GET"]),
            Route(f"{case}/parts/{{part}}/archive", self.archive, methods=["GET"]),
            Route(f"{case}/parts/{{part}}/ticket", self.ticket, methods=["POST"]),
            Route(f"{case}/machine", self.choose_machine, methods=["POST"]),
            Route(f"{case}/machine", self.run_of_machine, methods=["GET"]),
            Route(f"{case}/machine/records/{{name}}", self.record, methods=["GET"]),
            Route(f"{case}/machine/ticket", self.ticket_of_run, methods=["POST"]),
        ]

    async def page(self, request: Request) -> Response:
        """Return the page, which contains no secrets."""
        return self._page

    async def enter(self, request: Request) -> Response:
        """Redirect a browser started by bristle to the page, which it then requests from this server."""
        if not self._opening.redeem(request.path_params["ticket"]):
            raise RefusedRequestError(
                404,
                "this address is no longer valid",
                path="file",
                mend="Open the address printed by bristle",
            )
        return self._entrance

    async def begin(self, request: Request) -> Response:
        """Start an analysis."""
        return JSONResponse(self._cases.new().as_data(), 201)

    async def state(self, request: Request) -> Response:
        """Return the state of an analysis."""
        return JSONResponse(self._case(request).as_data())

    async def close(self, request: Request) -> Response:
        """Close an analysis and remove its files."""
        self._cases.close(self._case(request))
        return JSONResponse({})

    async def receive(self, request: Request) -> Response:
        """Receive a file in pieces, under a name chosen by the server."""
        case, role = self._case(request), request.headers.get("x-bristle-role", ROLES[0])
        if role not in ROLES:
            raise RefusedRequestError(
                400, "is not a role of a file", path="role", value=role, allowed=", ".join(ROLES)
            )
        announced = announced_by(request)
        most = self._cases.room_for(case, announced)
        if role == "axis":
            most = min(most, self._limits.body_size)
        number = case.number()
        place, reserved = case.folder / f"file-{number}", min(announced, most)
        self._cases.receiving += reserved
        try:
            size = await stored(request, place, most, self._limits.silence_seconds)
        finally:
            self._cases.receiving -= reserved
        file = StoredFile(
            number, label_of(request.headers.get("x-bristle-name", "")), role, size, place
        )
        if role == "axis":
            try:
                case.axis, case.axis_label = place.read_text(encoding="utf-8-sig"), file.label
            except UnicodeDecodeError:
                raise RefusedRequestError(
                    400, "is not a text file in UTF-8", path=file.label
                ) from None
            finally:
                place.unlink()
        else:
            case.files[number] = file
        case.changed(role)
        return JSONResponse(case.as_data(), 201)

    async def remove(self, request: Request) -> Response:
        """Remove a file."""
        case, file = self._file(request)
        del case.files[file.number]
        case.changed(file.role)
        file.place.unlink(missing_ok=True)
        return JSONResponse(case.as_data())

    async def assign(self, request: Request) -> Response:
        """Assign a log to the fit, or hold it out."""
        role = (await self._body(request)).get("role")
        if role not in ROLES[:2]:
            raise RefusedRequestError(
                400, "is not a role of a log", path="role", value=role, allowed=", ".join(ROLES[:2])
            )
        case, file = self._file(request)
        case.files[file.number] = replace(file, role=role)
        for changed in ROLES[:2]:
            case.changed(changed)
        return JSONResponse(case.as_data())

    async def start(self, request: Request) -> Response:
        """Start a job, unless this analysis has a running job or too many run in total."""
        body, case = await self._body(request), self._case(request)
        task, options = body.get("task"), body.get("options", {})
        if task not in LEAVES or not isinstance(options, dict):
            raise RefusedRequestError(
                400, "is not a job", path="task", value=task, allowed=", ".join(LEAVES)
            )
        # A request waits for short jobs before it, also for those of another tab.
        async with case.turn:
            while case.job is not None and case.job.runs and case.job.task in SHORT:
                await asyncio.sleep(0.05)
            # Refused if it was closed meanwhile.
            return await self._begin(self._case(request), task, options)

    async def _begin(self, case: Case, task: str, options: Mapping[str, Any]) -> Response:
        if task == "look" and not options and "looked" in case.parts and not case.is_old("looked"):
            return JSONResponse(case.as_data())
        if case.job is not None and case.job.runs:
            raise RefusedRequestError(
                409,
                "this analysis has a running job",
                path="job",
                mend="Wait until the job ends, or cancel it",
            )
        if task in RESTORING:
            machine = self._machine(case)
            options = {"file": str(machine.file), "folder": str(machine.folder)}
            if task == "tune" and ("planned" not in case.parts or case.is_old("planned")):
                raise RefusedRequestError(
                    409, "needs its plan", path="run", mend="Show the plan first"
                )
        running = sum(open_case.job is not None and open_case.job.runs for open_case in self._cases)
        if running >= self._limits.jobs:
            raise RefusedRequestError(
                429, f"{running} jobs are running", path="job", mend="Wait until a job has ended"
            )
        work = asyncio.create_task(self._run(case, Job(task, self._limits), options))
        self._work.add(work)
        work.add_done_callback(self._work.discard)
        await asyncio.sleep(0)
        return JSONResponse(case.as_data(), 202)

    async def _run(self, case: Case, job: Job, options: Mapping[str, Any]) -> None:
        """Run a job and keep its result. After an identification predict the held-out logs."""
        case.job, part, number = job, LEAVES[job.task], case.number()
        folder, made_of = case.folder / f"job-{number}", case.inputs_of(LEAVES[job.task])
        folder.mkdir(mode=0o700)
        identified = case.parts.get("identified")
        text = case.axis or ""
        succeeded = await job.run(
            {
                "folder": str(folder),
                "options": options,
                "memory": self._limits.job_memory,
                "logs": [
                    (str(file.place), file.label, file.role)
                    for file in case.logs("fit", "held_out")
                ],
                "axis_text": text,
                "axis_label": case.axis_label,
                "size_limit": self._limits.file_size,
                "results": str(identified.folder / "results") if identified is not None else None,
            }
        )
        if not succeeded:
            shutil.rmtree(folder, ignore_errors=True)
            return
        facts = dict(job.facts)
        if (changed := facts.pop("axis_text", text)) != text:
            case.axis = changed
            # A change of the loop leaves the model valid.
            case.changed("loop" if job.task == "compensate" else "axis")
            made_of = case.inputs_of(part)
        case.keep(part, Part(number, folder, facts, made_of))
        if job.task == "identify":
            case.changed("model")
        if job.task == "identify" and case.logs("held_out"):
            await self._run(case, Job("predict", self._limits), {})

    async def cancel(self, request: Request) -> Response:
        """End a job with its best result, or at once."""
        body, case = await self._body(request), self._case(request)
        if case.job is not None and case.job.runs:
            case.job.kill() if body.get("at_once") else case.job.cancel()
        return JSONResponse(case.as_data())

    async def part(self, request: Request) -> Response:
        """Return the data of a result for the page."""
        return FileResponse(self._part(request).folder / DATA, media_type="application/json")

    async def archive(self, request: Request) -> Response:
        """Return the archive of a result."""
        part, name = self._part(request), request.path_params["part"]
        if name not in DOWNLOADS:
            raise RefusedRequestError(404, "has no archive", path=name)
        label = str(part.facts.get("file", DOWNLOADS[name]))
        return FileResponse(
            part.folder / DOWNLOADS[name], media_type="application/zip", filename=label
        )

    async def ticket(self, request: Request) -> Response:
        """Return an address that shows a report once, because a frame cannot send the token."""
        part, name = self._part(request), request.path_params["part"]
        if name not in REPORTS:
            raise RefusedRequestError(404, "has no report", path=name)
        return self._ticket_for(part.folder / REPORTS[name])

    async def choose_machine(self, request: Request) -> Response:
        """Choose the machine file and the folder of a run, by their paths below the folder of the server."""
        body, case = await self._body(request), self._case(request)
        if case.job is not None and case.job.runs and case.job.restores:
            raise RefusedRequestError(
                409,
                "is in use by the running job",
                path="machine",
                mend="Wait until the job ends, or stop it",
            )
        case.machine = await asyncio.to_thread(TunedMachine.of, self._home, body)
        case.changed("machine")
        return JSONResponse(case.as_data())

    async def run_of_machine(self, request: Request) -> Response:
        """Return the state of the run in the folder, also of a run of another process."""
        return JSONResponse(await asyncio.to_thread(self._machine(self._case(request)).as_data))

    async def record(self, request: Request) -> Response:
        """Return the curves of a record of the run."""
        return JSONResponse(
            await asyncio.to_thread(
                self._machine(self._case(request)).record, request.path_params["name"]
            )
        )

    async def ticket_of_run(self, request: Request) -> Response:
        """Return an address that shows the report of the run once."""
        return self._ticket_for(self._machine(self._case(request)).folder / REPORT)

    def _ticket_for(self, file: Path) -> Response:
        now = time.monotonic()
        self._tickets = {key: value for key, value in self._tickets.items() if value[1] > now}
        ticket = secrets.token_urlsafe(32)
        self._tickets[ticket] = (file, now + LONGEST_REPORT_TICKET)
        return JSONResponse({"address": f"/shown/{ticket}"}, 201)

    async def show_report(self, request: Request) -> Response:
        """Show a report, once."""
        file, until = self._tickets.pop(request.path_params["ticket"], (None, 0.0))
        if file is None or time.monotonic() > until or not file.is_file():
            raise RefusedRequestError(
                404,
                "is no longer available",
                path="report",
                mend="Open the report again from the lab",
            )
        request.scope["state"][HAS_TOKEN] = True  # a ticket is given for a token only
        return FileResponse(
            file, media_type="text/html", headers={"content-security-policy": SHOWN_POLICY}
        )

    async def end(self) -> None:
        """End all jobs and wait for them, so that no job writes later."""
        for case in self._cases:
            if case.job is not None:
                case.job.kill()
        if self._work:
            # Until killed processes are gone, and machines restored.
            await asyncio.wait(self._work, timeout=self._limits.grace_seconds)

    def _case(self, request: Request) -> Case:
        return self._cases[request.path_params["case"]]

    def _machine(self, case: Case) -> TunedMachine:
        if case.machine is None:
            raise RefusedRequestError(
                404, "is missing", path="machine file", mend="Name a machine file and a folder"
            )
        return case.machine

    def _file(self, request: Request) -> tuple[Case, StoredFile]:
        case = self._case(request)
        file = case.files.get(request.path_params["number"])
        if file is None:
            raise RefusedRequestError(404, "no longer exists", path="file")
        return case, file

    def _part(self, request: Request) -> Part:
        part = self._case(request).parts.get(request.path_params["part"])
        if part is None:
            raise RefusedRequestError(
                404,
                "this part of the analysis does not exist yet",
                path=request.path_params["part"],
            )
        return part

    async def _body(self, request: Request) -> dict[str, Any]:
        return await json_of(request, self._limits.body_size, self._limits.silence_seconds)
