"""The poses of a chunk with the loads at them: what an equilibrium is solved for."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from kinetostatics.limbs.group import LimbGroup
from kinetostatics.math.arrays import Array, Index
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.assembly_errors import AssemblyErrors
from kinetostatics.statics.link_loads import AppliedLoad


@dataclass(frozen=True)
class LoadedPoses:
    """N poses with the loads at them.

    Attributes:
        frames: frames of all bodies.
        load: (6, N) external load on the platform about o [N, N·m], world axes.
        gravity: (3, N) [m/s²], world axes.
        assembly_errors: assembly errors of joints and beams.
        applied: loads on links.
        groups: the limbs; None: the groups of generic poses.
        weights: (6, W, N) the robot's weights about o; None: those under ``gravity``.
        support: see :class:`.PlatformEquilibrium`.
    """

    frames: Frames
    load: Array
    gravity: Array
    assembly_errors: AssemblyErrors | None = None
    applied: tuple[AppliedLoad, ...] = ()
    groups: tuple[LimbGroup, ...] | None = None
    weights: Array | None = None
    support: float = 0.0

    def take(self, poses: Index | slice) -> LoadedPoses:
        """Return the poses with given numbers."""
        return replace(
            self,
            frames=self.frames.take(poses),
            load=self.load[:, poses],
            gravity=self.gravity[:, poses],
            assembly_errors=None if self.assembly_errors is None else self.assembly_errors.map(lambda array: array[:, poses]),
            applied=tuple(item.take(poses) for item in self.applied),
            weights=None if self.weights is None else self.weights[:, :, poses],
        )


@dataclass(frozen=True)
class LoadedAttachments:
    """Names of the loads on links, each with the attachments at which the load acts."""

    loads: tuple[tuple[str, tuple[str, ...]], ...]

    @classmethod
    def of(cls, applied: Iterable[AppliedLoad]) -> LoadedAttachments | None:
        return cls(tuple((item.name, tuple(item.wrenches)) for item in applied)) if applied else None
