"""Reader of MuJoCo's MJCF files, by the package ``mujoco``, which resolves defaults, includes and inertias of geoms.

Coordinates here are zero in the pose ``qpos0`` of the file. Constraints are those of the compiled model, https://mujoco.readthedocs.io
"XML reference, equality", and engine_core_constraint.c mj_instantiateEquality: connect is a spherical joint, weld a fixed joint,
joint a ``<mimic>``. What statics of the mechanism does not need is ignored with a warning.
"""

from __future__ import annotations

import numpy as np

from kinetostatics.arguments import Keyword
from kinetostatics.description.elements import Inertia, Link, Origin
from kinetostatics.description.fields import Place
from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.description.joints import Mimic
from kinetostatics.exceptions import RobotFileError
from kinetostatics.files.foreign_loops import ForeignJoint, between, graph, spring, unit
from kinetostatics.files.xml import XmlElement
from kinetostatics.math.arrays import Array

#: Types of joints by their numbers in MuJoCo: free, ball, slide, hinge.
TYPES = ("floating", "spherical", "prismatic", "continuous")


def robot_element(data: bytes | str, path: str, warnings: list[str]) -> XmlElement:
    """Return the element ``<robot>`` of an MJCF file; text that is no file must not refer to other files.

    Raises:
        RobotFileError: MuJoCo is not installed, or cannot compile the file; or two joints are coupled by a curve.
    """
    try:
        import mujoco
    except ImportError:
        raise RobotFileError("reading MJCF needs MuJoCo: pip install 'kinetostatics[mjcf]'", path) from None
    try:
        text = data if isinstance(data, str) else None
        model = mujoco.MjModel.from_xml_path(path) if text is None else mujoco.MjModel.from_xml_string(text)
    except ValueError as error:
        raise RobotFileError(f"MuJoCo does not read it: {' '.join(str(error).split())}", path) from None
    state = mujoco.MjData(model)
    mujoco.mj_kinematics(model, state)
    return _Reader(mujoco, model, state, path, warnings).robot()


class _Reader:
    """A compiled model and its state at ``qpos0``."""

    def __init__(self, mujoco: Keyword, model: Keyword, state: Keyword, path: str, warnings: list[str]) -> None:
        self.mujoco, self.model, self.state, self.place, self.warnings = mujoco, model, state, Place(path), warnings
        self.frames = [_matrix(state.xpos[k], state.xmat[k]) for k in range(model.nbody)]
        self.links = ["world", *(self.name("body", k) for k in range(1, model.nbody))]
        self.joints = [self.name("joint", k) for k in range(model.njnt)]

    def name(self, kind: str, number: int) -> str:
        entry = self.mujoco.mj_id2name(self.model, getattr(self.mujoco.mjtObj, f"mjOBJ_{kind.upper()}"), number)
        return entry or f"{kind}_{number}"

    def robot(self) -> XmlElement:
        model = self.model
        mimics, closed = self._equalities()
        chains = [joint for body in range(1, model.nbody) for joint in self._chain(body, mimics)]
        between = [joint.successor for joint in chains if joint.successor not in self.links]
        links = [self._link(body) for body in range(model.nbody)] + [Link(name, place=self.place) for name in between]
        oblique = np.count_nonzero(model.jnt_stiffness) - sum(bool(joint.stiffness) for joint in chains)
        for count, what in (
            (model.ntendon, "tendons"),
            (model.nflex, "flexible bodies"),
            (oblique, "springs of joints that are not along an axis of a body"),
            (model.npair, "contact pairs"),
        ):
            if count:
                self.warnings.append(f"{self.place}: {what} are ignored ({count} of them).")
        name = model.names.split(b"\0")[0].decode() or "robot"
        return graph(name, links, [*chains, *closed], self._driven(mimics), self.place, self.warnings)

    def _link(self, body: int) -> Link:
        model, state = self.model, self.state
        if not model.body_mass[body]:
            return Link(self.links[body], place=self.place)
        origin = Origin.of(np.linalg.solve(self.frames[body], _matrix(state.xipos[body], state.ximat[body])))
        xx, yy, zz = model.body_inertia[body].tolist()
        inertia = Inertia((xx, 0.0, 0.0, yy, 0.0, zz), origin.rpy)
        return Link(self.links[body], float(model.body_mass[body]), origin.xyz, inertia, has_inertial=True, place=self.place)

    def _chain(self, body: int, mimics: dict[int, Mimic]) -> list[ForeignJoint]:
        """Return the joints between a body and its parent, with massless links between them at the frame of the body."""
        model, parent = self.model, int(self.model.body_parentid[body])
        numbers = range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body])
        above, above_frame, frame = self.links[parent], self.frames[parent], self.frames[body]
        if not numbers:
            ends = (above, above_frame, frame), (self.links[body], frame, frame)
            return [between(f"{self.links[body]}_fixed", "fixed", ends, None, self.place, closes=False)]
        result: list[ForeignJoint] = []
        for number in numbers:
            kind, axis = TYPES[model.jnt_type[number]], unit(model.jnt_axis[number])
            more: dict[str, Keyword] = {"mimic": mimics.get(number)}
            if JOINT_TYPES[kind].is_single and model.jnt_limited[number]:
                lower, upper = (model.jnt_range[number] - model.qpos0[model.jnt_qposadr[number]]).tolist()
                more["limits"] = {"lower": lower, "upper": upper}
                kind = {"continuous": "revolute"}.get(kind, kind)
            more["stiffness"] = spring(JOINT_TYPES[kind], axis, float(model.jnt_stiffness[number]))
            at = frame if JOINT_TYPES[kind].is_free else frame @ _matrix(model.jnt_pos[number], np.eye(3))
            below = self.links[body] if number == numbers[-1] else f"{self.joints[number]}_body"
            ends = (above, above_frame, at), (below, frame, at)
            result.append(between(self.joints[number], kind, ends, axis, self.place, closes=False, **more))
            above, above_frame = below, frame
        return result

    def _equalities(self) -> tuple[dict[int, Mimic], list[ForeignJoint]]:
        """Return the coupled joints by number, and the loops."""
        model, kinds, sites = self.model, self.mujoco.mjtEq, self.mujoco.mjtObj.mjOBJ_SITE
        mimics: dict[int, Mimic] = {}
        loops: list[ForeignJoint] = []
        for number in range(model.neq):
            kind, data = kinds(model.eq_type[number]), model.eq_data[number]
            first, second = model.eq_obj1id[number], model.eq_obj2id[number]
            name = self.mujoco.mj_id2name(model, self.mujoco.mjtObj.mjOBJ_EQUALITY, number) or ""
            label = f"the equality {name or number}"
            if not model.eq_active0[number]:
                self.warnings.append(f"{self.place}: {label} is not active, and is ignored.")
            elif kind == kinds.mjEQ_JOINT and second >= 0:
                if data[2:5].any():
                    raise self.place.error(f"{label} couples two joints by a curve; only a constant ratio can be a <mimic>")
                mimics[int(first)] = Mimic(self.joints[second], float(data[1]), float(data[0]))
            elif kind in (kinds.mjEQ_CONNECT, kinds.mjEQ_WELD):
                bodies = [int(first), int(second)]
                if model.eq_objtype[number] == sites:
                    at = [_matrix(model.site_pos[site], self._rotation(model.site_quat[site])) for site in bodies]
                    bodies = [int(model.site_bodyid[site]) for site in bodies]
                elif kind == kinds.mjEQ_CONNECT:
                    at = [_matrix(data[:3], np.eye(3)), _matrix(data[3:6], np.eye(3))]
                else:
                    at = [_matrix(data[3:6], self._rotation(data[6:10])), _matrix(data[:3], np.eye(3))]
                kind_name = "spherical" if kind == kinds.mjEQ_CONNECT else "fixed"
                ends = [(self.links[body], np.eye(4), frame) for body, frame in zip(bodies, at, strict=True)]
                loops.append(between("" if name in self.joints else name, kind_name, ends, None, self.place))
            else:
                self.warnings.append(f"{self.place}: {label} is neither connect, weld nor a pair of joints, and is ignored.")
        return mimics, loops

    def _rotation(self, quaternion: Array) -> Array:
        result = np.empty(9)
        self.mujoco.mju_quat2Mat(result, quaternion / np.linalg.norm(quaternion))
        return result

    def _driven(self, mimics: dict[int, Mimic]) -> list[str]:
        """Return the joints with an actuator: of its own, or of a tendon along joints that all follow one joint."""
        model, types = self.model, self.mujoco.mjtTrn
        names: dict[str, None] = {}
        for number in range(model.nu):
            kind, target = types(model.actuator_trntype[number]), model.actuator_trnid[number, 0]
            joints = {int(target)} if kind in (types.mjTRN_JOINT, types.mjTRN_JOINTINPARENT) else set()
            if kind == types.mjTRN_TENDON:
                wraps = range(model.tendon_adr[target], model.tendon_adr[target] + model.tendon_num[target])
                of_joints = all(model.wrap_type[wrap] == self.mujoco.mjtWrap.mjWRAP_JOINT for wrap in wraps)
                joints = {int(model.wrap_objid[wrap]) for wrap in wraps} if of_joints else set()
            leaders = {mimics[joint].joint if joint in mimics else self.joints[joint] for joint in joints}
            if len(leaders) == 1:
                names[leaders.pop()] = None
            else:
                name = self.name("actuator", number)
                self.warnings.append(f"{self.place}: the actuator {name} drives no joint, and is ignored.")
        return list(names)


def _matrix(point: Array, rotation: Array) -> Array:
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = np.reshape(rotation, (3, 3)), point
    return result
