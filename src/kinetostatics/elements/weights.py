"""Weights of a robot: masses of links without beams (*rigid links*) and of beams, their centres, their wrenches under gravity.

Rigid links have the inertias of Pinocchio's model. Pinocchio computes the wrenches at single poses, NumPy the wrenches at batches
of poses.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kinetostatics.elements.link import ElasticLink, no_length_text
from kinetostatics.exceptions import RobotFileError, StaticsError
from kinetostatics.math.arrays import Array, empty_for
from kinetostatics.math.linalg import semidefinite
from kinetostatics.math.screws import wrench_of_force
from kinetostatics.mechanism.limbs import Edge, Topology, carries
from kinetostatics.mechanism.mechanism import Mechanism
from kinetostatics.mechanism.tree import Frames

if TYPE_CHECKING:
    import pinocchio as pin

#: Mass of a link, relative to that of its body, that counts as zero (rounding).
_NEGLIGIBLE = 1e-14


class Weights:
    """The W weights of a robot.

    Attributes:
        names: (W) "LINK" for a rigid link, "beam:NAME" for a beam; weights of the limbs first, then of base and platform.
        owner: (W) limb of each weight, or ``base`` or ``platform``.
        inertias: ``pin.Inertia`` of every rigid link with weight, in the frame of its body.
    """

    NOT_RECORDED = ("inertias", "_known", "_moving")

    def __init__(self, mechanism: Mechanism, topology: Topology, links: Mapping[str, ElasticLink]) -> None:
        parts = [(limb.name, limb.weights) for limb in topology.limbs]
        parts += [("base", topology.base.weights), ("platform", topology.platform.weights)]
        self.names = [name for _, names in parts for name in names]
        self.owner = [owner for owner, names in parts for _ in names]
        self._number = {name: k for k, name in enumerate(self.names)}
        self._beam_of = {k: links[name.removeprefix("beam:")] for k, name in enumerate(self.names) if name.startswith("beam:")}
        rigid = [name for k, name in enumerate(self.names) if k not in self._beam_of]
        self._known: dict[int, tuple[int, pin.Inertia]] | None = None
        self._is_rigid = np.array([k not in self._beam_of for k in range(len(self.names))], dtype=bool)
        inertias = link_inertias(mechanism.model)
        self.inertias = {name: inertias[name] for name in rigid}
        for inertia in self.inertias.values():
            inertia.inertia = semidefinite(inertia.inertia)  # rounding errors of the file
        self._moving = [mechanism.description.links[name] for name in rigid if name not in topology.base.weights]
        self._mass = np.array([inertia.mass for inertia in self.inertias.values()])
        self._body = np.array([mechanism.body_of[name][0] for name in rigid], dtype=np.intp)
        self._centre = np.array([inertia.lever for inertia in self.inertias.values()]).reshape(-1, 3).T
        self._beams = list(self._beam_of.values())
        spans = [beam.span for beam in self._beams]
        self._ends = [
            (np.array([body for body, _ in row], dtype=np.intp), np.array([point for _, point in row]).reshape(-1, 3).T)
            for row in ([(s.start_body, s.start) for s in spans], [(s.end_body, s.end) for s in spans])
        ]
        own = [(number, beam.span.carrier, beam.centre) for number, beam in enumerate(self._beams) if beam.centre is not None]
        self._centred = np.array([number for number, _, _ in own], dtype=np.intp)
        self._beam_body = np.array([body for _, body, _ in own], dtype=np.intp)
        self._beam_centre = np.array([centre for _, _, centre in own]).reshape(-1, 3).T

    @property
    def impossible_inertias(self) -> list[RobotFileError]:
        """An error for each moving link with moments of inertia that no body has; statics does not use them."""
        moving = (link for link in self._moving if link.inertia.flaw)
        return [link.place.error(f"the <inertia> of link {link.name!r} is impossible: {link.inertia.flaw}") for link in moving]

    def check_inertias(self) -> None:
        """Raise the first of the :attr:`impossible_inertias`."""
        for error in self.impossible_inertias:
            raise error

    def masses(self, frames: Frames) -> Array:
        """(W, N) [kg]; masses of telescopic beams with a density depend on the pose."""
        result = empty_for((len(self.names), frames.position.shape[2]), frames.position, self._mass)
        result[self._is_rigid] = self._mass[:, None]
        if self._beams:
            result[~self._is_rigid] = np.array([beam.mass_at(frames) for beam in self._beams])
        return result

    def centres(self, frames: Frames) -> Array:
        """Centres of mass (3, W, N) [m], world axes."""
        result = empty_for((3, len(self.names), frames.position.shape[2]), frames.position)
        result[:, self._is_rigid] = frames.points(self._body, self._centre)
        if self._beams:
            start, end = (frames.points(bodies, points) for bodies, points in self._ends)
            middles = (start + end) / 2
            if self._centred.size:
                middles[:, self._centred] = frames.points(self._beam_body, self._beam_centre)
            result[:, ~self._is_rigid] = middles
        return result

    def wrenches(self, frames: Frames, o: Array, gravity: Array) -> Array:
        """Wrenches [m g; (c − o) × m g] (6, W, N) about ``o`` (3, N) under ``gravity`` g (3, N) [m/s²], centres c."""
        if o.shape[1] == 1 and frames.are_finite()[0]:  # Pinocchio rejects NaN
            return self._wrenches_of_one(frames, o[:, 0], gravity[:, 0])
        return self.wrenches_of_many(frames, o, gravity)

    def wrenches_of_many(self, frames: Frames, o: Array, gravity: Array) -> Array:
        """The result of :meth:`wrenches` for any number of poses, by NumPy."""
        force = self.masses(frames)[None] * gravity[:, None]
        return wrench_of_force(force, self.centres(frames) - o[:, None])

    def _wrenches_of_one(self, frames: Frames, o: Array, gravity: Array) -> Array:
        import pinocchio as pin

        wrenches = []
        acceleration = pin.Motion(gravity, np.zeros(3))
        for body, inertia in self._bodies_at(frames):
            placement = pin.SE3(frames.rotation[:, :, body, 0], frames.position[:, body, 0] - o)
            wrenches.append(placement.act(inertia * placement.actInv(acceleration)).vector)
        return np.array(wrenches).reshape(-1, 6).T[..., None]

    def _bodies_at(self, frames: Frames) -> list[tuple[int, pin.Inertia]]:
        """Return body and ``pin.Inertia`` of every weight at one pose; pairs that do not depend on the pose are stored."""
        if self._known is None:
            fixed = {number: beam.inertia_at(frames) for number, beam in self._beam_of.items() if not beam.telescopic}
            rigid = zip(self._body.tolist(), self.inertias.values(), strict=True)
            self._known = {**dict(zip(np.flatnonzero(self._is_rigid).tolist(), rigid, strict=True)), **fixed}
        return [self._known[k] if k in self._known else self._beam_of[k].inertia_at(frames) for k in range(len(self.names))]

    def on_model(self, model: pin.Model, frames: Frames) -> pin.Model:
        """Return a copy of Pinocchio's ``model`` of the tree with the inertias of the robot at one pose.

        Raises:
            StaticsError: a telescopic beam has no length.
        """
        if any(float(beam.remaining_length(frames)[0]) < 0 for beam in self._beams):
            raise StaticsError(no_length_text(self._beams, frames, 0))
        return weighed(model, self._bodies_at(frames))

    def sum(self, names: Iterable[str], wrenches: Array) -> Array:
        """Return the sum (6, N) of the ``wrenches`` (6, W, N) of the named weights; other names are ignored."""
        which = [self._number[name] for name in names if name in self._number]
        total: Array = wrenches[:, which].sum(axis=1)
        return total

    def carried_by(self, edge: Edge, wrenches: Array) -> Array:
        """Return the sum (6, N) of the ``wrenches`` (6, W, N) of the weights that an edge carries."""
        return self.sum([name for name in edge.outboard if carries(edge, name)], wrenches)

    def outboard_of(self, edge: Edge) -> Array:
        """(W,) 1 for each weight that an edge carries, else 0."""
        return np.array([carries(edge, name) for name in self.names], dtype=float)

    def of(self, owner: str) -> NDArray[np.bool_]:
        """(W,) True for the weights of ``owner``: a limb, ``base`` or ``platform``."""
        return np.array([item == owner for item in self.owner], dtype=bool)


def link_inertias(model: pin.Model) -> dict[str, pin.Inertia]:
    """Return every link's own ``pin.Inertia``, in the frame of its body (Pinocchio's joint); ``model`` was built from a URDF.

    Pinocchio adds the inertias of links joined by fixed joints. The inertia of a link at a fixed joint is stored with this
    joint's frame; the remainder belongs to the link at the moving joint.
    """
    import pinocchio as pin

    rest = {body: pin.Inertia(inertia) for body, inertia in enumerate(model.inertias)}
    totals = {body: inertia.mass for body, inertia in rest.items()}
    found: dict[str, pin.Inertia] = {}
    first: dict[int, str] = {}
    for frame in model.frames:
        if frame.type != pin.FrameType.BODY:
            continue
        parent, body = model.frames[frame.parentFrame], int(frame.parentJoint)
        if parent.type == pin.FrameType.FIXED_JOINT and parent.name != "universe":
            found[frame.name] = pin.Inertia(parent.placement.act(parent.inertia))
            rest[body] = pin.Inertia(rest[body] - found[frame.name]) if parent.inertia.mass else rest[body]
        else:
            first[body] = frame.name
    for body, name in first.items():
        found[name] = rest[body] if rest[body].mass > _NEGLIGIBLE * totals[body] else pin.Inertia.Zero()
    return found


def weighed(model: pin.Model, bodies: Iterable[tuple[int, pin.Inertia]]) -> pin.Model:
    """Return a copy of a ``pin.Model`` in which each body has the sum of its inertias in ``bodies``, and no other inertia."""
    import pinocchio as pin

    copy = model.copy()
    for body in range(copy.njoints):
        copy.inertias[body] = pin.Inertia.Zero()
    for body, inertia in bodies:
        if inertia.mass:
            copy.inertias[body] = pin.Inertia(copy.inertias[body] + inertia) if copy.inertias[body].mass else inertia
    return copy
