"""Robots around one joint of any of the eight loop types, written as files, with their motion and statics in closed form.

The joint under test, ``closing``, holds the platform at the tip of the cantilever ``arm_1``. A second cantilever, ``arm_2``,
is welded to the platform and stands on a chain of elementary joints, ``chain_1`` …, that has the very freedoms of the joint. So
the platform's pose is known without solving anything, and with the chain actuated both arms are clamped beams at every pose. The
loop is cut in four places; see :data:`CUTS`.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from finite_elements import skew
from mechanisms import across, numbers, rpy, unit
from scipy.linalg import null_space
from scipy.spatial.transform import Rotation

import kinetostatics as ks
from kinetostatics.files.reader import parse_robot_text

#: Freedoms of every type.
FREEDOMS = {
    "fixed": 0, "revolute": 1, "continuous": 1, "prismatic": 1,
    "cylindrical": 2, "universal": 2, "spherical": 3, "planar": 3,
}  # fmt: skip
ONE_FREEDOM = ("revolute", "continuous", "prismatic")
#: ``joint``: the joint under test is the loop. ``weld``, ``root``: it is in the tree, as a run of elementary joints where URDF
#: has no such type, and the loop is a fixed one behind or before it, so that it points out from the base or in from the
#: platform. ``both``: the platform floats in the tree, and joint and weld are loops. ``upside_down``: as ``joint``, but the tree
#: grows from the platform, so that in it the base moves.
CUTS = ("joint", "weld", "root", "both", "upside_down")
#: Those in which the joint under test is a loop.
LOOP_CUTS = ("joint", "both", "upside_down")


def cuts(kind):
    """Return where robots of a kind are cut; without a freedom nothing moves, and world axes are those of the tree's root."""
    return CUTS[:-1] if kind == "fixed" else CUTS


E_MODULUS, G_MODULUS, DENSITY = 70e9, 27e9, 2700.0
GRAVITY = (0.7, -1.9, -9.2)


def random_rotation(rng):
    return Rotation.random(random_state=rng).as_matrix()


def frame(R=None, p=(0, 0, 0)):
    F = np.eye(4)
    F[:3, :3], F[:3, 3] = np.eye(3) if R is None else R, p
    return F


def turn(axis, angle, point=(0, 0, 0)):
    """Return the displacement (4, 4) that turns about a line."""
    R = Rotation.from_rotvec(np.multiply(axis, angle)).as_matrix()
    return frame(R, point - R @ point)


def shift(v):
    return frame(p=v)


def at(D, point):
    return D[:3, :3] @ point + D[:3, 3]


# ---- text ----------------------------------------------------------------------------------------------------------------


def origin(F):
    return f'<origin xyz="{numbers(F[:3, 3])}" rpy="{numbers(rpy(F[:3, :3]))}"/>'


def loop(kind, predecessor, P, successor, S, *, axis=None, axis2=None, extra="", name="closing"):
    """Return a ``<loop>``; ``P``, ``S`` (4, 4) are its frames in the two links."""
    axes = "" if axis is None else f'<axis xyz="{numbers(axis)}"/>'
    axes += "" if axis2 is None else f'<axis2 xyz="{numbers(axis2)}"/>'
    return (
        f'<loop name="{name}" type="{kind}"><predecessor link="{predecessor}">{origin(P)}</predecessor>'
        f'<successor link="{successor}">{origin(S)}</successor>{axes}{extra}</loop>'
    )


def joint(name, kind, parent, child, F, axis=None, limit='lower="-1e3" upper="1e3"'):
    """Return a ``<joint>``; ``F`` (4, 4) is the child's frame in the parent, ``axis`` in the child's frame."""
    axes = "" if axis is None else f'<axis xyz="{numbers(axis)}"/>'
    limits = f'<limit {limit} effort="0" velocity="0"/>' if kind in ("revolute", "prismatic") else ""
    return f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{origin(F)}{axes}{limits}</joint>'


def actuated(*names):
    return "".join(f'<transmission name="drive_{name}"><joint name="{name}"/></transmission>' for name in names)


def robot(*parts, links=("base", "platform"), name="loops"):
    """Return the robot with anything in it, and some links: their names, or what is inside them by name."""
    inside = links if isinstance(links, dict) else dict.fromkeys(links, "")
    text = "".join(f'<link name="{link}">{xml}</link>' for link, xml in inside.items())
    return ks.Robot(parse_robot_text(f'<robot name="{name}">{text}<platform link="platform"/>{"".join(parts)}</robot>'))


def floating(kind, P, S, *, zero=None, **options):
    """Return a platform that floats in the tree and is held to the base by one loop; ``zero`` (4, 4): where it is at zero."""
    zero = P @ np.linalg.inv(S) if zero is None else zero
    return robot(joint("free", "floating", "base", "platform", zero), loop(kind, "base", P, "platform", S, **options))


# ---- the two arms --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Arm:
    """A clamped beam from ``root`` to ``tip`` (3,) [m], a solid circle."""

    root: np.ndarray
    tip: np.ndarray
    diameter: float

    def moved(self, D):
        return Arm(at(D, self.root), at(D, self.tip), self.diameter)

    @property
    def xml(self):
        return (
            f'youngs_modulus="{E_MODULUS}" shear_modulus="{G_MODULUS}" shear_coefficient="1" density="{DENSITY}">'
            f'<circle diameter="{self.diameter!r}"/></beam>'
        )

    def numbers(self, o, gravity):
        """Return compliance (6, 6), sag (6,) and weight (6,) about ``o``: the cantilever of the textbooks."""
        area, bending = np.pi * self.diameter**2 / 4, np.pi * self.diameter**4 / 64
        EA, EI, GA, GJ = E_MODULUS * area, E_MODULUS * bending, G_MODULUS * area, 2 * G_MODULUS * bending
        L, u = np.linalg.norm(self.tip - self.root), unit(self.tip - self.root)
        along = np.outer(u, u)
        beside = np.eye(3) - along
        C = np.zeros((6, 6))
        C[:3, :3] = L / EA * along + (L**3 / (3 * EI) + L / GA) * beside
        C[3:, 3:] = L / GJ * along + L / EI * beside
        C[3:, :3] = L**2 / (2 * EI) * skew(u)
        C[:3, 3:] = C[3:, :3].T
        q = DENSITY * area * np.asarray(gravity)
        d = L**2 / (2 * EA) * along @ q + (L**4 / (8 * EI) + L**2 / (2 * GA)) * beside @ q
        X = np.eye(6)
        X[:3, 3:] = -skew(o - self.tip)
        middle = (self.root + self.tip) / 2 - o
        weight = np.concatenate([q * L, np.cross(middle, q * L)])
        return X @ C @ X.T, X @ np.concatenate([d, L**3 / (6 * EI) * np.cross(u, q)]), weight


@dataclass(frozen=True)
class Statics:
    """Expected numbers: twist (6,), joint wrenches (6,) as results give them, force on every chain joint and on the loop."""

    twist: np.ndarray
    wrenches: dict
    chain_forces: list
    loop_force: float | None


@dataclass
class Held:
    """A robot around one joint; ``seed`` draws all its points, axes and frames.

    Attributes:
        kind: type of the joint under test.
        cut: where the loop is cut, one of :data:`CUTS`.
        swap: whether the platform is the loop's predecessor; with ``cut="root"`` the tree joint's parent is the platform.
        drive: what is actuated: the ``chain``, or the joint under test, ``closing``.
        extra: more XML inside the loop under test.
        right: whether a universal joint's axes are at right angles.
    """

    kind: str
    seed: int = 0
    cut: str = "joint"
    swap: bool = False
    drive: str = "chain"
    extra: str = ""
    right: bool = True
    mass: float = 1.3

    def __post_init__(self):
        rng = np.random.default_rng(self.seed)
        self.swap = self.swap or self.cut == "root"
        self.J = frame(random_rotation(rng), rng.uniform(-0.3, 0.3, 3))
        self.c = self.J[:3, 3]
        self.local_axis, other = unit(rng.standard_normal(3)), unit(rng.standard_normal(3))
        square = unit(np.cross(self.local_axis, other))
        self.local_axis2 = square if self.right else unit(square + 0.6 * self.local_axis)
        self.a, self.b = self.J[:3, :3] @ self.local_axis, self.J[:3, :3] @ self.local_axis2
        self.s, self.t = across(self.a)
        away = [unit(rng.standard_normal(3)) for _ in range(3)]
        self.o0 = self.c + 0.4 * away[0]
        self.platform0 = frame(random_rotation(rng), self.o0)
        self.com = self.o0 + 0.1 * away[1]
        chain = self.chain
        foot = self.c + rng.uniform(0.1, 0.3) * (chain[-1][1] if chain and chain[-1][0] == "R" else away[2])
        self.foot = self.c if self.kind in ("universal", "spherical") else foot
        self.arm_1 = Arm(self.c + 0.5 * unit(rng.standard_normal(3)), self.c, 0.03)
        self.arm_2 = Arm(self.foot, self.foot + 0.6 * unit(rng.standard_normal(3)), 0.04)
        self._frames = {"base": np.eye(4)}
        self._rng = rng

    # ---- kinematics -----------------------------------------------------------------------------------------------------

    @property
    def chain(self):
        """The elementary joints with the same freedoms, base to platform: R or P and the axis at zero (3,)."""
        return {
            "fixed": [],
            "revolute": [("R", self.a)],
            "continuous": [("R", self.a)],
            "prismatic": [("P", self.a)],
            "cylindrical": [("P", self.a), ("R", self.a)],
            "universal": [("R", self.a), ("R", self.b)],
            "spherical": [("R", self.J[:3, k]) for k in range(3)],
            "planar": [("P", self.s), ("P", self.t), ("R", self.a)],
        }[self.kind]

    @property
    def names(self):
        return [f"chain_{k + 1}" for k in range(len(self.chain))]

    def displacement(self, q, count=None):
        """Return how the platform (4, 4), or what lies beyond ``count`` chain joints, moves from zero."""
        D = np.eye(4)
        for value, (kind, axis) in list(zip(q, self.chain, strict=True))[:count]:
            D = D @ (turn(axis, value, self.c) if kind == "R" else shift(value * axis))
        return D

    def platform_frame(self, q):
        return self.displacement(q) @ self.platform0

    def actuators(self, q):
        """Return the actuators' coordinates at chain coordinates ``q``."""
        if self.drive == "chain":
            return dict(zip(self.names, q, strict=True))
        return {"closing": -q[0] if self.swap else q[0]}

    def random_q(self, rng):
        return [rng.uniform(-3, 3) if kind == "R" else rng.uniform(-1.5, 1.5) for kind, _ in self.chain]

    # ---- the file -------------------------------------------------------------------------------------------------------

    def _frame(self, link, F=None):
        if link not in self._frames:
            self._frames[link] = frame(random_rotation(self._rng), self._rng.uniform(-0.3, 0.3, 3)) if F is None else F
        return self._frames[link]

    def _in(self, link, F):
        return np.linalg.inv(self._frames[link]) @ F

    def _at(self, point, axis=None):
        """Return a random frame at a point, whose z is ``axis`` if that is given."""
        return frame(random_rotation(self._rng) if axis is None else np.column_stack([*across(axis), axis]), point)

    def _tree(self, name, kind, parent, child, point=None, axis=None, F=None):
        F = self._frame(child, self._at(point, axis if kind == "planar" else None) if F is None else F)
        return joint(name, kind, parent, child, self._in(parent, F), None if axis is None else F[:3, :3].T @ axis)

    def _elementary(self):
        """The joint under test for the tree: kinds, axes and names, base to platform."""
        if self.kind in ("cylindrical", "universal", "spherical"):
            return [(f"closing_{k + 1}", kind, axis) for k, (kind, axis) in enumerate(self.chain)]
        return [("closing", self.kind, self.a)]

    def _run(self, first, last):
        """The joint under test in the tree from link to link."""
        parts = self._elementary()
        if self.swap:
            parts = [(name, kind, -axis if kind in "RP" else axis) for name, kind, axis in parts[::-1]]
        links = [first, *(f"closing_link_{k}" for k in range(1, len(parts))), last]
        result = []
        for (name, kind, axis), parent, child in zip(parts, links[:-1], links[1:], strict=True):
            kind = {"R": "revolute", "P": "prismatic"}.get(kind, kind)
            result.append(self._tree(name, kind, parent, child, self.c, None if kind == "fixed" else axis))
        return result

    @property
    def runs(self):
        """Names under which the joint under test appears."""
        return ["closing"] if self.cut in LOOP_CUTS else [name for name, _, _ in self._elementary()]

    @cached_property
    def text(self):
        parts, n = [], len(self.chain)
        chain_links = ["base", *(f"chain_link_{k}" for k in range(1, n)), "arm_2"]

        def root_joint():
            return self._tree("root", "fixed", "base", "arm_1", self.arm_1.root)

        def chain():
            if not n:
                return [self._tree("foot", "fixed", "base", "arm_2", self.foot)]
            kinds = {"R": "continuous", "P": "prismatic"}
            points = [self.c] * (n - 1) + [self.foot]
            return [
                self._tree(name, kinds[kind], inner, outer, point, axis)
                for name, (kind, axis), inner, outer, point in zip(
                    self.names, self.chain, chain_links[:-1], chain_links[1:], points, strict=True
                )
            ]

        def fixed_loop(name, inner, outer, point):
            F = self._at(point)
            return loop("fixed", inner, self._in(inner, F), outer, self._in(outer, F), name=name)

        def tested():
            inner, outer, axis, axis2 = "arm_1", "platform", self.local_axis, self.local_axis2
            if self.swap:
                inner, outer = outer, inner
                axis, axis2 = (axis2, axis) if self.kind == "universal" else (axis, axis2)
            given = {} if self.kind in ("fixed", "spherical") else {"axis": axis}
            given |= {"axis2": axis2} if self.kind == "universal" else {}
            return loop(self.kind, inner, self._in(inner, self.J), outer, self._in(outer, self.J), extra=self.extra, **given)

        def chain_from_outside():
            """The chain, coordinates and all, in a tree that grows from the platform; the base's own frame is the world's."""
            self._frames["platform"] = self._at(self.o0)
            links = ["arm_2", *chain_links[-2:0:-1], "ground"] if n else ["arm_2", "ground"]
            reversed_chain = list(zip(self.names, self.chain, strict=True))[::-1] or [("foot", ("F", None))]
            kinds = {"R": "continuous", "P": "prismatic", "F": "fixed"}
            result = [self._tree("weld", "fixed", "platform", "arm_2", self.arm_2.tip)]
            for (name, (kind, axis)), parent, child in zip(reversed_chain, links[:-1], links[1:], strict=True):
                point = self.foot if parent == "arm_2" else self.c
                result.append(self._tree(name, kinds[kind], parent, child, point, None if axis is None else -axis))
            return [*result, joint("floor", "fixed", "ground", "base", self._in("ground", np.eye(4)))]

        if self.cut == "upside_down":
            parts += ['<base link="base"/>', *chain_from_outside(), root_joint(), tested()]
        elif self.cut in LOOP_CUTS:
            parts += [root_joint(), *chain()]
            if self.cut == "joint":
                parts.append(self._tree("weld", "fixed", "arm_2", "platform", self.arm_2.tip))
            else:
                parts.append(self._tree("free", "floating", "base", "platform", F=self._at(self.c)))
                parts.append(fixed_loop("weld", "arm_2", "platform", self.arm_2.tip))
            parts.append(tested())
        elif self.cut == "weld":
            parts += [root_joint(), *self._run("arm_1", "platform"), *chain()]
            parts.append(fixed_loop("weld", "arm_2", "platform", self.arm_2.tip))
        else:
            parts += [*chain(), self._tree("weld", "fixed", "arm_2", "platform", self.arm_2.tip)]
            parts += [*self._run("platform", "arm_1"), fixed_loop("root", "base", "arm_1", self.arm_1.root)]
        last = self.names[-1] if n else "foot"
        inner = self.runs[0]
        parts.append(f'<beam link="arm_1" from="root" to="{inner}" {self.arm_1.xml}')
        parts.append(f'<beam link="arm_2" from="{last}" to="weld" {self.arm_2.xml}')
        parts.append(actuated(*(self.names if self.drive == "chain" else ["closing"])))
        links = []
        for name in self._frames:
            inertial = ""
            if name == "platform":
                com = at(np.linalg.inv(self._frames[name]), self.com)
                inertial = (
                    f'<inertial><origin xyz="{numbers(com)}"/><mass value="{self.mass}"/>'
                    '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
                )
            links.append(f'<link name="{name}">{inertial}</link>')
        platform = f'<platform link="platform">{origin(self._in("platform", self.platform0))}</platform>'
        return f'<robot name="held">{"".join(links)}{platform}{"".join(parts)}</robot>'

    def robot(self):
        return ks.Robot(parse_robot_text(self.text))

    # ---- statics --------------------------------------------------------------------------------------------------------

    def freedoms(self, q):
        """Return the unit twists (6, f) of the joint under test about o: the platform's motion against arm_1."""
        D, o = self.displacement(q), self.platform_frame(q)[:3, 3]

        def rotation(axis):
            return np.concatenate([np.cross(axis, o - at(D, self.c)), axis])

        def translation(axis):
            return np.concatenate([axis, np.zeros(3)])

        columns = {
            "fixed": [],
            "prismatic": [translation(self.a)],
            "cylindrical": [translation(self.a), rotation(self.a)],
            "universal": [rotation(self.a), rotation(D[:3, :3] @ self.b)],
            "spherical": [rotation(axis) for axis in np.eye(3)],
            "planar": [translation(self.s), translation(self.t), rotation(self.a)],
        }.get(self.kind, [rotation(self.a)])
        return np.array(columns).reshape(-1, 6).T

    def statics(self, q, load, gravity=GRAVITY):
        """Return the expected numbers for a load (6,) at o, in closed form: two clamped beams and a joint between."""
        D, o, S = self.displacement(q), self.platform_frame(q)[:3, 3], self.freedoms(q)
        arm_2 = self.arm_2.moved(D)
        C_1, sag_1, _ = self.arm_1.numbers(o, gravity)
        C_2, sag_2, weight_2 = arm_2.numbers(o, gravity)
        pull = self.mass * np.asarray(gravity)
        W = np.asarray(load) + np.concatenate([pull, np.cross(at(D, self.com) - o, pull)])
        B = null_space(S.T) if S.size else np.eye(6)  # what the joint transmits
        if self.drive == "chain":  # arm_2 carries anything, arm_1 only B
            W_1 = B @ np.linalg.solve(B.T @ (C_1 + C_2) @ B, B.T @ (C_2 @ W + sag_2 - sag_1))
            twist = C_2 @ (W - W_1) + sag_2
        else:  # the joint is locked and the chain is not: it takes B too, besides what holds arm_2's weight along its freedoms
            particular = -S @ np.linalg.solve(S.T @ S, S.T @ weight_2)
            sag_p = sag_2 + C_2 @ particular
            y = np.linalg.solve(B.T @ (C_1 + C_2) @ B, B.T @ (C_1 @ (W - particular) + sag_1 - sag_p))
            W_1 = W - particular - B @ y
            twist = C_1 @ W_1 + sag_1
        W_2 = W - W_1

        def moved(w, point):
            return np.concatenate([w[:3], w[3:] + np.cross(o - point, w[:3])])

        wrenches = {name: -moved(W_1, at(D, self.c)) for name in self.runs}
        wrenches["weld"] = -moved(W_2, at(D, self.arm_2.tip))
        forces = []
        for k, (kind, axis) in enumerate(self.chain):
            inner = self.displacement(q, k)
            axis = inner[:3, :3] @ axis
            moving = np.concatenate([np.cross(axis, o - at(inner, self.c)), axis] if kind == "R" else [axis, np.zeros(3)])
            forces.append(float(-moving @ (W_2 + weight_2)))
        one = self.kind in ONE_FREEDOM
        return Statics(twist, wrenches, forces, float(-S[:, 0] @ W_1) * (-1 if self.swap else 1) if one else None)
