"""Errors of phex; each kind asks for something else of the user."""


class PhexError(Exception):
    """Base of all errors of phex."""


class InputError(PhexError, ValueError):
    """A surface, mesh, file or option can't be used; the message names the element and the cause."""


class NoValidResult(PhexError):
    """No valid mesh was reached. ``result`` is the mesh that was, with its report, or ``None``."""

    result = None


class Cancelled(PhexError):
    """The computation was stopped: by ``cancel``, or by a callback that returned ``False``."""


class InternalError(PhexError):
    """A bug of phex, or a machine that fails."""
