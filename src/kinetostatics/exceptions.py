"""Exceptions of the package.

All derive from :class:`KinetostaticsError`; their attributes contain the data of the message. Invalid arguments raise
:class:`ArgumentError`, which is a ``ValueError`` too.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping

__all__ = [
    "ArgumentError",
    "AssemblyError",
    "CoordinatesError",
    "KinetostaticsError",
    "LimbEquilibriumError",
    "PlatformMissingError",
    "RobotFileError",
    "SingularPoseError",
    "StaticsError",
    "UnknownNameError",
]


def near_names(name: object, known_names: Iterable[str]) -> str:
    """Write "did you mean …?" with the known names that are similar; without any, "known: …" with up to twelve known names.

    Letters may be capital or small, and "-" is equal to "_".
    """
    known_names = sorted(known_names)

    def plain(text: object) -> str:
        return str(text).casefold().replace("-", "_")

    plain_names = difflib.get_close_matches(plain(name), map(plain, known_names), n=3, cutoff=0.5)
    near = [candidate for text in dict.fromkeys(plain_names) for candidate in known_names if plain(candidate) == text]
    if near:
        return "did you mean " + " or ".join(repr(candidate) for candidate in near) + "?"
    if not known_names:
        return "there are none"
    shown = ", ".join(known_names[:12]) + (", …" if len(known_names) > 12 else "")
    return f"known: {shown}"


class KinetostaticsError(Exception):
    """Base class of every error of this package."""


class ArgumentError(KinetostaticsError, ValueError):
    """An argument has an invalid value; the message names the argument and its valid values."""


#: Largest length of the reason of a RobotFileError [characters]; longer ones lose their middle.
MAX_REASON = 700


class RobotFileError(KinetostaticsError):
    """A robot file is invalid.

    Attributes:
        file: path of the file, as given or included.
        line: line number in that file, or None if it is unknown.
        reason: what is wrong and what would be right.
    """

    def __init__(self, reason: str, file: str, line: int | None = None) -> None:
        if len(reason) > MAX_REASON:
            reason = f"{reason[: MAX_REASON // 2]} … {reason[-MAX_REASON // 2 :]}"
        self.reason, self.file, self.line = reason, file, line
        where = f"{file}:{line}" if line is not None else file
        super().__init__(f"{where}: {reason}")


class PlatformMissingError(RobotFileError):
    """A robot file does not name the platform, and several links are possible.

    Attributes:
        likely: names of the most probable links.
    """

    def __init__(self, file: str, line: int | None, likely: Iterable[str]) -> None:
        self.likely = tuple(likely)
        names = " or ".join(map(repr, self.likely))
        remedy = f'name it by platform_link, as {names}, or by <platform link="…"/> in the file'
        super().__init__(f"the file does not say which link is the platform: {remedy}", file, line)


class UnknownNameError(KinetostaticsError, KeyError):
    """No limb, joint, beam, actuator or contribution has this name; the message contains similar or known names.

    Attributes:
        name: the unknown name.
        known: all valid names.
    """

    def __init__(self, name: object, known: Iterable[object]) -> None:
        self.name, self.known = name, tuple(known)
        super().__init__(name)

    def __str__(self) -> str:
        return f"there is no {self.name!r} here; {near_names(self.name, map(str, self.known))}"


class AssemblyError(KinetostaticsError):
    """The loops cannot be closed at the requested coordinates.

    Attributes:
        residuals: gap of each loop, ``{loop name: (metres, radians)}``.
        residual: the largest of these gaps, in m or rad.
        mobility: the robot's mobility, or None if not known.
        reached: fraction (0 to 1) of the straight line to the requested coordinates up to which the loops close, or None.
    """

    def __init__(
        self,
        message: str,
        residuals: Mapping[str, tuple[float, float]] | None = None,
        mobility: int | None = None,
        reached: float | None = None,
    ) -> None:
        self.residuals = dict(residuals or {})
        self.residual = max((max(pair) for pair in self.residuals.values()), default=float("nan"))
        self.mobility, self.reached = mobility, reached
        super().__init__(message)


class CoordinatesError(ArgumentError):
    """The given coordinates are too few, too many, unknown, or do not determine the pose.

    Attributes:
        mobility: the robot's mobility, or None if it is irrelevant to the error.
    """

    def __init__(self, message: str, mobility: int | None = None) -> None:
        self.mobility = mobility
        super().__init__(message)


class StaticsError(KinetostaticsError):
    """Equilibrium cannot be solved at this pose."""


class SingularPoseError(StaticsError):
    """With the actuators locked the platform can still move.

    Attributes:
        free_twists: (6, k) twists at o with which the platform can move, world axes [m, rad].
    """

    def __init__(self, message: str, free_twists: object) -> None:
        self.free_twists = free_twists
        super().__init__(message)


class LimbEquilibriumError(StaticsError):
    """A limb, or a chain that is attached only to base or platform, cannot hold its own weight.

    Attributes:
        limb: name of the limb; "base" or "platform" for a chain that is attached only to it.
        joints: names of the passive joints that would move.
    """

    def __init__(self, message: str, limb: str, joints: Iterable[str]) -> None:
        self.limb, self.joints = limb, tuple(joints)
        super().__init__(message)
