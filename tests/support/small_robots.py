"""Robots for the tests, described by points and axes in the world at zero and written as robot files in any cut.

A :class:`Spec` holds serial limbs of joints and links; :func:`write` turns it into a robot file with every loop cut where the
caller wants, universal, spherical and cylindrical joints as one closure or as runs, link frames turned at random or not. All
joints at zero is the pose in which the numbers of the spec hold, and closes the loops exactly. Robots of any other shape are in
:mod:`mechanisms`.
"""

from dataclasses import dataclass, replace

import numpy as np
from mechanisms import (
    NU,
    ORIGIN,
    RHO,
    Beam,
    E,
    Edge,
    Joint,
    Link,
    Mechanism,
    Section,
    across,
    circle,
    random_rotation,
    tube,
    unit,
    write_mechanism,
)

__all__ = ["NU", "RHO", "E", "Section", "random_rotation", "tube"]


@dataclass(frozen=True)
class Limb:
    joints: tuple
    links: tuple


@dataclass(frozen=True)
class Spec:
    limbs: tuple
    beams: tuple
    o: tuple = ORIGIN
    mass: float = 0.0
    com: tuple = ORIGIN
    extra: str = ""
    name: str = "small"


# ---- writing -------------------------------------------------------------------------------------------------------------


def write(spec, *, tree=0, cuts=None, whole=True, piece=0, twirl=None, right=False, flip=False, order=None):
    """Write a spec as a robot file.

    Args:
        spec: the robot.
        tree: the limb that carries the platform in the tree; it has no cut.
        cuts: for each limb the position of the joint where it is cut (that of ``tree`` is not used); default: the last.
        whole: whether a universal, spherical or cylindrical joint at a cut is one closure; else a run, cut at ``piece``.
        piece: see ``whole``.
        twirl: a seed: turn the link frames at random.
        right: turn them by right angles only.
        flip: exchange predecessor and successor of the loops.
        order: in which order the limbs are written.
    """
    order = range(len(spec.limbs)) if order is None else list(order)
    cut = set()
    for number, limb in enumerate(spec.limbs):
        if number != tree:
            cut.add(limb.joints[(-1 if cuts is None else cuts[number]) % len(limb.joints)].name)
    return write_mechanism(mechanism_of(spec, order), cuts=cut, whole=whole, piece=piece, twirl=twirl, right=right, flip=flip)


def mechanism_of(spec, order=None):
    """Return a spec as joints between links, its limbs in the order of ``order``."""
    limbs = [spec.limbs[k] for k in (range(len(spec.limbs)) if order is None else order)]
    edges = []
    for limb in limbs:
        names = ["base", *(link.name for link in limb.links), "platform"]
        edges += [Edge(joint, *names[k : k + 2]) for k, joint in enumerate(limb.joints)]
    links = tuple(link for limb in limbs for link in limb.links)
    place = {link.name: number for number, link in enumerate(links)}
    beams = tuple(sorted(spec.beams, key=lambda beam: place[beam.link]))
    return Mechanism(tuple(edges), links, beams, spec.o, spec.mass, spec.com, spec.extra, spec.name)


def write_randomly(spec, rng, seed):
    """Write a spec in a random cut, order and spelling."""
    count = len(spec.limbs)
    return write(
        spec, tree=int(rng.integers(count)), cuts=[int(rng.integers(len(limb.joints))) for limb in spec.limbs], twirl=seed,
        whole=bool(rng.integers(2)), piece=int(rng.integers(3)), flip=bool(rng.integers(2)), order=rng.permutation(count),
    )  # fmt: skip


def robot_of(spec, **options):
    return write(spec, **options).robot()


# ---- transformations -----------------------------------------------------------------------------------------------------


def _moved(spec, point, polar, axial):
    """Return a spec with maps applied to points, to directions, and to rotation axes."""

    def joint(j):
        turn = axial if j.kind in "RUS" else polar  # a cylindrical joint's turn is passive: its sign does not matter
        return replace(j, centre=tuple(point(j.centre)), axis=tuple(turn(j.axis)), axis2=tuple(turn(j.axis2)))

    limbs = tuple(
        Limb(tuple(map(joint, limb.joints)), tuple(replace(k, com=tuple(point(k.com))) for k in limb.links))
        for limb in spec.limbs
    )
    beams = tuple(b if b.y_axis is None else replace(b, y_axis=tuple(polar(b.y_axis))) for b in spec.beams)
    return replace(spec, limbs=limbs, beams=beams, o=tuple(point(spec.o)), com=tuple(point(spec.com)))


def rotated(spec, R):
    """Return the whole robot turned about the world's origin."""
    R = np.asarray(R)

    def turn(v):
        return R @ np.asarray(v, dtype=float)

    return _moved(spec, turn, turn, turn)


def mirrored(spec):
    """Return the mirror image in the plane x = 0, with the same joint coordinates."""
    M = np.array([-1.0, 1.0, 1.0])
    return _moved(spec, lambda v: M * v, lambda v: M * v, lambda v: -M * v)


def on_a_grid(spec, step):
    """Return a spec whose joints lie at multiples of ``step`` [m] with axes along x, y and z: much is parallel or meets."""

    def point(v):
        return step * np.round(np.asarray(v) / step)

    def along(v):
        k = int(np.argmax(np.abs(v)))
        return np.sign(v[k]) * np.eye(3)[k]

    def joint(j):
        axis, axis2 = along(j.axis), along(j.axis2)
        if j.kind == "U" and abs(axis @ axis2) > 0.5:
            axis2 = np.roll(axis, 1)
        return replace(j, centre=tuple(point(j.centre)), axis=tuple(axis), axis2=tuple(axis2))

    limbs = tuple(replace(limb, joints=tuple(map(joint, limb.joints))) for limb in spec.limbs)
    return replace(spec, limbs=limbs)


def enlarged(spec, times):
    """Return a spec with all distances so many times as large; sections and masses stay."""
    return _moved(spec, lambda v: np.asarray(v) * times, np.asarray, np.asarray)


def in_millimetres(spec):
    """Return the same robot in mm, N and tonnes (gravity then is in mm/s²)."""
    grown = enlarged(spec, 1000.0)
    limbs = tuple(replace(limb, links=tuple(replace(k, mass=k.mass / 1000) for k in limb.links)) for limb in grown.limbs)
    beams = tuple(
        replace(
            b,
            E=b.E / 1e6,
            density=None if b.density is None else b.density / 1e12,
            section=Section(b.section.area * 1e6, b.section.I_y * 1e12, b.section.I_z * 1e12, b.section.J * 1e12),
            y_axis=b.y_axis or any_across(spec, b),
        )
        for b in grown.beams
    )
    return replace(grown, limbs=limbs, beams=beams, mass=grown.mass / 1000)


def any_across(spec, beam):
    """Return a direction across a beam."""
    joints = {j.name: j for limb in spec.limbs for j in limb.joints}
    along = np.asarray(joints[beam.end].centre, dtype=float) - joints[beam.start].centre
    if not np.any(along):
        raise ValueError("the beam has no length at zero")
    return tuple(across(unit(along))[0])


def split(spec, n):
    """Return a spec whose beams, telescopes excepted, are cut into n equal ones joined by fixed joints."""
    beams, limbs = [], []
    cut = {}
    for beam in spec.beams:
        limb = next(item for item in spec.limbs if any(k.name == beam.link for k in item.links))
        names = [j.name for j in limb.joints]
        position = [k.name for k in limb.links].index(beam.link)
        if names.index(beam.end) - names.index(beam.start) != 1:
            beams.append(beam)
            continue
        start, end = (np.asarray(limb.joints[names.index(x)].centre, dtype=float) for x in (beam.start, beam.end))
        joints, links = [], []
        y_axis = beam.y_axis
        mass = limb.links[position].mass / n
        for k in range(n):
            inner = beam.start if k == 0 else f"{beam.name}_f{k}"
            outer = beam.end if k == n - 1 else f"{beam.name}_f{k + 1}"
            link = beam.link if k == 0 else f"{beam.link}_part{k + 1}"
            links.append(Link(link, mass, tuple(start + (end - start) * (k + 0.5) / n)))
            if k:
                joints.append(Joint(inner, "F", tuple(start + (end - start) * k / n)))
            name = beam.name if k == 0 else f"{beam.name}_part{k + 1}"
            beams.append(replace(beam, name=name, link=link, start=inner, end=outer, y_axis=y_axis))
        cut[beam.link] = (joints, links)
    for limb in spec.limbs:
        joints, links = [limb.joints[0]], []
        for k, link in enumerate(limb.links):
            more_joints, more_links = cut.get(link.name, ([], [link]))
            links += more_links
            joints += [*more_joints, limb.joints[k + 1]]
        limbs.append(Limb(tuple(joints), tuple(links)))
    return replace(spec, limbs=tuple(limbs), beams=tuple(beams))


def with_beams(spec, **changes):
    """Return a spec with all its beams changed; a value may be a function of the beam."""
    return replace(
        spec,
        beams=tuple(
            replace(b, **{key: value(b) if callable(value) else value for key, value in changes.items()}) for b in spec.beams
        ),
    )


def with_link_masses(spec):
    """Return a spec whose beams, telescopes excepted, get their weight from the links' own masses."""
    joints = {j.name: j for limb in spec.limbs for j in limb.joints}
    own = {}
    for b in spec.beams:
        start, end = (np.asarray(joints[x].centre, dtype=float) for x in (b.start, b.end))
        own[b.link] = (b.density * b.section.area * np.linalg.norm(end - start), tuple((start + end) / 2))
    limbs = tuple(
        replace(limb, links=tuple(Link(k.name, *own.get(k.name, (k.mass, k.com))) for k in limb.links)) for limb in spec.limbs
    )
    return replace(with_beams(spec, density=None), limbs=limbs)


# ---- the robots ----------------------------------------------------------------------------------------------------------


def cantilever(length=1.0, direction=(1, 0, 0), section=None, **beam):
    """One beam, fixed to the base at the world's origin, the platform at its end."""
    tip = tuple(length * unit(direction))
    limb = Limb((Joint("root", "F", ORIGIN), Joint("tip", "F", tip)), (Link("arm"),))
    return Spec((limb,), (Beam("arm", "arm", "root", "tip", section or circle(0.05), **beam),), o=tip, com=tip)


def locked_chain(points, axes, section=None, mass=0.0, **beam):
    """Return beams between points, with actuated (locked) revolute joints at all points but the last, where the platform is."""
    joints = [Joint(f"turn_{k + 1}", "R", tuple(points[k]), tuple(axis), actuated=True) for k, axis in enumerate(axes)]
    joints.append(Joint("tip", "F", tuple(points[-1])))
    links = [Link(f"arm_{k}") for k in range(1, len(points))]
    beams = [
        Beam(f"arm_{k}", f"arm_{k}", joints[k - 1].name, joints[k].name, section or circle(0.05), **beam)
        for k in range(1, len(points))
    ]
    return Spec((Limb(tuple(joints), tuple(links)),), tuple(beams), o=tuple(points[-1]), mass=mass, com=tuple(points[-1]))


def portal(height=1.0, width=0.8, section=None, mass=0.0, **beam):
    """Two columns, fixed to the base and to a rigid platform on top."""
    limbs, beams = [], []
    for k, x in ((1, -width / 2), (2, width / 2)):
        joints = (Joint(f"foot_{k}", "F", (x, 0, 0)), Joint(f"head_{k}", "F", (x, 0, height)))
        limbs.append(Limb(joints, (Link(f"column_{k}"),)))
        beams.append(Beam(f"column_{k}", f"column_{k}", f"foot_{k}", f"head_{k}", section or circle(0.05), **beam))
    top = (0.0, 0.0, height)
    return Spec(tuple(limbs), tuple(beams), o=top, mass=mass, com=top)


def gough_points(seed=3):
    """Return base points, platform points (6, 3) and o of a Gough platform without symmetry."""
    rng = np.random.default_rng(seed)
    near, far = np.radians([-18, 18, 102, 138, 222, 258]), np.radians([-48, 48, 72, 168, 192, 288])
    base = np.c_[0.6 * np.cos(near), 0.6 * np.sin(near), np.zeros(6)]
    top = np.c_[0.35 * np.cos(far), 0.35 * np.sin(far), np.full(6, 0.7)]
    o = np.array([0.02, -0.01, 0.73])
    return base + 0.03 * rng.standard_normal((6, 3)), top + 0.03 * rng.standard_normal((6, 3)), o


def gough(inner="U", telescopic=True, section=None, mass=12.0, seed=3, **beam):
    """6-UPS or 6-SPS (``inner``): struts telescopic, or of constant length on an actuated slide at their foot."""
    base, top, o = gough_points(seed)
    limbs, beams = [], []
    for k in range(6):
        n, along = k + 1, unit(top[k] - base[k])
        first, second = across(along)
        foot, head = tuple(base[k]), tuple(top[k])
        slide = Joint(f"slide_{n}", "P", head if telescopic else foot, tuple(along), actuated=True)
        joints = (Joint(f"foot_{n}", inner, foot, tuple(first), tuple(second)), slide, Joint(f"head_{n}", "S", head))
        limbs.append(Limb(joints, (Link(f"cylinder_{n}"), Link(f"rod_{n}"))))
        start = f"foot_{n}" if telescopic else f"slide_{n}"
        beams.append(Beam(f"rod_{n}", f"rod_{n}", start, f"head_{n}", section or circle(0.03), **beam))
    return Spec(tuple(limbs), tuple(beams), o=tuple(o), mass=mass, com=tuple(o + np.array([0.03, 0.02, 0.01])))


def puu3(section=None, lean=0.3, height=0.8, radius=0.2, mass=5.0, **beam):
    """Symmetric 3-PUU: vertical actuated rails, rods between universal joints with parallel axes; a translating platform."""
    limbs, beams = [], []
    for k in range(3):
        n, a = k + 1, 2 * np.pi * k / 3
        out, side = np.array([np.cos(a), np.sin(a), 0]), np.array([-np.sin(a), np.cos(a), 0])
        head = radius * out + [0, 0, height]
        foot = (radius + lean) * out
        along = unit(head - foot)
        second = np.cross(side, along)  # both universal joints have it: the rod's cross axes are parallel
        joints = (
            Joint(f"rail_{n}", "P", tuple(foot), (0, 0, 1), actuated=True),
            Joint(f"lower_{n}", "U", tuple(foot), tuple(side), tuple(second)),
            Joint(f"upper_{n}", "U", tuple(head), tuple(second), tuple(side)),
        )
        limbs.append(Limb(joints, (Link(f"slider_{n}", 0.5, tuple(foot)), Link(f"rod_{n}"))))
        beams.append(Beam(f"rod_{n}", f"rod_{n}", f"lower_{n}", f"upper_{n}", section or circle(0.03), **beam))
    top = (0.0, 0.0, height)
    return Spec(tuple(limbs), tuple(beams), o=top, mass=mass, com=top)


def stepped_beam(lengths=(0.6, 0.4), sections=None, **beam):
    """Beams of different sections, joined by fixed joints along x, clamped at the origin."""
    sections = sections or (circle(0.06), circle(0.04))
    x = np.concatenate([[0], np.cumsum(lengths)])
    joints = tuple(Joint(f"step_{k}", "F", (float(s), 0, 0)) for k, s in enumerate(x))
    links = tuple(Link(f"part_{k}") for k in range(1, len(x)))
    beams = tuple(Beam(f"part_{k}", f"part_{k}", f"step_{k - 1}", f"step_{k}", sections[k - 1], **beam) for k in range(1, len(x)))
    tip = (float(x[-1]), 0.0, 0.0)
    return Spec((Limb(joints, links),), beams, o=tip, com=tip)


def four_bar(mass=3.0, **beam):
    """A planar four-bar linkage (axes along y): the coupler is the platform; one crank is actuated. Overconstrained."""
    y = (0, 1, 0)
    limbs, beams = [], []
    for n, foot, head, actuated in ((1, (0, 0, 0), (0.1, 0, 0.5), True), (2, (0.8, 0, 0), (0.9, 0, 0.7), False)):
        joints = (Joint(f"foot_{n}", "R", foot, y, actuated=actuated), Joint(f"head_{n}", "R", head, y))
        limbs.append(Limb(joints, (Link(f"crank_{n}"),)))
        beams.append(Beam(f"crank_{n}", f"crank_{n}", f"foot_{n}", f"head_{n}", circle(0.03), **beam))
    return Spec(tuple(limbs), tuple(beams), o=(0.5, 0, 0.62), mass=mass, com=(0.45, 0.0, 0.65))


def planar_3rrr(mass=4.0, **beam):
    """Planar 3-RRR in the horizontal plane (axes along z), actuated at the base. Overconstrained."""
    limbs, beams = [], []
    for k in range(3):
        n, a = k + 1, 2 * np.pi * k / 3 + 0.1 * k
        foot = 0.6 * np.array([np.cos(a), np.sin(a), 0])
        head = 0.2 * np.array([np.cos(a - 0.8), np.sin(a - 0.8), 0])
        elbow = foot + 0.45 * np.array([-np.sin(a), np.cos(a), 0])
        joints = tuple(
            Joint(f"{name}_{n}", "R", tuple(p), (0, 0, 1), actuated=name == "foot")
            for name, p in (("foot", foot), ("elbow", elbow), ("head", head))
        )
        limbs.append(Limb(joints, (Link(f"upper_{n}"), Link(f"lower_{n}"))))
        beams.append(Beam(f"upper_{n}", f"upper_{n}", f"foot_{n}", f"elbow_{n}", circle(0.03), **beam))
        beams.append(Beam(f"lower_{n}", f"lower_{n}", f"elbow_{n}", f"head_{n}", circle(0.025), **beam))
    return Spec(tuple(limbs), tuple(beams), mass=mass, com=(0.01, 0.02, 0.03))


def rps3(**beam):
    """The paper's 3RPS as a spec."""
    limbs, beams = [], []
    height = float(np.sqrt(0.55**2 - 0.1**2))
    for n, azimuth in ((1, 0.0), (2, -2 * np.pi / 3), (3, 2 * np.pi / 3)):
        out, side = np.array([np.cos(azimuth), np.sin(azimuth), 0]), np.array([-np.sin(azimuth), np.cos(azimuth), 0])
        foot, head = 0.3 * out, 0.2 * out + [0, 0, height]
        joints = (
            Joint(f"revolute_{n}", "R", tuple(foot), tuple(side)),
            Joint(f"prismatic_{n}", "P", tuple(head), tuple(unit(head - foot)), actuated=True),
            Joint(f"spherical_{n}", "S", tuple(head)),
        )
        limbs.append(Limb(joints, (Link(f"cylinder_{n}"), Link(f"rod_{n}"))))
        data = {"density": 7820.0, **beam}
        beams.append(Beam(f"rod_{n}", f"rod_{n}", f"revolute_{n}", f"spherical_{n}", circle(0.1), **data))
    top = (0.0, 0.0, height)
    return Spec(tuple(limbs), tuple(beams), o=top, mass=float(np.pi * 0.04 * 0.02 * 7820), com=top, name="rps3")


def pru2_upr(**beam):
    """The paper's 2PRU-UPR as a spec."""
    x, y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    top = np.array([0, 0, 0.6])
    limbs, beams = [], []
    for n, side in ((1, 1.0), (2, -1.0)):
        head = np.array([0, 0.25 * side, 0.6])
        foot = np.array([0, side * (0.25 + np.sqrt(0.7**2 - 0.6**2)), 0])
        joints = (
            Joint(f"prismatic_{n}", "P", tuple(foot), (0, side, 0), actuated=True),
            Joint(f"revolute_{n}", "R", tuple(foot), x),
            Joint(f"universal_{n}", "U", tuple(head), x, y),
        )
        limbs.append(Limb(joints, (Link(f"slider_{n}"), Link(f"rod_{n}"))))
        beams.append(Beam(f"rod_{n}", f"rod_{n}", f"revolute_{n}", f"universal_{n}", circle(0.06), **beam))
    foot, head = np.array([0.5, 0, 0]), np.array([0.25, 0, 0.6])
    joints = (
        Joint("universal_3", "U", tuple(foot), x, y),
        Joint("prismatic_3", "P", tuple(head), tuple(unit(head - foot)), actuated=True),
        Joint("revolute_3", "R", tuple(head), y),
    )
    limbs.append(Limb(joints, (Link("cylinder_3"), Link("rod_3"))))
    beams.append(Beam("rod_3", "rod_3", "universal_3", "revolute_3", circle(0.06), **beam))
    com = (0.25 / 3, 0.0, 0.6)
    return Spec(tuple(limbs), tuple(beams), o=tuple(top), mass=0.25**2 * 0.05 * 7850, com=com, name="pru2_upr")


def random_spec(kinds, seed):
    """Return a robot of random geometry.

    Args:
        kinds: for each limb its joints base to platform, e.g. ``["Rpus", "PUR"]``; a small letter drives an R or P.
        seed: of everything else: points, axes, sections, masses, which links bend.
    """
    rng = np.random.default_rng(seed)
    limbs, beams = [], []
    for n, letters in enumerate(kinds, 1):
        angle = 2 * np.pi * n / len(kinds) + 0.3 * rng.standard_normal()
        foot = np.array([0.6 * np.cos(angle), 0.6 * np.sin(angle), 0]) + 0.1 * rng.standard_normal(3)
        head = np.array([0.3 * np.cos(angle), 0.3 * np.sin(angle), 0.8]) + 0.1 * rng.standard_normal(3)
        joints, links = [], []
        count = len(letters)
        for k, letter in enumerate(letters):
            s = k / max(count - 1, 1)
            centre = foot + s * (head - foot) + (0.15 * rng.standard_normal(3) if 0 < s < 1 else 0.0)
            axis, axis2 = unit(rng.standard_normal(3)), unit(rng.standard_normal(3))
            if letter.upper() == "U" and rng.random() < 0.7:
                axis2 = unit(np.cross(axis, axis2))
            actuated = letter.islower() and letter.upper() in "RP"
            joints.append(Joint(f"j{n}_{k}", letter.upper(), tuple(centre), tuple(axis), tuple(axis2), actuated=bool(actuated)))
        elastic = rng.random(count - 1) < 0.75
        if count > 1 and not elastic.any():
            elastic[rng.integers(count - 1)] = True
        for k in range(count - 1):
            name = f"k{n}_{k}"
            a, b = (np.asarray(joints[i].centre) for i in (k, k + 1))
            com = tuple((a + b) / 2 + 0.05 * rng.standard_normal(3))
            if not elastic[k]:
                links.append(Link(name, float(rng.choice([0.0, 2.0])), com))
                continue
            d = 0.02 + 0.04 * rng.random()
            section, y_axis = circle(d), None
            if rng.random() < 0.5:
                A, Iy, Iz = d**2, d**4 / 12, d**4 / 12 * (1 + rng.random())
                section, y_axis = Section(A, Iy, Iz, 0.14 * d**4), tuple(unit(rng.standard_normal(3)))
            beams.append(
                Beam(name, name, joints[k].name, joints[k + 1].name, section, kappa=float(rng.choice([0.85, 1.0, np.inf])),
                     density=float(rng.choice([0.0, 2700.0, 7850.0])), E=float(rng.choice([70e9, 200e9])), y_axis=y_axis)
            )  # fmt: skip
            links.append(Link(name))
            if not beams[-1].density:  # an inertia as from CAD, its centre beside the beam
                links[-1], beams[-1] = Link(name, 2.0, com), replace(beams[-1], density=None)
        limbs.append(Limb(tuple(joints), tuple(links)))
    o = np.array([0, 0, 0.8]) + 0.1 * rng.standard_normal(3)
    com = o + 0.1 * rng.standard_normal(3)
    return Spec(tuple(limbs), tuple(beams), o=tuple(o), mass=float(5 * rng.random()), com=tuple(com), name="random")


#: Serial limbs as machines have them, base to platform; a small letter is an actuated joint.
LIMBS = ["RpS", "UpS", "pUS", "rUS", "pRS", "rRS", "pUU", "rUU", "UpU", "SpU", "pRU", "UpR", "SpR", "pRRR", "rRRR", "CrS", "pCS",
         "RpU", "S", "CpU", "rCU", "RRpU", "p", "r", "rrp", "US", "SR"]  # fmt: skip
FREEDOMS = {"R": 1, "P": 1, "U": 2, "C": 2, "S": 3}


def wrenches(limb):
    """How many constraint wrenches the limb has, if its axes are in general position."""
    return max(6 - sum(FREEDOMS.get(letter, 0) for letter in limb), 0)
