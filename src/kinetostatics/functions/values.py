"""What a function of a robot returns."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.math.arrays import Array
from kinetostatics.printing.mappings import Named


class Values(Mapping[str, Array]):
    """What a function returns: arrays by name, batch axes first, and the pose.

    Attributes:
        origin: what the function knows of the pose without making it: where its next line may begin.
    """

    def __init__(self, arrays: Mapping[str, Any], pose: Callable[[], Configuration], origin: object = None) -> None:
        self._arrays, self._made, self.origin = Named(arrays), pose, origin

    @cached_property
    def pose(self) -> Configuration:
        """The pose or poses; ``near=`` of the next call."""
        return self._made()

    def __reduce__(self) -> tuple[Any, ...]:
        """Take the pose along, not what makes it."""
        return _known, (dict(self._arrays), self.pose)

    def __getitem__(self, name: str) -> Any:
        if name not in self._arrays:
            raise ArgumentError(f"there is no output {name!r}: {near_names(name, self._arrays)}")
        return self._arrays[name]

    def __iter__(self) -> Any:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)

    def __repr__(self) -> str:
        return f"<Values: {', '.join(self._arrays)}>"


def _known(arrays: Mapping[str, Any], pose: Configuration) -> Values:
    return Values(arrays, lambda: pose)
