"""pschema: a long-lived learning daemon for embodied agents, from Python.

* `Body` and `run`: a body that a learner lives in.
* `connect`: look into a running learner, and give it orders.
* `Learner`: a learner in this process, without a daemon.
* ``pschema.gym``: a Gymnasium environment as a body.

The package brings the ``pschema`` command: ``pschema server`` is the daemon.
"""

from __future__ import annotations

from ._native import Action, Stop, __version__
from .body import Body, Summary, run
from .client import Client, Past, connect
from .daemon import Daemon, program
from .declare import (
    ActionType,
    Description,
    Observation,
    Outcome,
    Sense,
    Value,
    Values,
    action,
    boolean,
    event,
    integer,
    real,
    state,
    symbol,
    value,
)
from .errors import AnswerError, ArgumentError, DeclarationError, Error, FrameError, NoDaemonError, RefusedError
from .functions import FunctionBody
from .learner import Learner

__all__ = [
    "Action",
    "ActionType",
    "AnswerError",
    "ArgumentError",
    "Body",
    "Client",
    "Daemon",
    "DeclarationError",
    "Description",
    "Error",
    "FrameError",
    "FunctionBody",
    "Learner",
    "NoDaemonError",
    "Observation",
    "Outcome",
    "Past",
    "RefusedError",
    "Sense",
    "Stop",
    "Summary",
    "Value",
    "Values",
    "__version__",
    "action",
    "boolean",
    "connect",
    "event",
    "integer",
    "program",
    "real",
    "run",
    "state",
    "symbol",
    "value",
]
