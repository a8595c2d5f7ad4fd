"""Loads on links and at the ends of beams: their wrenches at N poses, and their effect on limbs.

An attachment, at which a load acts, is a rigid link or an end of a beam. Loads on a limb are treated like its weight: they cause
attached wrenches and a sag. Each load is a separate contribution to the platform's twist.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from kinetostatics.arguments import check_choice, finite_numbers, vector
from kinetostatics.description.elements import Inertia
from kinetostatics.description.loads import LinkLoad, Payload
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.limbs.group import LimbGroup
from kinetostatics.limbs.statics import LimbStatics, limb_statics_under
from kinetostatics.math.arrays import Array, Index, Mask
from kinetostatics.math.linalg import semidefinite
from kinetostatics.math.screws import move_wrench, rotate
from kinetostatics.mechanism.limbs import Edge
from kinetostatics.mechanism.topology import AT_END
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.robot_statics import RobotStatics

#: Largest number of loads times poses that are solved at once.
_AT_ONCE = 500


@dataclass(frozen=True)
class AppliedLoad:
    """A load at N poses.

    Attributes:
        name: name of the contribution.
        wrenches: by attachment, (6, N) wrench about o, world axes [N, N·m].
        points: by attachment, (3, N) point of application of the force [m], for drawings.
        kind: "load"; "spring": the force of a spring at the pose; "change": geometric stiffness; "unit": a unit load.
        lines: by beam, (12, N) load along the beam: force and moment per length at the start, then force and moment per length at
            the end, world axes [N/m, N]. ``wrenches`` contains its resultants at the beam's ends, see
            :meth:`kinetostatics.elements.beam.BeamModel.line_resultants`.
    """

    name: str
    wrenches: Mapping[str, Array]
    points: Mapping[str, Array] = field(default_factory=dict)
    kind: str = "load"
    lines: Mapping[str, Array] = field(default_factory=dict)

    def take(self, poses: Index | slice) -> AppliedLoad:
        wrenches = {attachment: array[:, poses] for attachment, array in self.wrenches.items()}
        points = {attachment: array[:, poses] for attachment, array in self.points.items()}
        lines = {beam: array[:, poses] for beam, array in self.lines.items()}
        return AppliedLoad(self.name, wrenches, points, self.kind, lines)

    def at(self, attachments: Iterable[str]) -> dict[str, Array]:
        mine = set(attachments)
        return {attachment: wrench for attachment, wrench in self.wrenches.items() if attachment in mine}


@dataclass(frozen=True)
class AppliedStatics:
    """A load, and its effect on every group of limbs as if it acted alone.

    Attributes:
        statics: for each group of limbs, their statics under this load only; None for groups that the load does not affect.
        share: (S, N) factor of the load in each contribution.
    """

    load: AppliedLoad
    statics: tuple[LimbStatics | None, ...]
    share: Array

    @property
    def times(self) -> Array:
        """Total factor of the load (N,), the sum of ``share``."""
        found: Array = self.share.sum(axis=0)
        return found

    @cached_property
    def contributions(self) -> Sequence[int]:
        """Indices of the contributions that the load may belong to."""
        share = self.share
        return range(len(share)) if share.dtype == object else [int(k) for k in np.flatnonzero(np.any(share != 0, axis=1))]


def applied_statics(
    loads: Iterable[AppliedLoad], groups: Iterable[LimbGroup], frames: Frames, o: Array, first: int, contributions: int
) -> tuple[AppliedStatics, ...]:
    """Compute the effect of each load on the limbs as if it acted alone.

    ``first`` is the index of the first load among the contributions, whose number is ``contributions``.
    """
    found, loads = [], list(loads)
    parts = [_under(group, loads, frames, o) for group in groups]
    for number, load in enumerate(loads):
        share = np.zeros((contributions, o.shape[1]))
        share[first + number] = 1.0
        found.append(AppliedStatics(load, tuple(part[number] for part in parts), share))
    return tuple(found)


def _under(group: LimbGroup, loads: Sequence[AppliedLoad], frames: Frames, o: Array) -> list[LimbStatics | None]:
    """Return the statics of a group of limbs under each load alone; None for a load that does not affect them.

    At few poses, several loads are computed at once.
    """
    found: list[LimbStatics | None] = [None] * len(loads)
    mine = {k: load.at(group.attachments) for k, load in enumerate(loads)}
    mine = {k: wrenches for k, wrenches in mine.items() if wrenches}
    N, recorded = o.shape[1], any(wrench.dtype == object for item in mine.values() for wrench in item.values())
    at_once = 1 if recorded or o.dtype == object else max(1, _AT_ONCE // max(N, 1))
    for start in range(0, len(mine), at_once):
        some = list(mine)[start : start + at_once]
        if len(some) == 1:
            found[some[0]] = limb_statics_under(group, frames, o, mine[some[0]])
            continue
        none, names = np.zeros((6, N)), dict.fromkeys(name for k in some for name in mine[k])
        wrenches = {name: np.concatenate([mine[k].get(name, none) for k in some], axis=1) for name in names}
        again = np.tile(np.arange(N), len(some))
        together = limb_statics_under(group, frames.take(again), o[:, again], wrenches)
        for number, k in enumerate(some):
            found[k] = together.take(slice(number * N, (number + 1) * N))
    return found


def wrenches_of(applied: Iterable[AppliedLoad]) -> list[Array]:
    """Return a list with one array (6 P, N), the wrenches of all loads below one another; without loads, an empty list."""
    rows = [wrench for load in applied for wrench in load.wrenches.values()]
    return [np.concatenate(rows)] if rows else []


def by_attachment(applied: Iterable[AppliedStatics]) -> dict[str, Array]:
    """Return the sum (6, N) of all loads at each attachment, about o [N, N·m]."""
    found: dict[str, Array] = {}
    for item in applied:
        for attachment, wrench in item.load.wrenches.items():
            found[attachment] = found.get(attachment, 0.0) + wrench * item.times
    return found


def with_contributions(weights: Array, applied: Iterable[AppliedStatics], parts: Iterable[Array | None]) -> Array:
    """Return a quantity (A, S, …, N) under weights and loads on links together, by contribution.

    ``weights`` (A, S, …, N) is the quantity under weights only; without loads, this array itself is returned. ``parts`` (A, …, N)
    is the quantity under each load only; None for zero.
    """
    total = weights
    for item, part in zip(applied, parts, strict=True):
        if part is not None:
            if total is weights:
                total = np.array(weights)
            for k in item.contributions:
                total[:, k] += part * item.share[k]
    return total


def sum_of(applied: Iterable[AppliedStatics], attachments: Iterable[str] | None = None) -> Array:
    """Return the sum (6, N) of the loads at given attachments (None: all), about o; zeros (6, 1) if no load acts there."""
    wrenches = by_attachment(applied)
    mine = [wrenches[name] for name in (wrenches if attachments is None else dict.fromkeys(attachments)) if name in wrenches]
    return np.sum(mine, axis=0) if mine else np.zeros((6, 1))


#: The name of a payload's contribution.
PAYLOAD = "payload"


@dataclass(frozen=True)
class _Load:
    """A wrench or a mass at a point (…, 3) [m] of a link's frame (None: the platform and o-xyz); ``name`` is its contribution."""

    name: str
    link: str | None
    point: Array
    wrench: Array | None = None  # (…, 6)
    in_link_frame: bool = False
    mass: Array | None = None  # (…, 1)
    inertia: Inertia = field(default_factory=Inertia)


@dataclass(frozen=True)
class LinkLoads:
    """Checked loads on links.

    Points, wrenches and masses are (…, 3), (…, 6) and (…, 1); for a chunk of N poses they are (3, N), (6, N) and (1, N).
    """

    robot: RobotStatics
    loads: tuple[_Load, ...]

    def arrays(self) -> list[Array]:
        return [array for item in self.loads for array in (item.point, item.wrench, item.mass) if array is not None]

    def map(self, change: Callable[[Array], Array]) -> LinkLoads:
        def changed(array: Array | None) -> Array | None:
            return None if array is None else change(array)

        return LinkLoads(
            self.robot,
            tuple(
                replace(item, point=change(item.point), wrench=changed(item.wrench), mass=changed(item.mass))
                for item in self.loads
            ),
        )

    def at(self, frames: Frames, gravity: Array) -> tuple[AppliedLoad, ...]:
        """Return the loads of a chunk as wrenches, under ``gravity`` (3, N) [m/s²].

        Raises:
            ArgumentError: a load acts on a beam between its ends, or on a link without support.
        """
        _, o = self.robot.mechanism.platform_pose(frames)
        found: dict[str, dict[str, Array]] = {}
        points: dict[str, dict[str, Array]] = {}
        for item in self.loads:
            _, R, point = self._placed(item, frames)
            if item.mass is not None:
                own = np.concatenate([gravity * item.mass, np.zeros_like(gravity)])
            else:
                assert item.wrench is not None
                own = rotate(R, item.wrench) if item.in_link_frame else item.wrench
            wrench = move_wrench(own, o - point)
            mine = found.setdefault(item.name, {})
            for attachment, where in self._attachments(item, frames, point).items():
                mine[attachment] = mine.get(attachment, 0.0) + np.where(where, wrench, 0.0)
                points.setdefault(item.name, {}).setdefault(attachment, point)
        return tuple(AppliedLoad(name, wrenches, points[name]) for name, wrenches in found.items())

    def _attachments(self, item: _Load, frames: Frames, point: Array) -> dict[str, Mask]:
        if item.link is None:
            return {self.robot.topology.platform.root: np.ones(point.shape[1], dtype=bool)}
        return attachments_at(self.robot, item.name, item.link, frames, point)

    def _placed(self, item: _Load, frames: Frames) -> tuple[str, Array, Array]:
        """Return the loaded link, the axes (3, 3, N) of its frame, and the point of application (3, N) [m] of the load."""
        R, origin = link_frame(self.robot, item.link, frames)
        return item.link or self.robot.description.platform, R, origin + np.einsum("ijn,jn->in", R, item.point)

    def masses(self, frames: Frames) -> Iterator[tuple[str, int, Array, Array, Array, Array]]:
        """Yield the inertial data of every mass, for each attachment at which the mass acts at some of the N poses.

        The data are: the attachment; the body; the centre of mass (3, N) [m]; the mass (N,) [kg]; the axes (3, 3, N) of the link;
        the inertia (3, 3, N) about the centre of mass in these axes [kg·m²]. Mass and inertia are 0 at poses at which the mass
        acts at another attachment.

        Raises:
            ArgumentError: as for :meth:`at`.
        """
        for item in self.loads:
            if item.mass is not None:
                link, R, point = self._placed(item, frames)
                for attachment, where in self._attachments(item, frames, point).items():
                    mass, body = np.where(where, item.mass[0], 0.0), self.robot.mechanism.body_of[link][0]
                    yield attachment, body, point, mass, R, np.where(mass > 0, semidefinite(item.inertia.matrix)[:, :, None], 0.0)


def attachments_at(robot: RobotStatics, what: str, link: str, frames: Frames, point: Array) -> dict[str, Mask]:
    """Return, by attachment, a mask (N,): True at the poses at which a load at ``point`` (3, N) of a link acts there.

    Raises:
        ArgumentError: the point of an elastic link is no end of a beam, or the link has no support; ``what`` begins the message.
    """
    topology = robot.topology
    if joints := _joint_around(robot, link):
        raise ArgumentError(
            f"{what}: {link!r} has no mass and lies between the joints {', '.join(joints)}, which form one joint; load a link "
            "beside them"
        )
    if link in topology.without_support:
        raise ArgumentError(
            f"{what}: {link!r} hangs by {topology.without_support[link]!r} on a beam elsewhere than at its ends; split "
            "the beam there with a fixed joint, or load one of its ends"
        )
    beams = [name for name, span in topology.spans.items() if span.part.link == link]
    if not beams:
        return {link: np.ones(point.shape[1], dtype=bool)}
    found: dict[str, Mask] = {}
    nowhere = np.all(np.isfinite(point), axis=0)
    ends = []
    for name in beams:
        span, reach = topology.spans[name], AT_END * np.abs(robot.elastic_links[name].length(frames))
        both = (span.start_body, span.start), (span.end_body, span.end)
        for attachment, (body, local) in zip(topology.span_ends[name], both, strict=True):
            at = frames.point(body, local)
            here = nowhere & (np.sqrt(np.sum((at - point) ** 2, axis=0)) <= reach)
            if np.any(here):
                found[attachment] = here
                nowhere &= ~here
            ends.append(at)
    if np.any(nowhere):
        pose = int(np.flatnonzero(nowhere)[0])
        R, origin = link_frame(robot, link, frames)

        def words(at: Array) -> str:
            local = np.round(R[:, :, pose].T @ (at - origin)[:, pose], 9)
            return "(" + ", ".join(f"{value + 0.0:.6g}" for value in local) + ")"

        raise ArgumentError(
            f"{what}: {link!r} is elastic, and {words(point)} is no end of its beam: a load on it may act at "
            f"{' or '.join(map(words, ends))} of its frame; elsewhere split the beam with a fixed joint"
        )
    return found


def _joint_around(robot: RobotStatics, link: str) -> tuple[str, ...]:
    """Return the revolute joints that form a universal or spherical joint with ``link`` inside it; empty for other links."""
    key = robot.topology.carried_by.get(link)
    for group in robot.groups:
        for limb, compounds in zip(group.limbs, group.compounds, strict=True):
            if link not in limb.attachments:
                continue
            branches = {edge.key: edge for edge in limb.branches}
            while key in branches:
                key = branches[key].parent
            welds = {edge.key: edge for edge in limb.edges if _is_weld(robot, edge)}
            while key in welds:
                key = welds[key].parent
            welded = {key}
            for edge in welds.values():  # inboard ones first
                welded |= {edge.key} if edge.parent in welded else set()
            inner = [edge.joint for edge in limb.edges if edge.key == key]
            beyond = [edge.joint for edge in limb.edges if edge.parent in welded and edge.key not in welds]
            for joints in (compound.joints for compound in compounds):
                if inner and beyond and set(inner + beyond) <= set(joints):
                    return tuple(name for name in robot.mechanism.connections if name in joints)
    return ()


def _is_weld(robot: RobotStatics, edge: Edge) -> bool:
    if edge.joint is None:
        return False
    return robot.mechanism.connections[edge.joint].type.is_fixed and edge.joint not in robot.description.joint_stiffness


def link_frame(robot: RobotStatics, link: str | None, frames: Frames) -> tuple[Array, Array]:
    """Return orientation (3, 3, N) and origin (3, N) of the frame of a link, or of o-xyz for None."""
    mechanism = robot.mechanism
    if link is None:
        return mechanism.platform_pose(frames)
    body, placement = mechanism.body_of[link]
    R = np.einsum("ijn,jk->ikn", frames.rotation[:, :, body], placement[:3, :3])
    return R, frames.point(body, placement[:3, 3])


def parse_link_loads(robot: RobotStatics, loads: Mapping[str, object] | None, payload: Payload | None) -> LinkLoads | None:
    """Check the arguments ``loads`` and ``payload`` of an analysis; return None without loads.

    Raises:
        ArgumentError: a link is unknown, or a value or shape is invalid.
    """
    found: list[_Load] = []
    if loads is not None and not isinstance(loads, Mapping):
        raise ArgumentError(f"loads= needs a mapping from names of links to loads, got {loads!r}")
    for link, value in (loads or {}).items():
        _check_link(robot, "loads=", link)
        several = value if isinstance(value, (list, tuple)) and any(isinstance(item, LinkLoad) for item in value) else [value]
        found += [_load_of(link, item) for item in several]
    if payload is not None:
        found.append(_payload(robot, payload))
    return LinkLoads(robot, tuple(found)) if found else None


def _load_of(link: str, value: object) -> _Load:
    name = f"load on {link}"
    load = value if isinstance(value, LinkLoad) else LinkLoad(value)  # type: ignore[arg-type]
    check_choice(f"the frame of the {name}", load.frame, ("world", "link"))
    wrench, point = vector(f"the {name}", load.wrench, 6), vector(f"the point of the {name}", load.point, 3)
    return _Load(name, link, point, wrench, load.frame == "link")


def _payload(robot: RobotStatics, payload: object) -> _Load:
    if not isinstance(payload, Payload):
        raise ArgumentError(f"payload= needs a Payload, such as ks.Payload(5.0, center=(0, 0, 0.1)), got {payload!r}")
    if payload.link is not None:
        _check_link(robot, "the payload's link", payload.link)
    mass = finite_numbers("the payload's mass", payload.mass)
    if np.any(mass < 0):
        raise ArgumentError(f"the payload's mass is {payload.mass!r}; it must be zero or more [kg]")
    center, inertia = vector("the payload's center", payload.center, 3), payload.inertia or Inertia()
    if not isinstance(inertia, Inertia):
        raise ArgumentError(f"the payload's inertia is {inertia!r}; it must be a kinetostatics.description.Inertia")
    for name, size in (("moments", 6), ("rpy", 3)):
        vector(f"the payload's inertia, {name},", getattr(inertia, name), size)
    if inertia.flaw:
        raise ArgumentError(f"the payload's inertia is impossible: {inertia.flaw}")
    return _Load(PAYLOAD, payload.link, center, mass=mass[..., None], inertia=inertia)


def _check_link(robot: RobotStatics, what: str, link: object) -> None:
    known = robot.description.links
    if not isinstance(link, str) or link not in known:
        raise ArgumentError(f"{what} names no link {link!r}: {near_names(str(link), known)}")
