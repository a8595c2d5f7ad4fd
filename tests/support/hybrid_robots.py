"""Robots with hybrid limbs for the tests: named ones, and random ones grown from pieces between random links.

Pieces are serial chains, telescopes, spatial and planar parallelograms, cross-braced struts, beams welded into triangles, links
with several beams, pairs of hinges and single joints. Links between them may be anywhere: frames under the robot, wrists on it,
platforms in several parts, limbs that are joined to one another and loops that hang on nothing but one link all come out of it.
"""

from dataclasses import replace
from types import SimpleNamespace

import finite_elements
import numpy as np
from mechanisms import (
    Beam,
    Edge,
    Joint,
    Link,
    Mechanism,
    Section,
    Stiffness,
    across,
    circle,
    random_cuts,
    random_rotation,
    springs_in_freedoms,
    unit,
    write_mechanism,
)

#: Joints of a serial piece, inner to outer; a small letter is actuated.
CHAINS = ["SS", "US", "UU", "RR", "FF", "FS", "RF", "UF", "RS", "SU", "FFF", "FRF", "FCF", "FEF", "rRR", "rUS", "pSS", "RUR",
          "FUS", "UpS", "RpS", "FPF", "SFS", "rR"]  # fmt: skip
SINGLE = ["R", "U", "S", "P", "C", "E", "F", "r", "p"]


class Grower:
    """A mechanism that grows; ``at`` holds a point of every rigid link that pieces may be joined to."""

    def __init__(self, seed):
        self.rng = np.random.default_rng(seed)
        self.edges, self.links, self.beams = [], [], []
        self.at = {"base": np.zeros(3), "platform": np.array([0.1, -0.05, 0.8])}
        self.count = 0

    def name(self, what):
        self.count += 1
        return f"{what}_{self.count}"

    def near(self, link, spread=0.2):
        return self.at[link] + spread * self.rng.standard_normal(3)

    def direction(self):
        return unit(self.rng.standard_normal(3))

    def link(self, what, com=None, mass=None):
        name = self.name(what)
        mass = float(self.rng.choice([0.0, 0.0, 1.5])) if mass is None else mass
        self.links.append(Link(name, mass, tuple(np.zeros(3) if com is None else com)))
        return name

    def node(self):
        at = np.array([0, 0, 0.8 * self.rng.random()]) + 0.4 * self.rng.standard_normal(3)
        name = self.link("node", at)
        self.at[name] = at
        return name

    def joint(self, letter, centre, inner, outer, axis=None, axis2=None):
        axis = self.direction() if axis is None else axis
        if axis2 is None:
            axis2 = self.direction()
            if self.rng.random() < 0.7:
                axis2 = unit(np.cross(axis, axis2))
        actuated = letter.islower()
        joint = Joint(self.name("j"), letter.upper(), tuple(centre), tuple(axis), tuple(axis2), actuated=actuated)
        self.edges.append(Edge(joint, inner, outer))
        return joint.name

    def beam(self, link, start, end, name=None):
        rng = self.rng
        d = 0.02 + 0.04 * rng.random()
        section, y_axis = circle(d), None
        if rng.random() < 0.4:
            section, y_axis = Section(d**2, d**4 / 12, d**4 / 12 * (1 + rng.random()), 0.14 * d**4), tuple(self.direction())
        self.beams.append(
            Beam(
                name or link, link, start, end, section, E=float(rng.choice([70e9, 200e9])),
                kappa=float(rng.choice([0.85, np.inf])), density=float(rng.choice([0.0, 2700.0, 7850.0])), y_axis=y_axis,
                thermal_expansion=1.2e-5,
            )
        )  # fmt: skip

    def bar(self, a, b, p, q, first, last, **axes):
        """Join two links by one beam between two joints."""
        link = self.link("bar", mass=0.0)
        start = self.joint(first, p, a, link, **axes)
        self.beam(link, start, self.joint(last, q, link, b, **axes))

    # ---- pieces ------------------------------------------------------------------------------------------------------

    def chain(self, a, b, letters):
        """A serial chain of links, most of them elastic."""
        p, q = self.near(a), self.near(b)
        n = len(letters)
        points = [
            p + (q - p) * k / max(n - 1, 1) + (0.15 * self.rng.standard_normal(3) if 0 < k < n - 1 else 0.0) for k in range(n)
        ]
        elastic = [self.rng.random() < 0.8 for _ in range(n - 1)]
        middles = [(points[k] + points[k + 1]) / 2 for k in range(n - 1)]
        links = [self.link("k", m, 0.0 if e else None) for m, e in zip(middles, elastic, strict=True)]
        names = [a, *links, b]
        joints = [self.joint(letter, points[k], names[k], names[k + 1]) for k, letter in enumerate(letters)]
        for k, link in enumerate(links):
            if elastic[k]:
                self.beam(link, joints[k], joints[k + 1])

    def single(self, a, b):
        self.joint(str(self.rng.choice(SINGLE)), (self.near(a) + self.near(b)) / 2, a, b)

    def hinges(self, a, b):
        """Two or three hinges on one line, or anywhere."""
        axis, centre = self.direction(), (self.near(a) + self.near(b)) / 2
        for k in range(self.rng.integers(2, 4)):
            self.joint("R", centre + 0.2 * k * axis, a, b, axis=axis if self.rng.random() < 0.8 else None)

    def telescope(self, a, b):
        """One beam through a slide, actuated or not; the cylinder or the rod carries it."""
        p, q = self.near(a), self.near(b)
        axis, middle = unit(q - p), p + 0.5 * (q - p)
        cylinder, rod = self.link("cylinder", p + 0.2 * (q - p)), self.link("rod", q - 0.2 * (q - p))
        first = self.joint(str(self.rng.choice(list("USRF"))), p, a, cylinder)
        self.joint(str(self.rng.choice(["p", "p", "P"])), middle, cylinder, rod, axis=axis)
        last = self.joint(str(self.rng.choice(list("USRF"))), q, rod, b)
        carrier = rod if self.rng.random() < 0.7 else cylinder
        self.links = [replace(link, mass=0.0) if link.name == carrier else link for link in self.links]
        self.beam(carrier, first, last)
        if self.beams[-1].y_axis is None and self.rng.random() < 0.5:
            self.beams[-1] = replace(self.beams[-1], y_axis=tuple(across(axis)[0]))

    def parallelogram(self, a, b):
        """Two or three equal bars between balls, or between universal joints and balls."""
        p = self.near(a)
        v = self.near(b) - p
        first = str(self.rng.choice(["S", "S", "U"]))
        for _ in range(self.rng.integers(2, 4)):
            start = p + 0.15 * self.rng.standard_normal(3)
            self.bar(a, b, start, start + v, first, "S")

    def planar_parallelogram(self, a, b):
        """A Π joint: four hinges with parallel axes."""
        p = self.near(a)
        v = self.near(b) - p
        normal = unit(np.cross(v, self.direction()))
        side = 0.2 * unit(np.cross(normal, self.direction()))
        letters = "rR" if self.rng.random() < 0.3 else "RR"
        self.bar(a, b, p, p + v, *letters, axis=normal)
        self.bar(a, b, p + side, p + side + v, "R", "R", axis=normal)

    def cross_brace(self, a, b):
        """Beams crossed between two links, with different joints."""
        p, q = self.near(a, 0.1), self.near(b, 0.1)
        side, other = 0.15 * self.direction(), 0.15 * self.direction()
        pairs = [(p + side, q - other), (p - side, q + other)]
        if self.rng.random() < 0.5:
            pairs.append((p + side, q + other))
        for start, end in pairs:
            self.bar(a, b, start, end, *map(str, self.rng.choice(list("FRUS"), 2)))

    def triangle(self, a, b):
        """Three beams welded at their ends; two corners are joined to the links."""
        corners = [self.near(a, 0.1), self.near(b, 0.1)]
        corners.append((corners[0] + corners[1]) / 2 + 0.3 * self.rng.standard_normal(3))
        sides = [self.link("side", mass=0.0) for _ in range(3)]
        welds = [self.joint(str(self.rng.choice(list("FFFRS"))), corners[k], sides[k - 1], sides[k]) for k in range(3)]
        for k, side in enumerate(sides):
            self.beam(side, welds[k], welds[(k + 1) % 3])
        self.joint(str(self.rng.choice(list("FRUS"))), corners[0], a, sides[0])
        self.joint(str(self.rng.choice(list("FRUS"))), corners[1], sides[1], b)

    def fork(self, a, b):
        """One link with several beams, joined to the outer link several times."""
        p = self.near(a)
        link = self.link("fork", mass=float(self.rng.choice([0.0, 2.0])))
        root = self.joint(str(self.rng.choice(list("FRUS"))), p, a, link)
        tips = [self.joint(str(self.rng.choice(list("FRUS"))), self.near(b), link, b) for _ in range(self.rng.integers(2, 4))]
        first = len(self.beams)
        for tip in tips:
            self.beam(link, root, tip, self.name("tine"))
        if self.rng.random() < 0.5:
            self.beams[first:] = [replace(beam, density=None) for beam in self.beams[first:]]

    def piece(self, a, b):
        which = self.rng.random()
        pieces = [self.telescope, self.parallelogram, self.planar_parallelogram, self.cross_brace, self.triangle, self.fork,
                  self.hinges, self.single]  # fmt: skip
        if which < 0.5:
            self.chain(a, b, str(self.rng.choice(CHAINS)))
        else:
            pieces[int((which - 0.5) / 0.5 * len(pieces))](a, b)

    # ---- the whole ---------------------------------------------------------------------------------------------------

    def mechanism(self):
        rng = np.random.default_rng(self.count)
        links, beams = self._with_inertias(np.random.default_rng(self.count + 1))
        o = self.at["platform"] + 0.05 * rng.standard_normal(3)
        return Mechanism(
            tuple(self.edges), links, beams, tuple(o), float(5 * rng.random()),
            tuple(o + 0.1 * rng.standard_normal(3)), name="hybrid",
        )  # fmt: skip

    def _with_inertias(self, rng):
        """Return links and beams; most links with one massless beam get an inertia as from CAD, its centre anywhere near."""
        centres = {edge.joint.name: edge.joint.centre for edge in self.edges}
        links, beams = {link.name: link for link in self.links}, []
        for beam in self.beams:
            alone = sum(other.link == beam.link for other in self.beams) == 1
            if alone and beam.density == 0 and rng.random() < 0.7:
                com = (np.add(centres[beam.start], centres[beam.end]) + 0.2 * rng.standard_normal(3)) / 2
                links[beam.link], beam = Link(beam.link, 2.0, tuple(com)), replace(beam, density=None)
            beams.append(beam)
        return tuple(links.values()), tuple(beams)


def random_hybrid(seed, elastic_joints=None):
    """Return a random mechanism, held by its locked actuators more often than not.

    Args:
        seed: of everything.
        elastic_joints: the part of the joints that are elastic; None: none of them, or a third.
    """
    grower = Grower(seed)
    rng = grower.rng
    nodes = ["base", "platform", *(grower.node() for _ in range(rng.choice(4, p=[0.25, 0.35, 0.25, 0.15])))]
    for k, node in enumerate(nodes[2:], 2):  # every node hangs on an earlier one
        grower.piece(str(rng.choice(nodes[:k])), node)
    for _ in range(rng.integers(1, 4)):
        a, b = rng.choice(len(nodes), 2, replace=False)
        grower.piece(nodes[min(a, b) if b != 1 else a], nodes[max(a, b) if b != 1 else b])
    if len(nodes) == 2 or rng.random() < 0.5:
        grower.piece("base", "platform")
    for _ in range(8):
        mechanism = grower.mechanism()
        loose = _loose(mechanism, rng)
        if loose is None:  # they hang on different parts
            grower.piece("base", "platform")
        elif not loose or rng.random() < 0.05:
            break
        else:
            a, b = str(rng.choice([node for node in nodes if node != "platform"])), str(rng.choice(nodes[1:]))
            if a != b:
                grower.chain(a, b, str(rng.choice(CHAINS[:4])))
    share = rng.choice([0.0, 0.35]) if elastic_joints is None else elastic_joints
    edges = tuple(
        replace(edge, joint=with_springs(edge.joint, rng)) if rng.random() < share else edge for edge in mechanism.edges
    )
    return replace(mechanism, edges=edges)


def _loose(mechanism, rng):
    """Return whether something can move that carries load, None where base and platform are not joined."""
    try:
        file = write_mechanism(mechanism, cuts=random_cuts(mechanism, rng))
    except AssertionError:
        return None
    answer = finite_elements.solve(mechanism, file, AtZero(file))
    return answer.free or answer.unbalanced > 1e-6


def welded(mechanism):
    """Return the links that rigid fixed joints join to the base, and those that they join to the platform."""
    carriers = {beam.link for beam in mechanism.beams}
    groups = []
    for root in ("base", "platform"):
        group, queue = {root}, [root]
        while queue:
            here = queue.pop()
            for edge in mechanism.edges:
                rigid = edge.joint.kind == "F" and not {edge.inner, edge.outer} & carriers and edge.joint.stiffness is None
                if rigid and here in (edge.inner, edge.outer) and edge.other(here) not in group:
                    group.add(edge.other(here))
                    queue.append(edge.other(here))
        groups.append(group)
    return groups


class AtZero:
    """Stands for the configuration of a written robot with all joints at zero; robots that cannot be analyzed have one too."""

    def __init__(self, written):
        self.written = written

    def frame(self, link):
        return self.written.frames[link]

    @property
    def robot(self):
        from kinetostatics.mechanism.mechanism import Mechanism as Bodies

        description = self.written.description()
        return SimpleNamespace(description=description, mechanism=Bodies(description))

    @property
    def platform_frame(self):
        description = self.written.description()
        return self.written.frames["platform"] @ description.platform_origin.matrix


# ---- elastic joints and assembly errors

#: Freedoms of a joint that slide and turn.
FREEDOMS = {"R": (0, 1), "P": (1, 0), "U": (0, 2), "S": (0, 3), "C": (1, 1), "F": (0, 0), "E": (2, 1), "X": (3, 3)}


def with_springs(joint, rng):
    """Return a joint with random stiffnesses: of its bearing, its actuator, and now and then along its freedoms."""
    slides, turns = (0, 0) if joint.actuated else FREEDOMS[joint.kind]
    axis = unit(joint.axis)
    normal = joint.kind == "E"
    aligned = normal or rng.random() < 0.7
    axes = random_rotation(rng)
    column = 2 if normal else int(rng.integers(3))
    if aligned:
        axes = np.zeros((3, 3))
        axes[:, column] = axis if normal else axis * rng.choice([-1, 1])
        axes[:, (column + 1) % 3] = across(axis)[0]
        axes[:, (column + 2) % 3] = np.cross(axes[:, column], axes[:, (column + 1) % 3])

    def values(freedoms, low, high):
        if rng.random() < 0.3:
            return None
        k = 10 ** rng.uniform(low, high, 3)
        if freedoms and (joint.kind == "U" or (not aligned and freedoms < 3)):
            return tuple(k)  # a flexure
        free = {0: [], 1: [column], 2: [i for i in range(3) if i != column], 3: [0, 1, 2]}[freedoms]
        for i in range(3):
            choice = rng.random()
            if i in free:
                k[i] = 0.0 if choice < 0.4 else np.inf if choice < 0.8 else k[i]
            elif choice < 0.3:
                k[i] = np.inf
        return None if np.all(np.isinf(k)) else tuple(k)

    drive = float(10 ** (rng.uniform(5.5, 8) if joint.kind == "P" else rng.uniform(3.5, 6))) if joint.actuated else None
    linear, angular = values(slides, 5.5, 8.5), values(turns, 3, 6)
    if linear is None and angular is None and drive is None:
        return joint
    return replace(joint, stiffness=Stiffness(tuple(map(tuple, axes)), linear, angular, drive))


def random_assembly_errors(mechanism, rng):
    """Return assembly errors of some joints and beams, as :func:`finite_elements.solve` takes them."""
    found = {}
    for edge in mechanism.edges:
        if rng.random() < 0.3:
            found[edge.joint.name] = np.r_[1e-4 * rng.standard_normal(3), 1e-3 * rng.standard_normal(3)]
    for beam in mechanism.beams:
        if rng.random() < 0.3:
            found[beam.name] = (
                ("length", 1e-4 * rng.standard_normal()) if rng.random() < 0.5 else ("temperature", 20 * rng.random())
            )
    return found


def as_arguments(assembly_errors, written):
    """Return assembly errors as :func:`kinetostatics.analyze` takes them, by the names in the written file."""
    return {
        written.runs[name][-1] if name in written.runs else name: dict([value]) if isinstance(value, tuple) else value
        for name, value in assembly_errors.items()
    }


def write_randomly(mechanism, seed):
    """Write a mechanism in a random cut and spelling."""
    rng = np.random.default_rng(seed)
    for _ in range(30):
        cuts = random_cuts(mechanism, rng)
        if all(edge.joint.name in cuts for edge in mechanism.edges if springs_in_freedoms(edge.joint)):
            break
    else:  # no tree is left without them: these become rigid
        keep = {edge.joint.name for edge in mechanism.edges if not springs_in_freedoms(edge.joint) or edge.joint.name in cuts}
        edges = tuple(
            edge if edge.joint.name in keep else replace(edge, joint=replace(edge.joint, stiffness=None))
            for edge in mechanism.edges
        )
        mechanism = replace(mechanism, edges=edges)
    file = write_mechanism(
        mechanism, cuts=cuts, twirl=seed if rng.random() < 0.8 else None, whole=bool(rng.integers(2)), piece=int(rng.integers(3)),
        flip=bool(rng.integers(2)), shuffle=seed if rng.random() < 0.5 else None,
    )  # fmt: skip
    return mechanism, file
