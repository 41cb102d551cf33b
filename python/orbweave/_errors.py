"""Exceptions of the module: one class per exit status of the program."""


class OrbweaveWarning(UserWarning):
    """What a run warns of."""


class OrbweaveError(Exception):
    """A failure with its parts; a part that is not known is empty.

    problem: what went wrong; file: its path as it was given; place: "line 7", "points", a key; found: what was there;
    expected: what should have been there; advice: what to do; exit_status: of the program in the same case.
    """

    exit_status: int = 1

    def __init__(self, message: str = "", *, problem: str = "", file: str = "", place: str = "", found: str = "",
                 expected: str = "", advice: str = "") -> None:
        super().__init__(message)
        self.problem = problem
        self.file = file
        self.place = place
        self.found = found
        self.expected = expected
        self.advice = advice


class DefectError(OrbweaveError):
    """A defect in orbweave. Please report it."""


class UsageError(OrbweaveError, ValueError):
    """Wrong arguments, or a wrong job."""

    exit_status = 2


class BadInputError(OrbweaveError):
    """Bad input data."""

    exit_status = 3


class ResourceError(OrbweaveError):
    """Out of the memory budget, disk or another resource. What a job has done is kept; the same call resumes."""

    exit_status = 4


class Interrupted(OrbweaveError):
    """A request to stop. Ctrl-C raises KeyboardInterrupt instead."""

    exit_status = 130
