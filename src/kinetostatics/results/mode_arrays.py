"""Shapes of modes of vibration and of buckling: arrays of the motions of platform, links and beams."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.math.arrays import Array, Mask, frozen
from kinetostatics.mechanism.body_graph import RigidBody
from kinetostatics.robot import Robot, robot_of
from kinetostatics.statics.small_motions import PlacedMotions

#: Number of equally spaced points of the centre line of a beam, at which its motion is computed.
STATIONS = 21


class ChunkOfModes(Protocol):
    """Modes of a chunk of n poses, ``count`` for each pose."""

    @property
    def motions(self) -> PlacedMotions:
        """Coordinates of the small motions of the rigid bodies, at the frames of the poses."""

    def of_body(self, body: RigidBody, point: Array) -> Array:
        """(n, count, 6) displacement of a point (3, n) [m] of a body and rotation of the body, world axes."""

    def of_beam(self, name: str, stations: int) -> Array:
        """(n, count, stations, 6) displacement and rotation at equally spaced points of a beam's centre line, beam axes."""


Chunk = TypeVar("Chunk", bound=ChunkOfModes)


class AtPoses:
    """What is computed at the pose or poses ``configuration``."""

    configuration: Configuration

    @property
    def robot(self) -> Robot:
        """The robot."""
        return robot_of(self.configuration)

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch shape of all results."""
        return self.configuration.shape


class Shapes(AtPoses, Generic[Chunk]):
    """Shapes of modes at N poses.

    Attributes:
        count: number of modes of each pose.
        chunks: the modes of the poses with results, in the order of the poses.
        valid: (N,) True at poses with results.
    """

    count: int
    chunks: Sequence[Chunk]
    valid: Mask

    @cached_property
    def twists(self) -> Array:
        """(…, count, 6) twist of the platform at o, world axes [m, rad]."""
        return self._array((self.count, 6), lambda chunk: chunk.of_body(chunk.motions.structure.platform, chunk.motions.o))

    @cached_property
    def link_twists(self) -> Mapping[str, Array]:
        """(…, count, 6) twist of each rigid link at the link's origin, world axes [m, rad]."""
        if not self.chunks:
            return ResultMapping({})
        body_of, bodies = self.robot.mechanism.body_of, self.chunks[0].motions.structure.graph.bodies

        def twist(chunk: Chunk, link: str, number: int) -> Array:
            at, placement = body_of[link]
            return chunk.of_body(chunk.motions.structure.graph.bodies[number], chunk.motions.frames.point(at, placement[:3, 3]))

        return ResultMapping(
            {
                link: self._array((self.count, 6), lambda chunk, link=link, number=number: twist(chunk, link, number))  # type: ignore[misc]
                for number, body in enumerate(bodies)
                for link in body.rigid_links
            }
        )

    @cached_property
    def interface_twists(self) -> Mapping[str, Array]:
        """(…, count, n, 6) twist of the n interfaces of each elastic link that is no beam, world axes [m, rad]."""
        links, topology = self.robot.statics.elastic_links, self.robot.topology

        def twists(chunk: Chunk, link: str) -> Array:
            bodies, frames, ends = chunk.motions.structure.body_at, chunk.motions.frames, topology.interfaces(link)
            return np.stack([chunk.of_body(bodies[at], links[name].ends(frames)[end]) for name, end, at in ends], axis=2)

        return ResultMapping(
            {
                link: self._array((self.count, len(topology.interfaces(link)), 6), lambda chunk, link=link: twists(chunk, link))  # type: ignore[misc]
                for link in self.robot.description.flexible
            }
        )

    @cached_property
    def beam_lines(self) -> Mapping[str, Array]:
        """(…, count, 21, 6) displacement and rotation along each beam's centre line, world axes [m, rad]."""

        def line(chunk: Chunk, name: str) -> Array:
            axes, motions = self.robot.beams[name].world_axes(chunk.motions.frames), chunk.of_beam(name, STATIONS)
            return np.einsum("ijn,nmskj->nmski", axes, motions.reshape(*motions.shape[:-1], 2, 3)).reshape(motions.shape)

        return ResultMapping(
            {
                name: self._array((self.count, STATIONS, 6), lambda chunk, name=name: line(chunk, name))  # type: ignore[misc]
                for name in self.robot.beams
            }
        )

    def _array(self, dims: tuple[int, ...], of: Callable[[Chunk], NDArray[np.generic]]) -> Array:
        """Join arrays (n, *dims) of the chunks to an array (…, *dims); NaN at poses without results."""
        joined = np.full((len(self.valid), *dims), np.nan)
        if self.chunks:
            joined[self.valid] = np.concatenate([of(chunk) for chunk in self.chunks])
        return frozen(joined.reshape(self.shape + dims))
