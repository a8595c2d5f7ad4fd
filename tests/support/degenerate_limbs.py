"""Robots whose limbs are not at one pose what they are elsewhere: their joints are dependent there."""

import itertools

from mechanisms import Beam, Edge, Joint, Link, Mechanism, circle

X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)
#: An elastic arm with six actuators, which holds the platform wherever it is and lets the other limb take any pose.
POINTS = [(0, -1.0, 0), (0.1, -1.05, 0.3), (-0.1, -0.9, 0.5), (0.2, -0.7, 0.6), (0.1, -0.5, 0.9), (0, -0.3, 0.8), (0, -0.1, 0.85)]
AXES = [Z, X, Y, X, Z, (0.3, 0.5, 0.8)]


def held(edges, links, beams, o=(0, 0, 0.8)):
    """Return a robot of that arm and another limb, and its file; ``edges`` are joints with the links inside and outside."""
    arm = [Joint(f"a{k}", "R", POINTS[k], AXES[k], actuated=True) for k in range(6)] + [Joint("a6", "F", POINTS[6])]
    names = ["base", *(f"arm{k}" for k in range(6)), "platform"]
    own = [Edge(joint, *names[k : k + 2]) for k, joint in enumerate(arm)]
    bars = [Beam(f"arm{k}", f"arm{k}", f"a{k}", f"a{k + 1}", circle(0.05)) for k in range(6)]
    bars += [Beam(link, link, start, end, circle(0.03)) for link, (start, end) in beams.items()]
    return Mechanism(
        (*own, *(Edge(*edge) for edge in edges)), (*map(Link, names[1:-1]), *links), tuple(bars), o, 3.0, (0.02, 0.03, 0.83)
    )


def serial(*joints, weights=None):
    """Return such a robot whose other limb is one chain, with a beam wherever two centres lie apart."""
    names = ["base", *(f"x{k}" for k in range(len(joints) - 1)), "platform"]
    edges = [(joint, *names[k : k + 2]) for k, joint in enumerate(joints)]
    ends = {f"x{k}": (a.name, b.name) for k, (a, b) in enumerate(itertools.pairwise(joints)) if a.centre != b.centre}
    return held(edges, [Link(name, *(weights or {}).get(name, ())) for name in names[1:-1]], ends)


def flat_parallelogram(height=0.4):
    """Two bars hinged to the base and to a frame, all hinges on one vertical line; a spherical joint and a strut above."""
    at = [Joint(f"r{k}", "R", (0.5, 0, z), Y) for k, z in enumerate((0, height, 0.2, 0.2 + height))]
    edges = [(at[0], "base", "x0"), (at[1], "x0", "frame"), (at[2], "base", "x1"), (at[3], "x1", "frame")]
    edges += [(Joint("s0", "S", (0.5, 0, 0.7)), "frame", "x2"), (Joint("s1", "U", (0.1, 0.2, 0.8), X, Y), "x2", "platform")]
    beams = {"x0": ("r0", "r1"), "x1": ("r2", "r3"), "x2": ("s0", "s1")}
    return held(edges, [Link(name) for name in ("x0", "x1", "frame", "x2")], beams)


def joints(letters, points, axes, axes2=None, actuated=()):
    return [
        Joint(f"j{k}", letter, point, axis, X if axes2 is None else axes2[k], actuated=k in actuated)
        for k, (letter, point, axis) in enumerate(zip(letters, points, axes, strict=True))
    ]


FOOT, KNEE, HEAD = (0.5, 0, 0), (0.5, 0, 0.4), (0.5, 0, 0.8)
DEPENDENT = {
    "a stretched leg with parallel hinges": serial(*joints("PRRR", (FOOT, FOOT, KNEE, HEAD), (X, Y, Y, Y), actuated=[0])),
    "a stretched leg between balls": serial(*joints("SRS", (FOOT, KNEE, HEAD), (Z, Y, Z))),
    "a leg folded onto a cross": serial(*joints("RRU", (FOOT, KNEE, FOOT), (Y, Y, Y))),
    "a leg folded onto a ball": serial(*joints("RRS", (FOOT, KNEE, FOOT), (Y, Y, Z))),
    "crosses on one line": serial(*joints("UUS", (FOOT, KNEE, HEAD), (X, Z, Z), (Z, X, X))),
    "parallel slides": serial(*joints("PRPR", (FOOT, FOOT, FOOT, (0.5, 0.2, 0.2)), (Y, X, Y, X), actuated=[1])),
    "parallel slides in the platform joint": serial(*joints("RPRP", (FOOT, HEAD, HEAD, HEAD), (Z, Y, X, Y))),
    "a flat parallelogram": flat_parallelogram(),
}


def cuts_of(mechanism):
    return {edge.joint.name for edge in mechanism.edges[7:] if edge.outer == "platform" or edge.joint.name == "r3"}
