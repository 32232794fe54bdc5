"""What can go wrong. All of it is an `Error`; each message says what, where, and what to do."""

from __future__ import annotations

__all__ = [
    "AnswerError",
    "ArgumentError",
    "DeclarationError",
    "Error",
    "FrameError",
    "NoDaemonError",
    "RefusedError",
]


class Error(Exception):
    """Something that pschema could not do."""


class ArgumentError(Error, ValueError, TypeError):
    """A function was given what it does not take, of another type or of another value. The message names the argument."""


class DeclarationError(Error, ValueError):
    """A declaration of senses and actions that is not allowed. The message names the place."""


class FrameError(Error, ValueError):
    """An observation that the body did not declare so. The message names the observation and the property."""


class NoDaemonError(Error, ConnectionError):
    """No daemon serves the learner: none was started, it is still starting, or it has gone."""


class RefusedError(Error):
    """The daemon does not take the body, for the reason in the message.

    ``code`` is the number of the refusal in ``docs/PROTOCOL.md``: 21 when a body of the same name is attached, 16 when the
    declaration contradicts what was learnt; 0 when it has as many bodies as it takes.
    """

    def __init__(self, reason: str, code: int = 0) -> None:
        super().__init__(reason)
        self.code = code


class AnswerError(Error):
    """The learner was asked and has no answer, or does not obey; the message has its reason."""
