"""Freedoms of joints of all types: axes, the bodies in which they are fixed, and a point on each axis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinetostatics.description.joint_types import Axes
from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import unit_twist
from kinetostatics.mechanism.elastic_joints import is_sprung
from kinetostatics.mechanism.mechanism import Connection, Mechanism
from kinetostatics.mechanism.tree import Frames


@dataclass(frozen=True)
class Freedom:
    """One freedom of a joint: a rotation about, or a translation along, an axis (3,) fixed in a body.

    ``centre`` is a point (3,) of ``centre_body`` on the axis; ``sign`` is −1 if the joint's successor is its inboard side.
    ``passive``: neither driven nor sprung; ``stiffness`` [N/m, N·m/rad] is that of a spring, if given.
    """

    rotates: bool
    body: int
    axis: Array
    centre_body: int
    centre: Array
    sign: int = 1
    label: str = ""
    passive: bool = True
    stiffness: float = 0.0


class Freedoms:
    """Freedoms as arrays; ``rotates`` (k,): mask of rotations."""

    def __init__(self, items: Sequence[Freedom]) -> None:
        self.rotates = np.array([item.rotates for item in items], dtype=bool)
        self._bodies = np.array([item.body for item in items], dtype=np.intp)
        self._axes = np.array([item.axis * item.sign for item in items], dtype=float).reshape(-1, 3).T
        self._centre_bodies = np.array([item.centre_body for item in items], dtype=np.intp)
        self._centres = np.array([item.centre for item in items], dtype=float).reshape(-1, 3).T

    def twists(self, frames: Frames, o: Array) -> Array:
        """Return their unit twists (6, k, N) about o (3, N)."""
        arms = frames.points(self._centre_bodies, self._centres) - o[:, None]
        return unit_twist(frames.directions(self._bodies, self._axes), arms, self.rotates[:, None])


def freedoms_of(mechanism: Mechanism, connection: Connection, sign: int = 1) -> tuple[Freedom, ...]:
    """Return the freedoms of a joint or loop, from base to platform; driven and elastic freedoms are not passive."""
    kind, stiffness = connection.type, mechanism.description.joint_stiffness.get(connection.name)
    here, frame, there, other = (
        *(connection.predecessor_body, connection.predecessor_frame),
        *(connection.successor_body, connection.successor_frame),
    )
    moved = there, other[:3, 3]
    centre = moved if kind.slides is not Axes.NONE and not kind.is_on_axis else (here, frame[:3, 3])

    def freedom(rotates: bool, body: int, axis: Array, centre: tuple[int, Array], which: str = "") -> Freedom:
        own = frame[:3, :3].T @ axis if body == here else None  # None: it moves in the predecessor's frame
        passive = not connection.driven and not is_sprung(stiffness, rotates, own)
        return Freedom(rotates, body, axis, *centre, sign, connection.name + which, passive)

    slides, turns = (frame[:3, :3] @ axes for axes in kind.axes(connection.axis))
    found = [freedom(False, here, axis, moved) for axis in slides.T]
    found += [freedom(True, here, axis, centre, " (first axis)" if kind.turns is Axes.BOTH else "") for axis in turns.T]
    if kind.turns is Axes.BOTH:
        found.append(freedom(True, there, other[:3, :3] @ connection.axis2, centre, " (second axis)"))
    return tuple(found if sign > 0 else found[::-1])
