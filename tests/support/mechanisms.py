"""Mechanisms of any shape for the tests: links joined by joints, described by points and axes in the world at zero, and written
as robot files in any cut.

:func:`write_mechanism` turns a :class:`Mechanism` into a robot file with the loops cut wherever the caller wants, universal,
spherical and cylindrical joints as one closure or as runs, link frames turned at random or not. All joints at zero is the pose in
which the numbers of the mechanism hold, and closes the loops exactly.
"""

from dataclasses import dataclass, field

import numpy as np

import kinetostatics as ks
from kinetostatics.files.reader import parse_robot_text

E, NU, RHO = 200e9, 0.3, 7850.0
ORIGIN = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Stiffness:
    """Of a joint, along ``axes`` ((3, 3), columns, world at zero); as in ``<joint_stiffness>``."""

    axes: tuple = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    linear: tuple | None = None
    angular: tuple | None = None
    drive: float | None = None


@dataclass(frozen=True)
class Joint:
    """Kind is one of R P U S C F E X; C is cylindrical, F fixed, E planar (``axis`` is the normal), X floating. ``axis2`` is the
    second axis of U."""

    name: str
    kind: str
    centre: tuple
    axis: tuple = (0.0, 0.0, 1.0)
    axis2: tuple = (1.0, 0.0, 0.0)
    actuated: bool = False
    stiffness: Stiffness | None = None


@dataclass(frozen=True)
class Link:
    name: str
    mass: float = 0.0
    com: tuple = ORIGIN


@dataclass(frozen=True)
class Section:
    area: float
    I_y: float
    I_z: float
    J: float
    xml: str = ""

    @property
    def text(self):
        return self.xml or f'<section area="{self.area!r}" I_y="{self.I_y!r}" I_z="{self.I_z!r}" J="{self.J!r}"/>'


@dataclass(frozen=True)
class Beam:
    """From the centre of ``start`` to that of ``end``, carried by ``link``; density None: the link's mass is spread."""

    name: str
    link: str
    start: str
    end: str
    section: Section
    E: float = E
    nu: float = NU
    density: float | None = RHO
    kappa: float = 1.0
    y_axis: tuple | None = None
    thermal_expansion: float = 0.0


@dataclass(frozen=True)
class Edge:
    """A joint between the links ``inner`` and ``outer``."""

    joint: Joint
    inner: str
    outer: str

    def other(self, link):
        return self.outer if link == self.inner else self.inner


@dataclass(frozen=True)
class Mechanism:
    """Links ``base`` and ``platform`` are always there; ``links`` are all others."""

    edges: tuple
    links: tuple
    beams: tuple
    o: tuple = ORIGIN
    mass: float = 0.0
    com: tuple = ORIGIN
    extra: str = ""
    name: str = "small"

    @property
    def joints(self):
        return {edge.joint.name: edge.joint for edge in self.edges}


@dataclass
class Written:
    text: str
    #: frame (4, 4) of every link at zero
    frames: dict = field(default_factory=dict)
    #: names of the elementary joints of every joint of the spec, base to platform
    runs: dict = field(default_factory=dict)
    #: for every elementary joint, whether its predecessor is on the inner side of its edge
    forward: dict = field(default_factory=dict)
    #: for every elementary joint, its frame (4, 4) at zero, and the link on whose side it is its predecessor's
    joint_frames: dict = field(default_factory=dict)

    def description(self):
        return parse_robot_text(self.text)

    def robot(self):
        return ks.Robot(self.description())


# ---- sections ------------------------------------------------------------------------------------------------------------


def circle(d):
    area, bending = np.pi * d**2 / 4, np.pi * d**4 / 64
    return Section(area, bending, bending, 2 * bending, f'<circle diameter="{d!r}"/>')


def tube(d, inner):
    area, bending = np.pi * (d**2 - inner**2) / 4, np.pi * (d**4 - inner**4) / 64
    return Section(area, bending, bending, 2 * bending, f'<tube outer_diameter="{d!r}" inner_diameter="{inner!r}"/>')


# ---- numbers -------------------------------------------------------------------------------------------------------------


def numbers(values):
    return " ".join(repr(float(v)) for v in np.asarray(values).ravel())


def rpy(R):
    """Return roll, pitch, yaw of a rotation matrix."""
    pitch = np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0]))
    if abs(R[2, 0]) > 1 - 1e-12:  # roll and yaw are one
        return np.array([np.arctan2(-R[2, 0] * R[0, 1], -R[2, 0] * R[0, 2]), pitch, 0.0])
    return np.array([np.arctan2(R[2, 1], R[2, 2]), pitch, np.arctan2(R[1, 0], R[0, 0])])


def random_rotation(rng):
    Q, R = np.linalg.qr(rng.standard_normal((3, 3)))
    Q = Q * np.sign(np.diag(R))
    return Q if np.linalg.det(Q) > 0 else -Q


def right_angled(rng):
    """Return one of the 24 rotations by right angles."""
    R = np.eye(3)[rng.permutation(3)] * rng.choice([-1.0, 1.0], 3)
    return R if np.linalg.det(R) > 0 else -R


def unit(v):
    v = np.asarray(v, dtype=float)
    return v / np.linalg.norm(v)


def across(axis):
    """Return two unit vectors across an axis and each other."""
    helper = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = unit(np.cross(axis, helper))
    return first, np.cross(axis, first)


# ---- cutting -------------------------------------------------------------------------------------------------------------


def random_cuts(mechanism, rng):
    """Return names of joints without which the mechanism is a tree. Floating joints, which cannot close loops, stay in it."""
    parent = {}

    def find(link):
        while parent.get(link, link) != link:
            link = parent[link]
        return link

    order = list(mechanism.edges)
    rng.shuffle(order)
    order.sort(key=lambda edge: 0 if edge.joint.kind == "X" else 2 if springs_in_freedoms(edge.joint) else 1)
    cut = set()
    for edge in order:
        a, b = find(edge.inner), find(edge.outer)
        if a == b:
            cut.add(edge.joint.name)
        else:
            parent[a] = b
    return cut


def springs_in_freedoms(joint):
    """Whether a joint with several axes has springs along its freedoms: a file can say so only of a closure in one piece."""
    return joint.kind in "US" and joint.stiffness is not None and joint.stiffness.angular is not None


# ---- writing -------------------------------------------------------------------------------------------------------------

KINDS = {"R": "revolute", "P": "prismatic", "F": "fixed", "U": "universal", "S": "spherical", "C": "cylindrical", "E": "planar",
         "X": "floating"}  # fmt: skip


def elementary(joint, whole):
    """Return a joint as joints that a tree can have, inner to outer; ``whole`` leaves it in one piece."""
    if joint.kind in "RPFEX" or whole:
        return [joint]
    axis = unit(joint.axis)
    if joint.kind == "U":
        parts = [("R", axis), ("R", unit(joint.axis2))]
    elif joint.kind == "C":
        parts = [("P", axis), ("R", axis)]
    else:
        second, third = across(axis)
        parts = [("R", axis), ("R", second), ("R", third)]
    assert not springs_in_freedoms(joint), joint
    springs = [None] * len(parts)
    if joint.stiffness is not None:
        s = joint.stiffness
        springs[0] = Stiffness(s.axes, s.linear) if s.linear is not None else None
        springs[-1] = Stiffness(s.axes, None, s.angular) if s.angular is not None else springs[-1]
    return [
        Joint(f"{joint.name}_{k}", kind, joint.centre, tuple(direction), stiffness=springs[k - 1])
        for k, (kind, direction) in enumerate(parts, 1)
    ]


class Writer:
    """Writes one mechanism; see :func:`write_mechanism`."""

    def __init__(self, mechanism, cuts, whole, piece, twirl, right, flip):
        self.mechanism, self.right, self.flip = mechanism, right, flip
        self.rng = None if twirl is None else np.random.default_rng(twirl)
        self.file = Written("", {"base": np.eye(4)})
        self.joints, self.loops, self.stiffnesses = [], [], []
        self.ends, self.chains = {}, {}
        self.links = ["base"]
        for edge in mechanism.edges:
            joint = edge.joint
            parts = elementary(joint, joint.name in cuts and (whole or springs_in_freedoms(joint)))
            names = [edge.inner, *(f"{part.name}_link" for part in parts[:-1]), edge.outer]
            at = min(piece, len(parts) - 1) if joint.name in cuts else None
            self.chains[joint.name] = [(part, *names[k : k + 2], k == at) for k, part in enumerate(parts)]
            self.file.runs[joint.name] = [part.name for part in parts]
            self.ends[joint.name] = {edge.inner: parts[0].name, edge.outer: parts[-1].name}

    def frame_of(self, joint, in_tree):
        """Return the frame (4, 4) of a joint at zero."""
        F = np.eye(4)
        F[:3, 3] = joint.centre
        if self.rng is not None and in_tree:
            F[:3, :3] = right_angled(self.rng) if self.right else random_rotation(self.rng)
        if joint.kind == "E" and in_tree:  # it moves in its frame's xy plane
            F[:3, :3] = np.column_stack([*across(unit(joint.axis)), unit(joint.axis)])
        if joint.stiffness is not None:
            F[:3, :3] = joint.stiffness.axes
        return F

    def tree_joint(self, joint, parent, child, sign):
        F = self.frame_of(joint, True)
        self.file.frames[child] = F
        rel = np.linalg.inv(self.file.frames[parent]) @ F
        axis = "" if joint.kind in "FXS" else f'<axis xyz="{numbers(F[:3, :3].T @ (sign * unit(joint.axis)))}"/>'
        if joint.kind == "E":
            axis = '<axis xyz="0 0 1"/>'
        limits = {"R": '<limit lower="-10" upper="10" effort="0" velocity="0"/>', "F": "", "X": "", "E": ""}
        limits["P"] = '<limit lower="-1e6" upper="1e6" effort="0" velocity="0"/>'
        self.joints.append(
            f'<joint name="{joint.name}" type="{KINDS[joint.kind]}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{numbers(rel[:3, 3])}" rpy="{numbers(rpy(rel[:3, :3]))}"/>{axis}{limits[joint.kind]}</joint>'
        )
        self._stiffness(joint, F)

    def loop(self, joint, inner, outer):
        first, second, axis, axis2 = inner, outer, unit(joint.axis), unit(joint.axis2)
        if self.flip:
            first, second = outer, inner
            axis, axis2 = (axis2, axis) if joint.kind == "U" else (-axis, axis2)
        F = self.frame_of(joint, False)
        sides = []
        for tag, link in (("predecessor", first), ("successor", second)):
            rel = np.linalg.inv(self.file.frames[link]) @ F
            sides.append(f'<{tag} link="{link}"><origin xyz="{numbers(rel[:3, 3])}" rpy="{numbers(rpy(rel[:3, :3]))}"/></{tag}>')
        axes = "" if joint.kind in "SF" else f'<axis xyz="{numbers(F[:3, :3].T @ axis)}"/>'
        axes += f'<axis2 xyz="{numbers(F[:3, :3].T @ axis2)}"/>' if joint.kind == "U" else ""
        self.loops.append(f'<loop name="{joint.name}" type="{KINDS[joint.kind]}">{"".join(sides)}{axes}</loop>')
        self.file.forward[joint.name] = not self.flip
        self._stiffness(joint, F)
        self.file.joint_frames[joint.name] = (F, first)

    def _stiffness(self, joint, F):
        s = joint.stiffness
        if s is None:
            return
        parts = [f'linear="{numbers(s.linear)}"' if s.linear is not None else ""]
        parts += [f'angular="{numbers(s.angular)}"' if s.angular is not None else ""]
        parts += [f'drive="{float(s.drive)!r}"' if s.drive is not None else ""]
        self.stiffnesses.append(f'<joint_stiffness joint="{joint.name}" {" ".join(parts)}/>')

    def grow(self):
        """Write the tree, from the base on, then the loops."""
        waiting = [(name, item) for name, chain in self.chains.items() for item in chain if not item[3]]
        while waiting:
            for number, (_, (joint, inner, outer, _)) in enumerate(waiting):
                if inner in self.file.frames:
                    parent, child, sign = inner, outer, 1
                elif outer in self.file.frames:  # seen from there everything turns the other way
                    parent, child, sign = outer, inner, -1
                else:
                    continue
                assert child not in self.file.frames, f"{joint.name} closes a loop and is not cut"
                self.tree_joint(joint, parent, child, sign)
                self.file.forward[joint.name] = sign == 1
                self.file.joint_frames[joint.name] = (self.file.frames[child], parent)
                del waiting[number]
                break
            else:
                raise AssertionError(f"{[item[1][0].name for item in waiting]} hang on nothing")
        for chain in self.chains.values():
            for joint, inner, outer, cut in chain:
                if cut:
                    self.loop(joint, inner, outer)

    def link(self, name, mass, com):
        if not mass:
            return f'<link name="{name}"/>'
        back = np.linalg.inv(self.file.frames[name])
        point = back[:3, :3] @ com + back[:3, 3]
        return (
            f'<link name="{name}"><inertial><origin xyz="{numbers(point)}"/><mass value="{float(mass)!r}"/>'
            '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>'
        )

    def beam(self, beam):
        density = "" if beam.density is None else f' density="{beam.density!r}"'
        alpha = f' thermal_expansion="{beam.thermal_expansion!r}"' if beam.thermal_expansion else ""
        y = ""
        if beam.y_axis is not None:
            y = f' y_axis="{numbers(self.file.frames[beam.link][:3, :3].T @ unit(beam.y_axis))}"'
        near = [self.ends[name][path_to(self.mechanism, beam.link, name)[0]] for name in (beam.start, beam.end)]
        return (
            f'<beam name="{beam.name}" link="{beam.link}" from="{near[0]}" to="{near[1]}" youngs_modulus="{beam.E!r}" '
            f'poisson_ratio="{beam.nu!r}" shear_coefficient="{beam.kappa!r}"{density}{alpha}{y}>{beam.section.text}</beam>'
        )


def path_to(mechanism, link, joint):
    """Return the link next to a joint that is reached from ``link`` without passing other than sliding and fixed joints, and
    the edges on the way."""
    target = next(edge for edge in mechanism.edges if edge.joint.name == joint)
    queue, seen = [(link, ())], {link}
    while queue:
        here, way = queue.pop(0)
        if here in (target.inner, target.outer):
            return here, way
        for edge in mechanism.edges:
            if here in (edge.inner, edge.outer) and edge.joint.kind in "PF" and edge.other(here) not in seen:
                seen.add(edge.other(here))
                queue.append((edge.other(here), (*way, edge)))
    raise AssertionError(f"no way from {link} to {joint}")


def write_mechanism(mechanism, *, cuts, whole=True, piece=0, twirl=None, right=False, flip=False, shuffle=None):
    """Write a mechanism as a robot file.

    Args:
        mechanism: the robot.
        cuts: names of the joints where loops are cut, one for each.
        whole: whether a universal, spherical or cylindrical joint at a cut is one closure; else a run, cut at ``piece``.
        piece: see ``whole``.
        twirl: a seed: turn the link frames at random.
        right: turn them by right angles only.
        flip: exchange predecessor and successor of the loops.
        shuffle: a seed: write links and beams in a random order.
    """
    writer = Writer(mechanism, cuts, whole, piece, twirl, right, flip)
    writer.grow()
    file = writer.file
    masses = {link.name: (link.mass, link.com) for link in mechanism.links}
    masses["platform"] = (mechanism.mass, mechanism.com)
    named = dict.fromkeys(name for chain in writer.chains.values() for item in chain for name in item[1:3])
    wanted = ["base", *(name for name in named if name not in ("base", "platform")), "platform"]
    beams = list(mechanism.beams)
    if shuffle is not None:
        rng = np.random.default_rng(shuffle)
        rng.shuffle(wanted)
        rng.shuffle(beams)
    assert sorted(wanted) == sorted(file.frames)
    F = np.linalg.inv(file.frames["platform"])
    point = F[:3, :3] @ mechanism.o + F[:3, 3]
    lines = [
        f'<robot name="{mechanism.name}">',
        *(writer.link(name, *masses.get(name, (0.0, ORIGIN))) for name in wanted),
        *writer.joints,
        f'<platform link="platform"><origin xyz="{numbers(point)}" rpy="{numbers(rpy(F[:3, :3]))}"/></platform>',
        *writer.loops,
        *map(writer.beam, beams),
        *(
            f'<transmission name="drive_{joint.name}"><joint name="{joint.name}"/></transmission>'
            for joint in mechanism.joints.values()
            if joint.actuated
        ),
        *writer.stiffnesses,
        mechanism.extra,
        "</robot>",
    ]
    file.text = "\n".join(lines)
    return file
