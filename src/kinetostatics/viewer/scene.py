"""The scene of a result: rigid links, bent beams, joints, arrows and frames."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from numbers import Real

import numpy as np
from numpy.typing import NDArray

from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.elements.link import LinkSurface
from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array, zeros_for
from kinetostatics.results.result import Result
from kinetostatics.viewer.arrows import Wrenches
from kinetostatics.viewer.cards import NO_FACTS, Cards, facts_without_loads, find_facts
from kinetostatics.viewer.description import COLOURS, FREE_MOTION, Arrow, Mesh, Scene, Stations
from kinetostatics.viewer.drawn_parts import find_joints, find_masses_at_points, find_springs, marker_radius, radius_of_ball
from kinetostatics.viewer.drawn_poses import ShownPoses, blended
from kinetostatics.viewer.shapes import Surface, ball, coil, frames_along, joined, pin, places_along_coil, plate, stick, swept
from kinetostatics.viewer.single_poses import ModePoses, SinglePose, UnloadedPose
from kinetostatics.viewer.visuals import LinkVisual, link_visuals, sharpened

#: Initially drawn largest displacement, as a part of the robot's size, and largest rotation [rad].
SHOWN_MOTION, SHOWN_TURN = 0.1, 0.3
#: Forces below this part of the largest one are rounding errors.
ROUNDING = 1e-9
#: Colour of beams and of links without visuals where no colours show deflections.
STANDING = "#8693a6"
JOINT_COLOUR, ACTUATOR_COLOUR, MASS_COLOUR = "#66717f", "#b8482a", "#4b5563"
#: Radius of a spring's coil and of its wire, as parts of the robot's size; largest radius of the coil, as a part of the spring's
#: length.
COIL, WIRE, SLENDER = 0.024, 0.0032, 0.1
#: Turns of a coil and points per turn, by :attr:`DrawnPoses.step`: fewer on long paths, to keep pages small.
TURNS = {1: (10, 7), 2: (8, 5), 5: (6, 4)}
#: Parts of the longest side of a flexible link that move as rigid bodies; on paths of F poses fewer, by the fourth root of F.
CELLS = 24


def describe_scene(
    result: Result | SinglePose,
    title: str | None = None,
    visuals: Mapping[str, LinkVisual] | None = None,
    *,
    pose: int | tuple[int, ...] | None = None,
    exaggeration: float | None = None,
    every: int = 1,
) -> Scene:
    """Return the scene of one pose, or of a batch of poses as a path: row by row, every second row backwards.

    Args:
        result, title, pose, exaggeration: see :func:`kinetostatics.show`.
        visuals: visuals of the links, if already read.
        every: n, to show every n-th pose of a path.

    Raises:
        ArgumentError: no pose could be analysed, there are more than 1000, or ``pose`` or ``exaggeration`` is invalid.
    """
    if exaggeration is not None and not (isinstance(exaggeration, Real) and 0 < exaggeration < math.inf):
        raise ArgumentError(f"exaggeration is {exaggeration!r}; it must be a positive number")
    poses = result if isinstance(result, SinglePose) else ShownPoses(result, pose, every)
    scene = scene_of(poses, link_visuals(poses.robot.description) if visuals is None else visuals, title)
    return scene if exaggeration is None else replace(scene, exaggeration=float(exaggeration))


def scene_of(
    poses: ShownPoses | SinglePose, visuals: Mapping[str, LinkVisual], title: str | None = None, size: float | None = None
) -> Scene:
    """Return the scene of poses; see :func:`describe_scene`. ``size`` is the robot's size [m], if it is not to be computed."""
    return _SceneBuilder(poses, visuals, size).build(title)


def meshes_of(result: Result) -> tuple[list[Mesh], float]:
    """Return the meshes of the scene of a single pose, and the size of the robot [m]."""
    builder = _SceneBuilder(ShownPoses(result), link_visuals(result.robot.description), None)
    builder.draw()
    return builder.meshes, builder.size


class _SceneBuilder:
    def __init__(self, poses: ShownPoses | SinglePose, visuals: Mapping[str, LinkVisual], size: float | None) -> None:
        self.poses, self.robot, self.visuals = poses, poses.robot, visuals
        self.stations = Stations(self.poses.count, self.poses.labels)
        self.joints = find_joints(self.poses)
        self.springs = find_springs(self.poses)
        self.masses = find_masses_at_points(self.poses, visuals)
        fixed = [joint for joint in self.robot.description.joints.values() if JOINT_TYPES[joint.type].is_fixed]
        self.holder = {joint.child: joint.parent for joint in fixed}
        self.flexible = {part.link: name for name, part in self.robot.description.flexible.items()}
        self.size = self._size() if size is None else size
        elastic = self.robot.description.elastic_links or self.robot.description.joint_stiffness
        #: whether links have their own colours
        self.plain = isinstance(poses, UnloadedPose) or not (elastic or "assembly_errors" in poses.contribution_names)
        self.meshes: list[Mesh] = []
        self.at: dict[str, int] = {}

    def draw(self) -> None:
        """Draw all parts: add their stations and meshes."""
        self.at["o"] = self.stations.add(self.poses.platform_frame, self.poses.platform_twist)
        self.at["base"] = self.stations.add(self.poses.frame(self.robot.description.base))
        self._links()
        self._beams()
        self._joint_markers()
        self._springs()
        self._masses_at_points()
        if self.plain:
            self.meshes = [self._without_deflections(mesh) for mesh in self.meshes]

    def build(self, title: str | None) -> Scene:
        poses, stations = self.poses, self.stations
        self.draw()
        arrows: Iterable[Arrow] = ()
        if isinstance(poses, ShownPoses):
            arrows = Wrenches(poses, stations, self.joints, self.springs, self.at, self.size).arrows()
        elif not isinstance(poses, ModePoses):
            arrows = self._free_motions(poses)
        visible_arrows = self._without_rounding(arrows)  # arrows add stations
        if isinstance(poses, ShownPoses):
            facts = find_facts(poses, stations.all_twists, self.size) if poses.has_texts else NO_FACTS
        else:
            facts = facts_without_loads(poses)
        scene = Scene(
            title or self.robot.name, stations, self.size, self._exaggeration(), self.at["o"], facts, self.meshes, visible_arrows,
            [("base", self.at["base"], "base"), ("platform", self.at["o"], "o")], self._limb_labels(),
        )  # fmt: skip
        if isinstance(poses, SinglePose):
            scene.unloaded = True
            scene.notes = [*poses.notes, *self._decimation_notes()]
            if isinstance(poses, ModePoses):
                scene.modes = poses.drawn
                scene.exaggeration = 1.0
                visible = [self._visible_factor(twists) for twists in np.moveaxis(stations.all_twists, 2, 0)]
                stations.twists = [twists * np.array(visible)[:, None] for twists in stations.twists]
        else:
            first = {mesh.path: int(np.min(mesh.station)) for mesh in self.meshes if "Deformed" in mesh.roots}
            scene.notes = [*poses.result.warnings, *self._decimation_notes()] if poses.has_texts else []
            scene.cards = Cards(poses, self.joints, self.springs).all(first)
        return scene

    def _without_deflections(self, mesh: Mesh) -> Mesh:
        """Return a mesh in one colour instead of colours of deflections.

        If the platform has no free motion, nothing moves, and the mesh is drawn only once: under ``Deformed``.
        """
        roots = mesh.roots
        if not self.poses.contribution_names:
            roots = tuple(dict.fromkeys(name.replace("Rest", "Deformed") for name in roots))
        return replace(mesh, roots=roots, colour=STANDING if mesh.by_deflection else mesh.colour)

    def _free_motions(self, poses: SinglePose) -> Iterator[Arrow]:
        """Yield two arrows at o for each free motion of the platform: its translation and its rotation."""
        for k, name in enumerate(poses.contribution_names):
            for kind, motion, part in (("force", "translation", slice(0, 3)), ("moment", "rotation", slice(3, 6))):
                vector = np.zeros((1, len(poses.contribution_names) + 1, 3))
                vector[:, k] = poses.platform_twist[:, k, part]
                yield Arrow(FREE_MOTION, f"{name}: {motion}", name, kind, self.at["o"], vector)

    def _size(self) -> float:
        points = [self.poses.o, self.poses.frame(self.robot.description.base)[:, :3, 3]]
        points += [joint.centre for joint in self.joints]
        points += [end for spring in self.springs for end in spring.ends]
        points += [self.poses.beam_line(name)[1].reshape(-1, 3) for name in self.robot.description.beams]
        cloud = np.concatenate(points)
        return float(np.linalg.norm(cloud.max(axis=0) - cloud.min(axis=0))) or 1.0

    def _without_rounding(self, arrows: Iterable[Arrow]) -> list[Arrow]:
        """Return the arrows whose force exceeds rounding errors of the largest force; moments are divided by the size."""
        forces = [(arrow, arrow.size / (1.0 if arrow.kind == "force" else self.size)) for arrow in arrows]
        least = ROUNDING * max((force for _, force in forces), default=0.0)
        return [arrow for arrow, force in forces if force > least]

    def _exaggeration(self) -> float:
        factor = self._visible_factor(self.stations.all_twists.sum(axis=2))
        power = 10 ** math.floor(math.log10(factor))
        return max(step for step in (1, 1.5, 2, 3, 5, 7) if step * power <= factor * (1 + 1e-9)) * power

    def _visible_factor(self, twists: Array) -> float:
        """Return the exaggeration that makes twists (…, 6) clearly visible; 1 for zero twists."""
        parts = (SHOWN_MOTION * self.size, twists[..., :3]), (SHOWN_TURN, twists[..., 3:])
        factors = [limit / most for limit, part in parts if (most := float(np.linalg.norm(part, axis=-1).max())) > 0]
        return min(factors, default=1.0)

    def _links(self) -> None:
        topology, rigid, unloaded = self.robot.topology, self.poses.rigid, isinstance(self.poses, UnloadedPose)
        of_beams = {beam.link for beam in self.robot.description.beams.values()}
        for span in topology.spans.values():
            for name in span.spanned:
                connection = self.robot.mechanism.connections[name]
                of_beams.update({connection.predecessor, connection.successor})
        # links attached to base or platform by a joint or beam move on their own
        bare = {
            name: set(part.links) - set(topology.carried_by) - set(self.flexible)
            for name, part in (("base", topology.base), ("platform", topology.platform))
        }
        of_beams -= bare["base"] | bare["platform"]
        for link in self.robot.description.links:
            visual = self.visuals.get(link)
            if link in of_beams:
                if visual is not None:
                    self._link(link, visual, f"beams/{link}", ("Rest", "Deformed") if unloaded else ("Rest",))
                continue
            roots: tuple[str, ...] = ("Base",) if link in bare["base"] else ("Rest", "Deformed")
            folder = link if any(link in links for links in bare.values()) else f"links/{link}"
            if link in self.flexible and (recovered := self.poses.surface(self.flexible[link])) is not None:
                self._recovered(self.flexible[link], recovered, folder, roots)
            elif visual is not None:
                self._link(link, visual, folder, roots)
            elif (link in rigid or link in self.flexible) and not any(link in links for links in bare.values()):
                self._skeleton(link, {link}, folder, roots)
        name = self.robot.description.platform
        if name not in self.flexible and not any(link in self.visuals for link in bare["platform"]):
            self._skeleton(name, bare["platform"], name, ("Rest", "Deformed"))

    def _link_station(self, link: str, roots: tuple[str, ...]) -> int:
        frame = self.poses.frame(link)
        return self.stations.add(frame, self.poses.twist_at(link, frame[:, :3, 3]) if "Deformed" in roots else None)

    def _link(self, link: str, visual: LinkVisual, path: str, roots: tuple[str, ...]) -> None:
        colour: str | Array = "deflection"
        if roots == ("Base",):
            colour = 0.54 + 0.27 * visual.colours  # pale, to set it off from the colours of deflection
        elif self.plain:
            colour = visual.colours
        self.meshes.append(Mesh(path, *self._attached(link, visual.surface, roots), roots, colour))

    def _recovered(self, name: str, surface: LinkSurface, path: str, roots: tuple[str, ...]) -> None:
        """Draw the surface of an elastic link; further stations at its start carry three internal coordinates each, in metres."""

        def carried(values: Array) -> Array:
            padded = np.pad(values, [(0, 0)] * (values.ndim - 1) + [(0, -values.shape[-1] % 3)])
            threes = padded.reshape(*values.shape[:-1], -1, 3)
            return np.concatenate([threes, np.zeros_like(threes)], axis=-1)

        frame, ends = self.poses.frame(self.robot.description.flexible[name].link), self.poses.interfaces(name)
        n = surface.recovery.shape[2] - surface.vibration.inner
        most = np.linalg.norm(surface.recovery[..., n:], axis=1).max(axis=0)
        recovery, axes = carried(surface.recovery[..., n:] / most), np.swapaxes(frame[:, None, :3, :3], -1, -2)
        inner = carried(self.poses.inner_coordinates(name, surface) * most)
        inner[..., :3] = inner[..., :3] @ axes
        placements = np.repeat(frame[:, None], ends.shape[1] + inner.shape[2], axis=1)
        placements[..., :3, 3] = np.concatenate([ends, np.repeat(ends[:, :1], inner.shape[2], axis=1)], axis=1)
        first = self.stations.add_all(placements, np.concatenate([self.poses.interface_twists(name), inner], axis=2))
        recovery = np.concatenate([surface.recovery[..., :n], recovery.reshape(len(recovery), 3, -1)], axis=2)
        drawn, of_point = sharpened(Surface(surface.points, surface.triangles))
        moved = Surface(drawn.vertices - frame[0, :3, :3].T @ (ends[0, 0] - frame[0, :3, 3]), drawn.faces)
        self.meshes.append(Mesh(path, moved, np.full(len(of_point), first), roots, recovery=recovery[of_point]))

    def _attached(self, link: str, surface: Surface, roots: tuple[str, ...]) -> tuple[Surface, int | NDArray[np.int64]]:
        """Return the surface of a link in the axes of its station, or of its stations if it is flexible, and their indices."""
        if link not in self.flexible:
            return surface, self._link_station(link, roots)
        cells = max(2, round(CELLS / self.poses.count**0.25)) / float(np.ptp(surface.vertices, axis=0).max())
        places = np.round(np.round(surface.vertices * cells, 6))  # rounding errors do not change a cell
        _, some, cell = np.unique(places, axis=0, return_index=True, return_inverse=True)
        cell, centres = cell.ravel(), surface.vertices[some]
        placements, name = np.repeat(self.poses.frame(link)[:, None], len(centres), axis=1), self.flexible[link]
        placements[..., :3, 3] += (placements[..., :3, :3] @ centres[..., None])[..., 0]
        twists = blended(placements[..., :3, 3], self.poses.interfaces(name), self.poses.interface_twists(name))
        return Surface(surface.vertices - centres[cell], surface.faces), self.stations.add_all(placements, twists) + cell

    def _skeleton(self, link: str, links: set[str], path: str, roots: tuple[str, ...]) -> None:
        """Draw a link without visuals: sticks from its centre to joints, springs and point masses; for the platform a plate."""
        inverse = np.linalg.inv(self.poses.frame(link)[0])
        near = [joint for joint in self.joints if joint.links & links]
        points = [joint.centre[0] for joint in near]
        points += [end[0] for spring in self.springs for end, at in zip(spring.ends, spring.links, strict=True) if at in links]
        points += [centre[0] for name, centre in self.masses.items() if links & {name, self.holder.get(name, name)}]
        is_platform = self.robot.description.platform in links
        if is_platform:
            points.append(self.poses.o[0])
        if link in self.flexible:
            points = list(self.poses.interfaces(self.flexible[link])[0])
        local = np.array([inverse[:3, :3] @ point + inverse[:3, 3] for point in points], dtype=np.float64).reshape(-1, 3)
        if len(local) < 2:
            return
        middle = local.mean(axis=0)
        radius = 0.5 * float(np.mean([marker_radius(self.poses, joint, self.size) for joint in near or self.joints]))
        if link in self.flexible:  # independent of the pose, as its cells are stations
            radius = 0.04 * float(np.linalg.norm(local - middle, axis=1).max())
        pieces = CELLS // 2 if link in self.flexible else 1
        if is_platform:
            middle = local[:-1].mean(axis=0)
        ends, thickness = (
            (local[-1:], radius / 3) if is_platform else (local, radius)
        )  # the plate hides a stick to o in its plane
        sticks = [stick(middle, p, thickness, pieces) for p in ends if np.linalg.norm(p - middle) > 1e-6 * self.size]
        # the hub is there also where all points coincide: stations of a live page are the same at all poses
        hub = plate(local[:-1], 1.5 * radius) if is_platform else Surface(ball(radius).vertices + middle, ball(radius).faces)
        self.meshes.append(Mesh(path, *self._attached(link, joined([*sticks, hub]), roots), roots))

    def _beams(self) -> None:
        for name, beam in self.robot.description.beams.items():
            step = self.poses.step
            axes, points = self.poses.beam_line(name)
            points = points[:, ::step]
            twists = self.poses.beam_twists(name)[:, :, ::step]
            count = points.shape[1]
            placements = zeros_for((self.poses.count, count, 4, 4), points)
            placements[..., :3, :3], placements[..., :3, 3], placements[..., 3, 3] = axes[:, None], points, 1
            first = self.stations.add_all(placements, twists)
            self.at[f"middle of {name}"] = first + count // 2
            self.at[f"label of {name}"] = first + count // 3  # off the middle, the place of an actuator's arrow
            roots = ("Deformed",) if beam.link in self.visuals else ("Rest", "Deformed")
            if isinstance(self.poses, UnloadedPose) and beam.link in self.visuals:
                continue
            surface, at = swept(self.poses.section(name), count)
            self.meshes.append(Mesh(f"beams/{name}", surface, first + at, roots))

    def _joint_markers(self) -> None:
        for joint in self.joints:
            if joint.beam is not None:  # a joint inside a telescopic beam has no defined position
                continue
            placement = joint.centre if joint.axis is None else frames_along(joint.axis, joint.centre)
            self.at[joint.name] = self.stations.add(placement, joint.twist)
            r = marker_radius(self.poses, joint, self.size)
            shape = ball(1.3 * r) if joint.axis is None else pin(0.6 * r, 3.2 * r)
            colour = ACTUATOR_COLOUR if joint.actuated else JOINT_COLOUR
            self.meshes.append(Mesh(f"joints/{joint.name}", shape, self.at[joint.name], ("Deformed",), colour))

    def _springs(self) -> None:
        """Draw springs as coils, whose vertices move with points on the line between the spring's ends."""
        turns, points = TURNS[self.poses.step]
        along = places_along_coil(turns, points)
        for spring in self.springs:
            frames = spring.frames()
            length = float(spring.length[0]) or self.size
            radius = min(COIL * self.size, SLENDER * length)
            (start, end), shifts = spring.ends, spring.twists[1] - spring.twists[0]
            placements = np.repeat(frames[:, None], len(along), axis=1)
            placements[..., :3, 3] = (1 - along[:, None]) * start[:, None] + along[:, None] * end[:, None]
            twists = zeros_for((*shifts.shape[:2], len(along), 6), shifts)
            twists[..., :3] = spring.twists[0][:, :, None, :3] + along[:, None] * shifts[:, :, None, :3]
            first = self.stations.add_all(placements, twists)
            surface, at = coil(length, radius, min(WIRE * self.size, 0.2 * radius), turns, points)
            path, colour = f"springs/{spring.description.name}", COLOURS["spring forces"]
            self.meshes.append(Mesh(path, surface, first + at, ("Rest", "Deformed"), colour))

    def _masses_at_points(self) -> None:
        for name, centre in self.masses.items():
            station = self.stations.add(centre, self.poses.twist_at(name, centre))
            shape = ball(radius_of_ball(self.robot.description.links[name].mass, self.size))
            self.meshes.append(Mesh(f"masses/{name}", shape, station, ("Rest", "Deformed"), MASS_COLOUR))

    def _decimation_notes(self) -> list[str]:
        read = sum(visual.read for visual in self.visuals.values())
        drawn = sum(len(visual.surface.faces) for visual in self.visuals.values())
        return [f"meshes of the links: drawn with {drawn} of their {read} triangles"] if drawn < read else []

    def _limb_labels(self) -> list[tuple[str, int, str]]:
        labels = []
        for limb in self.robot.topology.limbs:
            beams = [edge.span for edge in (*limb.edges, *limb.branches) if edge.span in self.robot.description.beams]
            if beams:
                labels.append((f"limbs/{limb.name}", self.at[f"label of {beams[0]}"], limb.name))
        return labels
