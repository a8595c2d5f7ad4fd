"""Robots for the tests, described by points and axes in the world at zero and written as robot files in any cut.

A :class:`Spec` holds limbs of joints and links; :func:`write` turns it into a robot file with every loop cut where the caller
wants, universal, spherical and cylindrical joints as one closure or as runs, link frames turned at random or not. All joints
at zero is the pose in which the numbers of the spec hold, and closes the loops exactly.
"""

from dataclasses import dataclass, field, replace

import numpy as np

import kinetostatics as ks
from kinetostatics.robot_file import parse_robot_text

E, NU, RHO = 200e9, 0.3, 7850.0
ORIGIN = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Joint:
    """Kind is one of R P U S C F; C is cylindrical, F is fixed. ``axis2`` is the second axis of U."""

    name: str
    kind: str
    centre: tuple
    axis: tuple = (0.0, 0.0, 1.0)
    axis2: tuple = (1.0, 0.0, 0.0)
    driven: bool = False


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


@dataclass
class Written:
    text: str
    #: frame (4, 4) of every link at zero
    frames: dict = field(default_factory=dict)
    #: names of the elementary joints of every joint of the spec, base to platform
    runs: dict = field(default_factory=dict)

    def robot(self):
        return ks.Robot(parse_robot_text(self.text))


# ---- sections ------------------------------------------------------------------------------------------------------------


def circle(d):
    area, bending = np.pi * d**2 / 4, np.pi * d**4 / 64
    return Section(area, bending, bending, 2 * bending, f'<circle diameter="{d!r}"/>')


def tube(d, inner):
    area, bending = np.pi * (d**2 - inner**2) / 4, np.pi * (d**4 - inner**4) / 64
    return Section(area, bending, bending, 2 * bending, f'<tube outer_diameter="{d!r}" inner_diameter="{inner!r}"/>')


# ---- writing -------------------------------------------------------------------------------------------------------------


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


def _across(axis):
    helper = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = unit(np.cross(axis, helper))
    return first, np.cross(axis, first)


def _elementary(joint, whole):
    """Return a joint as single-freedom joints, base to platform; ``whole`` leaves it in one piece."""
    if joint.kind in "RPF" or whole:
        return [joint]
    axis = unit(joint.axis)
    if joint.kind == "U":
        parts = [("R", axis), ("R", unit(joint.axis2))]
    elif joint.kind == "C":
        parts = [("P", axis), ("R", axis)]
    else:
        second, third = _across(axis)
        parts = [("R", axis), ("R", second), ("R", third)]
    return [Joint(f"{joint.name}_{k}", kind, joint.centre, tuple(direction)) for k, (kind, direction) in enumerate(parts, 1)]


KINDS = {"R": "revolute", "P": "prismatic", "F": "fixed", "U": "universal", "S": "spherical", "C": "cylindrical"}


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
    rng = None if twirl is None else np.random.default_rng(twirl)
    frames = {"base": np.eye(4)}
    links_xml, joints_xml, loops_xml = {"base": ""}, [], []
    runs, ends, driven = {}, {}, []
    masses = {link.name: (link.mass, link.com) for limb in spec.limbs for link in limb.links}
    masses["platform"] = (spec.mass, spec.com)
    order = list(range(len(spec.limbs))) if order is None else list(order)

    def frame_at(centre):
        F = np.eye(4)
        F[:3, 3] = centre
        if rng is not None:
            F[:3, :3] = right_angled(rng) if right else random_rotation(rng)
        return F

    def tree_joint(joint, parent, child, sign):
        F = frame_at(joint.centre)
        frames[child] = F
        rel = np.linalg.inv(frames[parent]) @ F
        axis = "" if joint.kind == "F" else f'<axis xyz="{numbers(F[:3, :3].T @ (sign * unit(joint.axis)))}"/>'
        limit = "" if joint.kind == "F" else '<limit effort="0" velocity="0"/>'
        if joint.kind == "R":
            limit = '<limit lower="-10" upper="10" effort="0" velocity="0"/>'
        if joint.kind == "P":
            limit = '<limit lower="-1e6" upper="1e6" effort="0" velocity="0"/>'
        joints_xml.append(
            f'<joint name="{joint.name}" type="{KINDS[joint.kind]}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{numbers(rel[:3, 3])}" rpy="{numbers(rpy(rel[:3, :3]))}"/>{axis}{limit}</joint>'
        )
        links_xml[child] = ""

    def loop(joint, inner, outer):
        first, second, axis, axis2 = inner, outer, unit(joint.axis), unit(joint.axis2)
        if flip:
            first, second = outer, inner
            axis, axis2 = (axis2, axis) if joint.kind == "U" else (-axis, axis2)
        sides = []
        for tag, link in (("predecessor", first), ("successor", second)):
            back = np.linalg.inv(frames[link])
            point = back[:3, :3] @ joint.centre + back[:3, 3]
            sides.append(f'<{tag} link="{link}"><origin xyz="{numbers(point)}" rpy="{numbers(rpy(back[:3, :3]))}"/></{tag}>')
        axes = "" if joint.kind in "SF" else f'<axis xyz="{numbers(axis)}"/>'
        axes += f'<axis2 xyz="{numbers(axis2)}"/>' if joint.kind == "U" else ""
        loops_xml.append(f'<loop name="{joint.name}" type="{KINDS[joint.kind]}">{"".join(sides)}{axes}</loop>')

    chains = {}
    for number in order:
        limb = spec.limbs[number]
        cut = None if number == tree else (-1 if cuts is None else cuts[number]) % len(limb.joints)
        chain, names = [], ["base"]
        cut_at = None
        for k, joint in enumerate(limb.joints):
            parts = _elementary(joint, whole and k == cut)
            runs[joint.name] = [part.name for part in parts]
            if k == cut:
                cut_at = len(chain) + min(piece, len(parts) - 1)
            chain += parts
            names += [f"{part.name}_link" for part in parts[:-1]]
            names.append(limb.links[k].name if k < len(limb.links) else "platform")
            # the elementary joints next to the links, for the beams' ends
            ends[joint.name] = (parts[0].name, parts[-1].name)
            driven += [joint.name] if joint.driven else []
        chains[number] = (chain, names, cut_at)
    for number in [tree, *(k for k in order if k != tree)]:  # the platform must have its frame first
        chain, names, cut_at = chains[number]
        stop = len(chain) if cut_at is None else cut_at
        for k in range(stop):
            tree_joint(chain[k], names[k], names[k + 1], 1)
        if cut_at is not None:
            for k in range(len(chain) - 1, cut_at, -1):  # seen from the platform everything turns the other way
                tree_joint(chain[k], names[k + 1], names[k], -1)
    for number in order:
        chain, names, cut_at = chains[number]
        if cut_at is not None:
            loop(chain[cut_at], names[cut_at], names[cut_at + 1])

    def link_xml(name):
        mass, com = masses.get(name, (0.0, ORIGIN))
        if not mass:
            return f'<link name="{name}"/>'
        back = np.linalg.inv(frames[name])
        point = back[:3, :3] @ com + back[:3, 3]
        return (
            f'<link name="{name}"><inertial><origin xyz="{numbers(point)}"/><mass value="{float(mass)!r}"/>'
            '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>'
        )

    beams_xml = []
    positions = {joint.name: (n, k) for n, limb in enumerate(spec.limbs) for k, joint in enumerate(limb.joints)}
    place = {link.name: (n, k) for n, limb in enumerate(spec.limbs) for k, link in enumerate(limb.links)}
    by_limb = sorted(spec.beams, key=lambda beam: order.index(place[beam.link][0]))
    for beam in by_limb:
        link = place[beam.link][1]
        near = []
        for joint in (beam.start, beam.end):
            outward = positions[joint][1] > link  # the joint lies on the platform's side of the link
            near.append(ends[joint][0 if outward else 1])
        density = "" if beam.density is None else f' density="{beam.density!r}"'
        y = ""
        if beam.y_axis is not None:
            y = f' y_axis="{numbers(frames[beam.link][:3, :3].T @ unit(beam.y_axis))}"'
        beams_xml.append(
            f'<beam name="{beam.name}" link="{beam.link}" from="{near[0]}" to="{near[1]}" youngs_modulus="{beam.E!r}" '
            f'poisson_ratio="{beam.nu!r}" shear_coefficient="{beam.kappa!r}"{density}{y}>{beam.section.text}</beam>'
        )
    F = np.linalg.inv(frames["platform"])
    point = F[:3, :3] @ spec.o + F[:3, 3]
    written = list(links_xml)
    wanted = ["base", *(n for k in order for n in chains[k][1][1:] if n != "platform"), "platform"]
    assert sorted(wanted) == sorted(written)
    lines = [
        f'<robot name="{spec.name}">',
        *(link_xml(name) for name in wanted),
        *joints_xml,
        f'<platform link="platform"><origin xyz="{numbers(point)}" rpy="{numbers(rpy(F[:3, :3]))}"/></platform>',
        *loops_xml,
        *beams_xml,
        *(f'<transmission name="drive_{name}"><joint name="{name}"/></transmission>' for name in driven),
        spec.extra,
        "</robot>",
    ]
    return Written("\n".join(lines), frames, runs)


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


def in_millimetres(spec):
    """Return the same robot in mm, N and tonnes (gravity then is in mm/s²)."""
    grown = _moved(spec, lambda v: np.asarray(v) * 1000.0, np.asarray, np.asarray)
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
    return tuple(_across(unit(along))[0])


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
    """Return beams between points, with driven (locked) revolute joints at all points but the last, where the platform is."""
    joints = [Joint(f"turn_{k + 1}", "R", tuple(points[k]), tuple(axis), driven=True) for k, axis in enumerate(axes)]
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
    """6-UPS or 6-SPS (``inner``): struts telescopic, or of constant length on a driven slide at their foot."""
    base, top, o = gough_points(seed)
    limbs, beams = [], []
    for k in range(6):
        n, along = k + 1, unit(top[k] - base[k])
        first, second = _across(along)
        foot, head = tuple(base[k]), tuple(top[k])
        slide = Joint(f"slide_{n}", "P", head if telescopic else foot, tuple(along), driven=True)
        joints = (Joint(f"foot_{n}", inner, foot, tuple(first), tuple(second)), slide, Joint(f"head_{n}", "S", head))
        limbs.append(Limb(joints, (Link(f"cylinder_{n}"), Link(f"rod_{n}"))))
        start = f"foot_{n}" if telescopic else f"slide_{n}"
        beams.append(Beam(f"rod_{n}", f"rod_{n}", start, f"head_{n}", section or circle(0.03), **beam))
    return Spec(tuple(limbs), tuple(beams), o=tuple(o), mass=mass, com=tuple(o + np.array([0.03, 0.02, 0.01])))


def puu3(section=None, lean=0.3, height=0.8, radius=0.2, mass=5.0, **beam):
    """Symmetric 3-PUU: vertical driven rails, rods between universal joints with parallel axes; a translating platform."""
    limbs, beams = [], []
    for k in range(3):
        n, a = k + 1, 2 * np.pi * k / 3
        out, side = np.array([np.cos(a), np.sin(a), 0]), np.array([-np.sin(a), np.cos(a), 0])
        head = radius * out + [0, 0, height]
        foot = (radius + lean) * out
        along = unit(head - foot)
        second = np.cross(side, along)  # both universal joints have it: the rod's cross axes are parallel
        joints = (
            Joint(f"rail_{n}", "P", tuple(foot), (0, 0, 1), driven=True),
            Joint(f"lower_{n}", "U", tuple(foot), tuple(side), tuple(second)),
            Joint(f"upper_{n}", "U", tuple(head), tuple(second), tuple(side)),
        )
        limbs.append(Limb(joints, (Link(f"slider_{n}", 0.5, tuple(foot)), Link(f"rod_{n}"))))
        beams.append(Beam(f"rod_{n}", f"rod_{n}", f"lower_{n}", f"upper_{n}", section or circle(0.03), **beam))
    top = (0.0, 0.0, height)
    return Spec(tuple(limbs), tuple(beams), o=top, mass=mass, com=top)


def hanging_rod(length=2.0, section=None, **beam):
    """A rod that hangs from the base and carries a massless platform."""
    return cantilever(length, (0, 0, -1), section, **beam)


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
    """A planar four-bar linkage (axes along y): the coupler is the platform; one crank is driven. Overconstrained."""
    y = (0, 1, 0)
    limbs, beams = [], []
    for n, foot, head, driven in ((1, (0, 0, 0), (0.1, 0, 0.5), True), (2, (0.8, 0, 0), (0.9, 0, 0.7), False)):
        joints = (Joint(f"foot_{n}", "R", foot, y, driven=driven), Joint(f"head_{n}", "R", head, y))
        limbs.append(Limb(joints, (Link(f"crank_{n}"),)))
        beams.append(Beam(f"crank_{n}", f"crank_{n}", f"foot_{n}", f"head_{n}", circle(0.03), **beam))
    return Spec(tuple(limbs), tuple(beams), o=(0.5, 0, 0.62), mass=mass, com=(0.45, 0.0, 0.65))


def planar_3rrr(mass=4.0, **beam):
    """Planar 3-RRR in the horizontal plane (axes along z), driven at the base. Overconstrained."""
    limbs, beams = [], []
    for k in range(3):
        n, a = k + 1, 2 * np.pi * k / 3 + 0.1 * k
        foot = 0.6 * np.array([np.cos(a), np.sin(a), 0])
        head = 0.2 * np.array([np.cos(a - 0.8), np.sin(a - 0.8), 0])
        elbow = foot + 0.45 * np.array([-np.sin(a), np.cos(a), 0])
        joints = tuple(
            Joint(f"{name}_{n}", "R", tuple(p), (0, 0, 1), driven=name == "foot")
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
            Joint(f"prismatic_{n}", "P", tuple(head), tuple(unit(head - foot)), driven=True),
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
            Joint(f"prismatic_{n}", "P", tuple(foot), (0, side, 0), driven=True),
            Joint(f"revolute_{n}", "R", tuple(foot), x),
            Joint(f"universal_{n}", "U", tuple(head), x, y),
        )
        limbs.append(Limb(joints, (Link(f"slider_{n}"), Link(f"rod_{n}"))))
        beams.append(Beam(f"rod_{n}", f"rod_{n}", f"revolute_{n}", f"universal_{n}", circle(0.06), **beam))
    foot, head = np.array([0.5, 0, 0]), np.array([0.25, 0, 0.6])
    joints = (
        Joint("universal_3", "U", tuple(foot), x, y),
        Joint("prismatic_3", "P", tuple(head), tuple(unit(head - foot)), driven=True),
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
            driven = letter.islower() and letter.upper() in "RP"
            joints.append(Joint(f"j{n}_{k}", letter.upper(), tuple(centre), tuple(axis), tuple(axis2), driven=bool(driven)))
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
            links.append(Link(name))
            d = 0.02 + 0.04 * rng.random()
            section, y_axis = circle(d), None
            if rng.random() < 0.5:
                A, Iy, Iz = d**2, d**4 / 12, d**4 / 12 * (1 + rng.random())
                section, y_axis = Section(A, Iy, Iz, 0.14 * d**4), tuple(unit(rng.standard_normal(3)))
            beams.append(
                Beam(name, name, joints[k].name, joints[k + 1].name, section, kappa=float(rng.choice([0.85, 1.0, np.inf])),
                     density=float(rng.choice([0.0, 2700.0, 7850.0])), E=float(rng.choice([70e9, 200e9])), y_axis=y_axis)
            )  # fmt: skip
        limbs.append(Limb(tuple(joints), tuple(links)))
    o = np.array([0, 0, 0.8]) + 0.1 * rng.standard_normal(3)
    com = o + 0.1 * rng.standard_normal(3)
    return Spec(tuple(limbs), tuple(beams), o=tuple(o), mass=float(5 * rng.random()), com=tuple(com), name="random")
