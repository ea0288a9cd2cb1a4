"""What jobs do: each a function of an errand, all of it through the public face of bristle."""

from bristle.server.tasks.check import check
from bristle.server.tasks.errand import Errand
from bristle.server.tasks.excite import excite
from bristle.server.tasks.export import export
from bristle.server.tasks.identify import identify
from bristle.server.tasks.look import look
from bristle.server.tasks.predict import predict

__all__ = ["TASKS", "Errand"]

TASKS = {"look": look, "check": check, "identify": identify, "predict": predict, "export": export, "excite": excite}
"""By the name that the page knows."""
