"""Arrows of external and internal forces and couples.

Every arrow is attached to a station, a coordinate system that moves with the robot. A contribution is due to one load or weight.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from kinetostatics.math.arrays import Array, zeros_for
from kinetostatics.mechanism.limbs import Limb
from kinetostatics.results.parts import LimbResult
from kinetostatics.viewer.description import Arrow, Stations
from kinetostatics.viewer.drawn_parts import DrawnJoint, DrawnSpring, marker_radius
from kinetostatics.viewer.drawn_poses import ShownPoses, about_point, loads_on_links, moved, moved_wrench
from kinetostatics.viewer.shapes import crossed, frames_along


class Wrenches:
    """All arrows of a scene, at F poses.

    Arrays (F, K + 1, …) of forces and moments contain K contributions, each of which the page multiplies by the value of a
    slider, and last the remainder, which the page does not multiply.
    """

    def __init__(
        self,
        poses: ShownPoses,
        stations: Stations,
        joints: Sequence[DrawnJoint],
        springs: Sequence[DrawnSpring],
        at: dict[str, int],
        size: float,
    ) -> None:
        self.poses, self.stations, self.joints, self.springs, self.at, self.size = poses, stations, joints, springs, at, size
        self.result, self.robot = poses.result, poses.result.robot
        self.gravity, self.load = poses.take(self.result.gravity), poses.take(self.result.load)

    def arrows(self) -> Iterator[Arrow]:
        yield from self._external()
        yield from self._springs()
        for limb in self.robot.topology.limbs:
            yield from self._limb(limb)
        yield from self._weights()
        yield from self._base_reaction()
        yield from self._actuators()

    def _external(self) -> Iterator[Arrow]:
        yield from self._pair("external load", "load", self.at["o"], self._only("load", self.load), "tip")
        for name, place, point, wrench in loads_on_links(self.poses, ("load",)):
            link = self.robot.topology.link_of(place)
            at = self.stations.add(point, self.poses.twist_at(link, point))
            acting = self._only(name, about_point(wrench, point, self.poses.o, self.size))
            yield from self._pair("external load", name, at, acting, "tip")

    def _springs(self) -> Iterator[Arrow]:
        """Yield the two forces of each spring on its links: into a spring that pulls, away from one that pushes."""
        for spring in self.springs:
            force = self._only(f"spring {spring.description.name}", spring.tension[:, None] * spring.direction)
            for link, sign, end, twist in zip(spring.links, (1, -1), spring.ends, spring.twists, strict=True):
                name, at = f"{spring.description.name} on {link}", self.stations.add(end, twist)
                yield Arrow("spring forces", name, name, "force", at, sign * force)

    def _only(self, contribution: str, wrench: Array) -> Array:
        """Return parts (F, K + 1, …), zero but one: contribution ``source``, or else the remainder, is ``wrench`` (F, …)."""
        contribution_names = self.poses.contribution_names
        parts = zeros_for((len(wrench), len(contribution_names) + 1, *wrench.shape[1:]), wrench)
        parts[:, contribution_names.index(contribution) if contribution in contribution_names else -1] = wrench
        return parts

    def _limb(self, limb: Limb) -> Iterator[Arrow]:
        limb_result, take = self.result.limbs[limb.name], self.poses.take
        if limb_result.is_network:
            yield from self._network(limb_result)
            return
        joints = self._joints_of(limb)
        ends = [joint.centre for joint in joints]
        outward = ends[0] - ends[-1] if len(ends) > 1 else np.zeros_like(self.poses.o)
        intensities = self.poses.parts(limb_result.contributions)
        attached = self.poses.parts(limb_result.attached_contributions)
        for group, labels, wrenches, parts in (
            ("constraint", limb_result.labels, limb_result.constraint_wrenches, intensities),
            ("attached wrenches", limb_result.attached_labels, limb_result.attached_wrenches, attached),
        ):
            units = np.nan_to_num(take(wrenches))
            for n, label in enumerate(labels):
                yield from self._screw(group, limb.name, label, joints, units[:, :, n], parts[:, :, n], outward)

    def _network(self, limb: LimbResult) -> Iterator[Arrow]:
        """Yield the wrenches at the platform joints and the axial forces of the beams of a limb that is not serial."""
        poses, result, table = self.poses, self.result, self.robot.statics.joint_table
        for name in limb.platform_joints:
            k = [table.names.index(name)]
            centres = np.concatenate(
                [s.frames.points(table.centre_body[k], table.centre[:, k])[:, 0] for s in result.solutions], -1
            )
            centre = poses.take(centres.T.reshape(*result.shape, 3))
            at = self.stations.add(centre, moved(poses.platform_twist, centre - poses.o))
            parts = -poses.parts(result.joint_contributions[name])
            yield from self._pair("joints of networks", f"{limb.name}: {name}", at, parts, "tail")
        for name in limb.beams:
            axes, points = poses.beam_line(name)
            forces = poses.parts(result.axial_contributions[name])
            axis = axes[:, :, 0]
            at = self.stations.add(points[:, -1], poses.beam_twists(name)[:, :, -1])
            yield Arrow(
                "axial forces in networks", f"{limb.name}: {name}", name, "force", at, forces[..., None] * axis[:, None],
                positive=axis, anchor=axis,
            )  # fmt: skip

    def _joints_of(self, limb: Limb) -> list[DrawnJoint]:
        """Return a limb's joints outside telescopic beams: platform joints, then inner joints, then base joints."""
        links, topology = set(limb.links), self.robot.topology
        names = {edge.joint for edge in limb.edges}
        placed = [joint for joint in self.joints if joint.beam is None]
        joints = [joint for joint in placed if joint.links & links or names & set(joint.joints)]
        ends = (set(topology.platform.links), set(topology.base.links))
        return sorted(joints, key=lambda joint: bool(joint.links & ends[1]) - bool(joint.links & ends[0]))

    def _screw(
        self, group: str, limb: str, label: str, joints: list[DrawnJoint], unit: Array, parts: Array, outward: Array
    ) -> Iterator[Arrow]:
        """Yield ``unit`` (F, 6), about o, times ``parts`` (F, K + 1), as a force on its line of action and a couple."""
        name, short = f"{limb}: {label}", f"{limb} {label.split(' at ')[0]}"
        forces, couples = (group, group) if group != "constraint" else ("constraint forces", "constraint couples")
        force, moment = unit[:, :3], unit[:, 3:]
        square = np.sum(force**2, axis=-1)
        at = self.at[joints[0].name] if joints else self.at["o"]
        if square.max() > 1e-12:
            foot = self.poses.o + crossed(force, moment) / np.maximum(square, 1e-12)[:, None]
            arms = crossed(np.array([joint.centre - foot for joint in joints]).reshape(-1, *foot.shape), force[None])
            gaps = np.max(np.sqrt(np.sum(arms**2, axis=-1) / np.maximum(square, 1e-24)), axis=-1)
            close = [joint for joint, gap in zip(joints, gaps, strict=True) if gap < 1e-4 * self.size]
            if close:
                at = self.at[close[0].name]
            else:
                along = np.sum((joints[0].centre - foot) * force, axis=-1) if joints else np.zeros(len(foot))
                point = foot + force * (along / np.maximum(square, 1e-12))[:, None]
                at = self.stations.add(point, moved(self.poses.platform_twist, point - self.poses.o))
            yield Arrow(forces, name, short, "force", at, parts[..., None] * force[:, None], positive=force, anchor=outward)
            moment = force * (np.sum(force * moment, axis=-1) / np.maximum(square, 1e-12))[:, None]
        if np.abs(moment).max() > 1e-6 * self.size:
            yield Arrow(couples, name, short, "moment", at, parts[..., None] * moment[:, None], positive=moment)

    def _pair(self, group: str, name: str, at: int, wrench: Array, anchor: str) -> Iterator[Arrow]:
        """Yield force and couple of a wrench (F, K + 1, 6) about the origin of station ``at``, each unless zero at all poses."""
        for kind, part in (("force", wrench[..., :3]), ("moment", wrench[..., 3:])):
            if np.any(part != 0):
                title = f"{name} {'force' if kind == 'force' else 'couple'}"
                yield Arrow(group, title, title.replace("_", " "), kind, at, part, anchor=anchor)

    @cached_property
    def _weights_by_contribution(self) -> list[tuple[str, str, Array, Array]]:
        """(name, contribution, centre of mass (F, 3) [m], weight (F, 3) [N]) of each link and beam."""
        weights, solutions, take = self.robot.weights, self.result.solutions, self.poses.take
        masses = np.concatenate([weights.masses(s.frames) for s in solutions], axis=-1)
        centres = np.concatenate([weights.centres(s.frames) for s in solutions], axis=-1)
        shape, weights_by_contribution = self.result.shape, []
        for k, (name, owner) in enumerate(zip(weights.names, weights.owner, strict=True)):
            force = take(masses[k].reshape(shape))[:, None] * self.gravity
            own = f"{owner}_weight"
            contribution = own if own in self.robot.statics.contributions else owner
            weights_by_contribution.append((name, contribution, take(centres[:, k].T.reshape(*shape, 3)), force))
        return weights_by_contribution

    def _weights(self) -> Iterator[Arrow]:
        for name, contribution, centre, force in self._weights_by_contribution:
            label = name.removeprefix("beam:")
            if name != label and label in self.robot.description.beams:
                at = self.at[f"middle of {label}"]
            else:
                link = name if name == label else self.robot.description.flexible[label].link
                at = self.stations.add(centre, self.poses.twist_at(link, centre))
            if np.any(force != 0):
                yield Arrow("weights", label, f"weight of {label}", "force", at, self._only(contribution, force))

    def _base_reaction(self) -> Iterator[Arrow]:
        """Yield the wrench of the ground, about the base link's origin: minus the sum of loads, weights and spring forces."""
        base = self.poses.frame(self.robot.description.base)[:, :3, 3]
        total = np.nan_to_num(self.poses.take(self.result.base_wrench))
        parts = -self._only("load", moved_wrench(self.load, base - self.poses.o))
        for _, contribution, centre, force in self._weights_by_contribution:
            parts -= self._only(contribution, np.concatenate([force, crossed(centre - base, force)], axis=-1))
        for name, _, _, wrench in loads_on_links(self.poses, ("load", "spring")):
            parts -= self._only(name, moved_wrench(wrench, base - self.poses.o))
        parts[:, -1] = total - parts[:, :-1].sum(axis=1)
        tiny = 1e-9 * np.abs(total).max(initial=0.0)
        parts = np.where(np.abs(parts) < tiny, 0.0, parts)
        yield from self._pair("base reaction", "base_wrench", self.at["base"], parts, "tip")

    def _actuators(self) -> Iterator[Arrow]:
        for joint in self.joints:
            name = joint.name
            if joint.axis is None or name not in self.result.actuator_contributions:  # a follower has no force
                continue
            kind = "force" if self.robot.mechanism.connections[name].type.is_slide else "moment"
            parts = self.poses.parts(self.result.actuator_contributions[name])
            # remainder: weight of parts attached to the base
            parts[:, -1] = np.nan_to_num(self.poses.take(self.result.actuator_forces[name])) - parts.sum(axis=1)
            at, offset = self._actuator_place(joint)
            vector = parts[..., None] * joint.axis[:, None]
            yield Arrow("actuator forces", name, name, kind, at, vector, offset, joint.axis)

    def _actuator_place(self, joint: DrawnJoint) -> tuple[int, tuple[float, float, float]]:
        """Return station and offset [m] of an actuator's arrow, which lies beside a telescopic beam or else at the joint."""
        if joint.beam is None:
            return self.at[joint.name], (0.0, 0.0, 0.0)
        _, points = self.poses.beam_line(joint.beam)
        twists = self.poses.beam_twists(joint.beam)
        middle = points.shape[1] // 2
        assert joint.axis is not None
        frame = frames_along(joint.axis, points[:, middle])
        side = 2.0 * marker_radius(self.poses, joint, self.size)
        return self.stations.add(frame, twists[:, :, middle]), (side, 0.0, 0.0)
