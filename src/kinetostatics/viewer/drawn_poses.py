"""Poses of a scene, and small displacements of the robot's points by contributions: what each load or weight causes.

A path is a sequence of poses that the page animates. The stations of a beam are the points along it at which a result gives its
displacements.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Collection, Iterator, Mapping
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetostatics.arguments import warn
from kinetostatics.elements.link import LinkSurface
from kinetostatics.engine.recorder import recorded
from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array, batch_first, zeros_for
from kinetostatics.math.screws import move
from kinetostatics.results.result import Result
from kinetostatics.robot import Robot
from kinetostatics.sections.kinds import Section
from kinetostatics.statics.solution import of_deformation
from kinetostatics.status import Status


class DrawnPoses(ABC):
    """F poses of a robot, and small twists by each of K contributions; the first axis of all arrays is F.

    "At rest" means undeformed.

    Attributes:
        count: number of poses, F.
        step: every ``step``-th station of a beam is shown, among them both ends and the middle.
        rigid: names of the links that move as rigid bodies.
        contribution_names: names of the contributions.
        labels: labels of the contributions on the page.
    """

    robot: Robot
    count: int
    step: int
    rigid: Collection[str]
    contribution_names: tuple[str, ...]
    labels: tuple[str, ...]

    @abstractmethod
    def placed(self, body: int, placement: Array) -> Array:
        """Return (F, 4, 4) frames at rest: a placement (4, 4) in a body, in world axes."""

    def frame(self, link: str) -> Array:
        """Return (F, 4, 4) frames of a link at rest."""
        return self.placed(*self.robot.mechanism.body_of[link])

    @cached_property
    def platform_frame(self) -> Array:
        """(F, 4, 4) frames o-xyz at rest."""
        return self.placed(*self.robot.mechanism.platform_frame)

    @property
    def o(self) -> Array:
        """(F, 3) origins of :attr:`platform_frame` [m]."""
        return np.asanyarray(self.platform_frame[:, :3, 3])

    @property
    @abstractmethod
    def platform_twist(self) -> Array:
        """(F, K, 6) twists of the platform at o, world axes [m, rad]."""

    @abstractmethod
    def link_twist(self, link: str) -> Array | None:
        """Return (F, K, 6) twists of a rigid link at its own origin [m, rad]; None if it contains a beam."""

    def twist_at(self, link: str, point: Array) -> Array:
        """Return (F, K, 6) twists of a link at points (F, 3) [m, rad].

        A point of a link with beams moves with the nearest end of these beams.
        """
        for name, part in self.robot.description.flexible.items():
            if part.link == link:
                return blended(point[:, None], self.interfaces(name), self.interface_twists(name))[:, :, 0]
        link_twist = self.link_twist(link)
        if link_twist is not None:
            return moved(link_twist, point - self.frame(link)[:, :3, 3])
        ends = []
        for name, beam in self.robot.description.beams.items():
            if beam.link == link:
                _, points = self.beam_line(name)
                for end in (0, -1):
                    ends.append((float(np.linalg.norm(points[0, end] - point[0])), name, end, points[:, end]))
        if not ends:
            return np.zeros((self.count, len(self.contribution_names), 6))
        _, name, end, at = min(ends, key=lambda end_point: end_point[0])
        return moved(self.beam_twists(name)[:, :, end], point - at)

    @abstractmethod
    def beam_line(self, name: str) -> tuple[Array, Array]:
        """Return the rotation matrix (F, 3, 3), x along the beam, and the stations (F, n, 3) [m] of a beam at rest."""

    def section(self, name: str) -> Section:
        """Return the section of a beam, from its inner end."""
        return self.robot.beams[name].section

    @abstractmethod
    def beam_twists(self, name: str) -> Array:
        """Return (F, K, n, 6) twists of a beam's stations [m, rad]."""

    def interfaces(self, name: str) -> Array:
        """Return (F, n, 3) interfaces of an elastic link that is no beam, at rest [m]."""
        topology, body = self.robot.topology, self.robot.mechanism.body_of[self.robot.description.flexible[name].link][0]
        ends = [(topology.spans[key].start, topology.spans[key].end)[end] for key, end, _ in topology.interfaces(name)]
        frame = self.placed(body, np.eye(4))
        return np.asanyarray(np.stack(ends) @ np.swapaxes(frame[:, :3, :3], 1, 2) + frame[:, None, :3, 3])

    def interface_twists(self, name: str) -> Array:
        """Return (F, K, n, 6) twists of these interfaces [m, rad]; as of a rigid link, unless more is known."""
        link = self.robot.description.flexible[name].link
        arms, twist = np.moveaxis(self.interfaces(name) - self.frame(link)[:, None, :3, 3], 1, 0), self.link_twist(link)
        assert twist is not None
        return np.stack([moved(twist, arm) for arm in arms], axis=2)

    def surface(self, name: str) -> LinkSurface | None:
        return self.robot.statics.elastic_links[self.robot.topology.interfaces(name)[0][0]].surface

    def inner_coordinates(self, name: str, surface: LinkSurface) -> Array:
        """Return (F, K, m) internal coordinates of an elastic link."""
        axes, twists = self.frame(self.robot.description.flexible[name].link)[:, None, :3, :3], self.interface_twists(name)
        squares, gravity = self.squares_and_gravity(name)
        ends = (twists.reshape(*twists.shape[:2], -1, 3) @ axes).reshape(*twists.shape[:2], -1)
        return surface.vibration.inner_coordinates(ends, squares, (gravity[:, :, None] @ axes)[:, :, 0] @ surface.weight.T)

    def squares_and_gravity(self, name: str) -> tuple[Array, Array]:
        """Return squares (F, K) of angular frequencies [1/s²], and the gravity (F, K, 3) [m/s²] that acts on an elastic link.

        Gravity is along world axes, and zero for all contributions but that of the link's weight.
        """
        return np.zeros(self.platform_twist.shape[:2]), zeros_for((*self.platform_twist.shape[:2], 3), self.platform_twist)

    @abstractmethod
    def tension(self, name: str) -> Array:
        """Return the force (F,) of a spring, tension positive [N]."""


def moved(twist: Array, arm: Array) -> Array:
    """Return the twists (F, K, 6) of a body at a point displaced by ``arm`` (F, 3) [m] from the point of ``twist`` (F, K, 6)."""
    return move("twist", twist, arm[:, None], components_last=True)


#: Weight of rotations, times the distance of the interfaces, in the mean motion of a link.
TURNING = 0.1


def blended(points: Array, interfaces: Array, twists: Array) -> Array:
    """Return twists (F, K, m, 6) at points (F, m, 3) of a link, smooth between the ``twists`` (F, K, n, 6) of its interfaces.

    Beyond the interfaces' mean rigid motion, displacements have weights w by inverse squares of the distances to ``interfaces``
    (F, n, 3), and rotations w², which gives the deflection of a bent beam in its middle. The rotation is half the curl.
    """

    def carried(twist: Array, arms: Array) -> Array:
        return move("twist", twist[:, :, None], arms[:, None], components_last=True)

    (F, K), centre = twists.shape[:2], interfaces.mean(axis=1, keepdims=True)
    size = float(np.sqrt(np.mean((interfaces - centre) ** 2)))
    unit = np.array([1.0] * 3 + [TURNING * size] * 3)
    rigid = carried(np.eye(6)[None], interfaces - centre) * unit
    mean = (twists * unit).reshape(F, K, 6 * twists.shape[2]) @ np.linalg.pinv(rigid.reshape(F, 6, -1))
    d, r = np.split((twists - carried(mean, interfaces - centre))[:, :, None], 2, axis=-1)
    arms = (points[:, :, None] - interfaces[:, None])[:, None]
    inverse = 1 / (np.sum(arms**2, axis=-1, keepdims=True) + 1e-12 * size**2)
    w = inverse / inverse.sum(axis=3, keepdims=True)
    slopes = -2 * w * inverse * arms
    slopes = slopes - w * slopes.sum(axis=3, keepdims=True)
    turned = np.cross(r, arms)
    linear, turns = np.sum(w * d + w**2 * turned, axis=3), np.sum(w**2 * r + np.cross(slopes, d / 2 + w * turned), axis=3)
    return np.asanyarray(carried(mean, points - centre) + np.concatenate([linear, turns], axis=-1))


#: Largest number of poses of a page.
MOST_POSES = 1000
#: Pairs (largest number of poses, :attr:`DrawnPoses.step`).
STEPS = ((100, 1), (250, 2), (MOST_POSES, 5))


class ShownPoses(DrawnPoses):
    """The analysed poses of a result in the order of a path.

    Attributes:
        indices: (F,) indices of these poses in the flattened batch.
        has_texts: whether their scene has a heading and notes.
    """

    has_texts = True

    def __init__(self, result: Result, pose: int | tuple[int, ...] | None = None, every: int = 1) -> None:
        self.result, self.robot, self.rigid = result, result.robot, result.link_contributions
        order = serpentine(result.shape) if pose is None else np.array([place_of(result.shape, pose)])
        twist = result.twist.reshape(-1, 6)[order]
        good = np.all(np.isfinite(twist), axis=-1)
        if not np.any(good):
            raise ArgumentError(_nothing_to_show(result, order))
        if not np.all(good):
            warn(f"{int(np.sum(~good))} of {len(order)} poses could not be analysed and are not drawn")
        self.indices = order[good]
        if len(self.indices) > MOST_POSES:
            raise ArgumentError(
                f"the result has {len(self.indices)} poses; a page shows at most {MOST_POSES}: take a coarser path or grid"
            )
        self.indices = self.indices[::every]
        self.count = len(self.indices)
        self.step = next(step for most, step in STEPS if self.count <= most)
        self.contribution_names, self.labels = tuple(result.contributions), labels_of(result)

    def take(self, array: Array) -> Array:
        """Return the drawn poses (F, …) of an array (*batch, …) of the result."""
        shape = self.result.shape
        flat = np.reshape(array, (math.prod(shape), *np.shape(array)[len(shape) :]))
        return np.asanyarray(recorded(flat[self.indices]))

    def by_contribution(self, contributions: Mapping[str, Array]) -> Array:
        """Return arrays (*batch, …) by contribution as one array (F, K, …), which is zero for missing contributions."""
        none = np.zeros_like(next(iter(contributions.values())))
        arrays = [contributions.get(name, none) for name in self.contribution_names]
        return self.take(np.stack(arrays, axis=len(self.result.shape)))

    def parts(self, contributions: Mapping[str, Array]) -> Array:
        """Return :meth:`by_contribution` with a last entry of zeros, (F, K + 1, …); NaN is replaced by zero."""
        by_contribution = self.by_contribution(contributions)
        parts = zeros_for((by_contribution.shape[0], by_contribution.shape[1] + 1, *by_contribution.shape[2:]), by_contribution)
        parts[:, :-1] = np.where(np.isnan(by_contribution), 0.0, by_contribution)
        return parts

    def of_configuration(self, array: Array, components: int) -> Array:
        """Return the drawn poses (F, …) of an array of the configuration, which has ``components`` axes after its batch.

        The batch of the configuration may be smaller than the batch of the result.
        """
        shape = self.result.shape + array.shape[array.ndim - components :]
        return self.take(np.broadcast_to(array, shape))

    def placed(self, body: int, placement: Array) -> Array:
        configuration = self.result.configuration
        return self.of_configuration(batch_first(configuration.frames.matrices(body, placement), configuration.shape), 2)

    @cached_property
    def platform_twist(self) -> Array:
        return self.by_contribution(self.result.contributions)

    def link_twist(self, link: str) -> Array | None:
        contributions = self.result.link_contributions.get(link)
        return None if contributions is None else self.by_contribution(contributions)

    def tension(self, name: str) -> Array:
        return self.take(self.result.spring_forces[name])

    def beam_twists(self, name: str) -> Array:
        return self.by_contribution(self.result.beam_contributions[name])

    def interface_twists(self, name: str) -> Array:
        return self.by_contribution(self.result.interface_contributions[name])

    def squares_and_gravity(self, name: str) -> tuple[Array, Array]:
        (squares, gravity), topology, names = super().squares_and_gravity(name), self.robot.topology, self.contribution_names
        chains = [(limb.name, limb) for limb in topology.limbs]
        chains += [("platform_weight", limb) for limb in topology.hanging if limb.on_platform]
        edges = [(weight, (*limb.edges, *limb.branches)) for weight, limb in chains] + [
            ("platform_weight", topology.platform.edges)
        ]
        weights = [weight for weight, along in edges if name in map(topology.part_of, along)]
        is_platform = self.robot.description.flexible[name].link == self.robot.description.platform
        weight = (*weights, "platform_weight" if is_platform else "base_weight")[0]
        weight = of_deformation(weight) if of_deformation(weight) in names else weight
        if weight in names:
            gravity[:, names.index(weight)] = self.take(self.result.gravity)
        return squares, gravity

    def beam_line(self, name: str) -> tuple[Array, Array]:
        axes, points = self.result.centre_lines[name]
        return self.take(axes), self.take(points)


def labels_of(result: Result) -> tuple[str, ...]:
    """Return the labels of the contributions: their names, or if a limb's weight is divided in two contributions, of both."""
    labels: dict[str, str] = {}
    for limb in result.limbs:
        if of_deformation(limb) in result.contributions:
            labels |= {limb: f"{limb}: attached", of_deformation(limb): f"{limb}: deformation"}
    return tuple(labels.get(name, name) for name in result.contributions)


def moved_wrench(wrench: Array, shift: Array) -> Array:
    """Return the wrench (F, 6) about a point displaced by ``shift`` (F, 3) [m] from the reference point of ``wrench``."""
    return move("wrench", wrench, shift, components_last=True)


def serpentine(shape: tuple[int, ...]) -> NDArray[np.intp]:
    """Return the flat indices of a batch row by row, with every second row reversed: successive poses are neighbours."""
    order = np.arange(int(np.prod(shape)), dtype=np.intp).reshape(shape or (1,))
    while order.ndim > 1:
        rows = order.reshape(-1, *order.shape[-2:]).copy()
        rows[:, 1::2] = rows[:, 1::2, ::-1]
        order = rows.reshape(*order.shape[:-2], -1)
    return order


def place_of(shape: tuple[int, ...], pose: int | tuple[int, ...]) -> int:
    """Return the index of a pose in the flattened batch; negative numbers in ``pose`` count from the end."""
    index, counts = np.atleast_1d(np.asanyarray(pose)), np.array(shape, dtype=int)
    if index.dtype.kind not in "iu" or index.shape != counts.shape or np.any(index < -counts) or np.any(index >= counts):
        right = f"an index into the result's batch of shape {shape}" if shape else "left out, as the result is of one pose"
        raise ArgumentError(f"pose is {pose!r}; it must be {right}")
    return int(np.ravel_multi_index(tuple(index % counts), shape))


def _nothing_to_show(result: Result, order: NDArray[np.intp]) -> str:
    names = {int(status): status.name for status in Status}
    statuses = sorted({names[int(code)] for code in np.ravel(result.status)[order]})
    if not statuses:
        return "the result has no poses, so there is nothing to show"
    what = "the pose" if len(order) == 1 else "no pose of the batch"
    verb = "could not be analysed" if len(order) == 1 else "could be analysed"
    return f"{what} {verb} (status {', '.join(statuses)}), so there is nothing to show"


def loads_on_links(poses: ShownPoses, kinds: Collection[str]) -> Iterator[tuple[str, str, Array, Array]]:
    """Yield (contribution, name of the link or beam, point (F, 3) [m], wrench (F, 6) about o [N, N·m]) for loads on links.

    ``kinds`` are some of "load" and "spring".
    """
    solutions, shape, take = poses.result.solutions, poses.result.shape, poses.take
    for k, applied in enumerate(solutions[0].applied):
        if applied.load.kind not in kinds:
            continue
        loads = [s.applied[k].load for s in solutions]
        nothing = [np.zeros((6, s.o.shape[1])) for s in solutions]
        for place in dict.fromkeys(place for load in loads for place in load.wrenches):  # a place need not be loaded at all poses
            point = [load.points.get(place, none[:3]) for load, none in zip(loads, nothing, strict=True)]
            wrench = [load.wrenches.get(place, none) for load, none in zip(loads, nothing, strict=True)]
            both = [take(np.concatenate(parts, axis=-1).T.reshape(*shape, -1)) for parts in (point, wrench)]
            yield applied.load.name, place, both[0], both[1]


def about_point(wrench: Array, point: Array, o: Array, size: float) -> Array:
    """Return wrenches (F, 6), given about o, about points (F, 3) instead; rounding errors of moments are set to zero."""
    wrenches = moved_wrench(wrench, point - o)
    wrenches[:, 3:] = np.where(
        np.abs(wrenches[:, 3:]) > 1e-9 * size * np.abs(wrench[:, :3]).max(initial=0.0), wrenches[:, 3:], 0.0
    )
    return wrenches
