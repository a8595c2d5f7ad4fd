"""Table of load-carrying joints, and the passive joints of open branches, whose wrenches must do no work."""

from __future__ import annotations

import numpy as np

from kinetostatics.limbs.static_model import StaticModel
from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.joint_freedoms import Freedoms, freedoms_of
from kinetostatics.mechanism.limb_joints import sides
from kinetostatics.mechanism.limbs import Edge, carries
from kinetostatics.mechanism.tree import Frames


class OpenBranch:
    """A passive joint of an open branch, which must be in equilibrium at the given pose.

    Attributes:
        owner: the limb that carries the branch, or ``base`` or ``platform``.
        joint: name of the joint.
        edge: the joint, directed outwards.
        outboard: (W,) mask of the weights that it carries.
        scale: (k,) scale of its powers: 1 for a translation, the characteristic length for a rotation.
    """

    def __init__(self, model: StaticModel, owner: str, edge: Edge) -> None:
        connection = model.mechanism.connections[str(edge.joint)]
        self.owner, self.joint = owner, connection.name
        self.edge = edge
        self.outboard = model.weights.outboard_of(edge)
        self._freedoms = Freedoms([f for f in freedoms_of(model.mechanism, connection, edge.sign) if f.passive])
        self.scale = np.where(self._freedoms.rotates, model.length, 1.0)

    def twists(self, frames: Frames, o: Array) -> Array:
        """Return the unit twists (6, k, N) of its freedoms about o."""
        return self._freedoms.twists(frames, o)


def open_branches_of(model: StaticModel) -> tuple[OpenBranch, ...]:
    """Return the passive joints of all open branches."""
    topology = model.topology
    parts = [(limb.name, limb.branches) for limb in topology.all_limbs]
    parts += [("base", topology.base.edges), ("platform", topology.platform.edges)]
    found = []
    for owner, edges in parts:
        for edge in edges:
            if edge.joint is not None:
                branch = OpenBranch(model, owner, edge)
                if branch.scale.size:
                    found.append(branch)
    return tuple(found)


class JointTable:
    """All joints that carry wrenches.

    Attributes:
        names: names of the joints, including fixed joints: those of the limbs, of their open branches, of base and of platform.
        owners: the limb of each joint, or ``base`` or ``platform``.
        signs: by name, 1 if the wrench of the predecessor on the successor is reported, else −1.
        cut_signs: (J, Q) signs of the cut-joint wrenches of all limbs in the wrench of the joint's outboard side on its inboard
            side.
        outboard: (J, W) mask of the weights that each joint carries.
        reported: (J,) −1 if the wrench of the inboard side on the outboard side is reported, 1 for its reaction.
        centre_body, centre: body (J,) and position (3, J) of the centre; for a sliding joint, on the side that is loaded.
    """

    def __init__(self, model: StaticModel) -> None:
        topology = model.topology
        found: list[tuple[Edge, int, str]] = []
        self._first = [0]
        for limb in topology.all_limbs:
            found += [(edge, self._first[-1], limb.name) for edge in (*limb.edges, *limb.branches)]
            self._first.append(self._first[-1] + len(limb.to_platform))
        for owner, dead in (("base", topology.base), ("platform", topology.platform)):
            found += [(edge, 0, owner) for edge in dead.edges]
        entries = [(edge, k) for edge, k, _ in found if edge.joint is not None]
        self.names = [str(edge.joint) for edge, _ in entries]
        self.owners = [owner for edge, _, owner in found if edge.joint is not None]
        self.cut_signs = np.zeros((len(entries), self._first[-1]))
        for row, (edge, k) in enumerate(entries):
            for cut, sign in edge.cut_joints:
                self.cut_signs[row, k + cut] = sign
        self._edges = [edge for edge, _ in entries]
        outboard = [model.weights.outboard_of(edge) for edge in self._edges]
        self.outboard = np.array(outboard).reshape(len(entries), len(model.weights.names))
        turned = [edge.both_ways and edge.sign < 0 for edge, _ in entries]
        self.signs = {str(edge.joint): edge.sign * (-1 if back else 1) for (edge, _), back in zip(entries, turned, strict=True)}
        self.reported = np.where(turned, 1.0, -1.0)
        outer = [
            sides(edge, model.mechanism.connections[str(edge.joint)])[0 if back else 1]
            for (edge, _), back in zip(entries, turned, strict=True)
        ]
        self.centre_body = np.array([body for body, _ in outer], dtype=np.intp)
        self.centre = np.array([frame[:3, 3] for _, frame in outer]).reshape(-1, 3).T

    def carrying(self, place: str) -> Array:
        """Return (J,) 1 for the joints that carry a load at a place, else 0."""
        return np.array([carries(edge, place) for edge in self._edges], dtype=float)

    def cuts_of(self, limb: int) -> slice:
        """Return the columns of ``cut_signs`` that belong to a limb."""
        return slice(self._first[limb], self._first[limb + 1])
