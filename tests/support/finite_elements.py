"""An independent answer for the tests: every rigid link and both ends of every beam are nodes with six displacements; beams
are Timoshenko elements, joints are constraints with multipliers, elastic where they are, solved in one piece. It shares no code
with the package."""

from dataclasses import dataclass, field

import numpy as np
from mechanisms import Mechanism, path_to, unit
from small_robots import mechanism_of

#: Paths from base to platform that are tried before every direction that was not seen counts as impossible.
PATHS = 20_000


def skew(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def to_point(arm):
    """Return the (6, 6) map from a body's displacement to that of its point at ``arm``."""
    X = np.eye(6)
    X[:3, 3:] = -skew(arm)
    return X


def element(L, EA, GAy, GAz, GJ, EIy, EIz):
    """Return the (12, 12) stiffness of a beam along x, inner end first."""
    K = np.zeros((12, 12))

    def put(rows, block):
        K[np.ix_(rows, rows)] += block

    put([0, 6], EA / L * np.array([[1, -1], [-1, 1]]))
    put([3, 9], GJ / L * np.array([[1, -1], [-1, 1]]))
    for rows, EI, GA, s in (([1, 5, 7, 11], EIz, GAy, 1), ([2, 4, 8, 10], EIy, GAz, -1)):
        phi = 12 * EI / (GA * L**2) if np.isfinite(GA) else 0.0
        a = EI / ((1 + phi) * L**3)
        block = a * np.array([
            [12, 6 * L, -12, 6 * L],
            [6 * L, (4 + phi) * L**2, -6 * L, (2 - phi) * L**2],
            [-12, -6 * L, 12, -6 * L],
            [6 * L, (2 - phi) * L**2, -6 * L, (4 + phi) * L**2],
        ])  # fmt: skip
        turn = np.diag([1, s, 1, s])
        put(rows, turn @ block @ turn)
    return K


def even_moment(m, L, GA, EI_y, EI_z):
    """Return the nodal loads (12,) in beam axes that do the work of a moment ``m`` (3,) per length on the shape functions."""
    shares = {"y": 12 * EI_y / (GA * L**2), "z": 12 * EI_z / (GA * L**2)}
    sheared = {axis: phi / (1 + phi) for axis, phi in shares.items()}  # what rotates the sections without bending the line
    force = np.array([0, m[2] * (1 - sheared["z"]), -m[1] * (1 - sheared["y"])])
    moment = L / 2 * np.array([m[0], m[1] * sheared["y"], m[2] * sheared["z"]])
    return np.concatenate([-force, moment, force, moment])


def freedoms(joint, axis, axis2):
    """Return a joint's passive freedoms (6, k) as twists about its centre, from its axes as they are now."""
    turn, turn2, slide = np.r_[0, 0, 0, axis], np.r_[0, 0, 0, axis2], np.r_[axis, 0, 0, 0]
    plane = np.linalg.svd(np.array(axis)[None])[2][1:]
    found = {
        "R": [turn], "U": [turn, turn2], "P": [slide], "C": [slide, turn], "S": list(np.eye(6)[3:]), "F": [],
        "E": [*np.hstack([plane, np.zeros((2, 3))]), turn], "X": list(np.eye(6)),
    }  # fmt: skip
    return np.array([] if joint.actuated else found[joint.kind]).reshape(-1, 6).T


def elasticity(joint, S, frame, axis):
    """Return what is left of a joint's freedoms where springs hold some of them, and its compliance (6, 6) at its centre.

    Args:
        joint: the joint.
        S: (6, k) its freedoms.
        frame: (3, 3) the axes of its stiffnesses, now.
        axis: (3,) of an actuator's motion.
    """
    C = np.zeros((6, 6))
    s = joint.stiffness
    if s is None:
        return S, C
    for group, values in ((slice(0, 3), s.linear), (slice(3, 6), s.angular)):
        if values is None:
            continue
        held = [k for k in range(3) if 0 < values[k] < np.inf]
        C[group, group] += sum((np.outer(frame[:, k], frame[:, k]) / values[k] for k in held), np.zeros((3, 3)))
        count = int(np.sum(np.linalg.norm(S[group], axis=0) > 0.5))
        if count > 1 and joint.kind != "U":  # several directions of the frame, all or its x and y, are freedoms
            own = np.zeros((6, 3))
            own[group] = frame
            others = S[:, np.linalg.norm(S[group], axis=0) < 1e-12]
            S = np.hstack([others, own[:, [k for k in range(count) if k not in held]]])
        else:
            loose = np.ones(S.shape[1], dtype=bool)
            for column in range(S.shape[1]):
                part = S[group, column]
                if np.linalg.norm(part) > 0.5:
                    loose[column] = np.linalg.norm(part - frame[:, held] @ (frame[:, held].T @ part)) > 1e-9
            S = S[:, loose]
    if s.drive is not None:
        move = np.r_[axis, 0, 0, 0] if joint.kind == "P" else np.r_[0, 0, 0, axis]
        C += np.outer(move, move) / s.drive
    return S, C


def directions(edges, base, platform):
    """Return the directions, +1 and -1, in which paths that visit no node twice pass every edge on their way to the platform.

    Those of a ring that no path passes are all of +1, -1 and 0.

    Args:
        edges: name: (one node, other node).
        base, platform: two of the nodes.
    """
    found = {name: set() for name in edges}
    at = {}
    for name, (a, b) in edges.items():
        if a != b:
            at.setdefault(a, []).append((name, b, 1))
            at.setdefault(b, []).append((name, a, -1))
    count = 0

    def walk(node, seen, way):
        nonlocal count
        if node == platform:
            count += 1
            for name, sign in way:
                found[name].add(sign)
            return
        for name, other, sign in at.get(node, []):
            if other not in seen and count < PATHS:
                walk(other, seen | {other}, [*way, (name, sign)])

    walk(base, {base}, [])
    # what no path passes points away from what it hangs on; in a ring there is no saying
    for name, (a, b) in edges.items():
        if not found[name] and a != b:
            without = {key: ends for key, ends in edges.items() if key != name}
            for root, other in ((base, platform), (platform, base)):
                reached = _reached(without, root, other)
                if a in reached or b in reached:
                    found[name] = {1, -1, 0} if a in reached and b in reached else {1 if a in reached else -1}
                    break
    return found


def _reached(edges, root, stop):
    seen, queue = {root}, [root]
    while queue:
        here = queue.pop()
        for a, b in edges.values():
            for one, other in ((a, b), (b, a)):
                if one == here and other not in seen and other != stop:
                    seen.add(other)
                    queue.append(other)
    return seen


@dataclass
class Answer:
    """About o, world axes.

    Attributes:
        ends: displacements (2, 6) of the beams' ends.
        sections: (2, 6) what the outer part of a beam puts on its inner at both ends, about them.
        free: whether the platform can move though the actuators are locked.
        unbalanced, contradiction: parts of loads that nothing balances, of errors that rigid pieces cannot follow.
        gap: ratio between the smallest singular value kept and the largest dropped.
        sure: what no local freedom or self-stress changes.
        inward: the joints whose outer side, in the robot, is the inner one of their edge.
        backward: the beams that begin at their outer end.
        rings: joints and beams of rings that hang on base, platform or a limb without carrying the platform.
    """

    twist: np.ndarray
    compliance: np.ndarray
    joint_wrenches: dict
    ends: dict
    sections: dict
    free: bool
    unbalanced: float
    contradiction: float
    gap: float
    sure: dict
    inward: set = field(default_factory=set)
    backward: set = field(default_factory=set)
    rings: set = field(default_factory=set)
    system: tuple = ()  # frame, stiffness, constraints, forces on nodes, constraints and compliance by joint


class Frame:
    """Nodes, elements and constraints of a mechanism at a pose."""

    def __init__(self, mechanism, written, configuration):
        self.mechanism, self.written = mechanism, written
        self.now = {name: configuration.frame(name) @ np.linalg.inv(F) for name, F in written.frames.items()}
        self.positions = []
        self.of = {}  # link: [(joint by which it is entered or None, point at zero, node)]
        self.beam_nodes, self.beam_points = {}, {}
        self.o = self.point("platform", mechanism.o)
        self.platform, self.base = self.node(self.o), None
        carriers = {beam.link for beam in mechanism.beams}
        self.of["platform"] = [(None, None, self.platform)]
        self.of["base"] = [(None, None, self.base)]
        for link in mechanism.links:
            if link.name not in carriers:
                self.of[link.name] = [(None, None, self.node(self.point(link.name, link.com)))]
        joints = mechanism.joints
        for beam in mechanism.beams:
            ends, points = [], []
            for name in (beam.start, beam.end):
                owner, way = path_to(mechanism, beam.link, name)
                point = self.point(owner, joints[name].centre)
                entries = self.of.setdefault(beam.link, [])
                known = [n for _, p, n in entries if not way and p is not None and np.allclose(p, joints[name].centre, atol=1e-9)]
                if known:
                    ends.append(known[0])
                else:
                    ends.append(self.node(point))
                    entries.append((way[0].joint.name if way else None, None if way else joints[name].centre, ends[-1]))
                points.append(point)
            self.beam_nodes[beam.name], self.beam_points[beam.name] = ends, points
        self.sides = {}
        for edge in mechanism.edges:
            self.sides[edge.joint.name] = (self.node_of(edge.inner, edge.joint), self.node_of(edge.outer, edge.joint))
        self._orient()

    def node(self, p):
        self.positions.append(np.asarray(p, dtype=float))
        return len(self.positions) - 1

    def node_of(self, link, joint):
        """Return the node of a link to which a joint is fixed."""
        entries = self.of[link]
        for name, _, node in entries:
            if name == joint.name:
                return node
        for name, point, node in entries:
            if name is None and (point is None or np.allclose(point, joint.centre, atol=1e-9)):
                return node
        return entries[0][2]  # in the middle of a telescope

    def point(self, link, p):
        return self.now[link][:3, :3] @ np.asarray(p, dtype=float) + self.now[link][:3, 3]

    def direction(self, link, a):
        return self.now[link][:3, :3] @ unit(a)

    def _orient(self):
        """Find the joints and beams that lie the other way round between base and platform."""
        same = {None: -1}
        carriers = {beam.link for beam in self.mechanism.beams}

        def rigid(edge):
            s = edge.joint.stiffness
            elastic = s is not None and (s.linear or s.angular)
            return edge.joint.kind == "F" and not {edge.inner, edge.outer} & carriers and not elastic

        for link, number in (("base", -1), ("platform", self.platform)):
            queue = [link]
            while queue:
                here = queue.pop()
                for edge in self.mechanism.edges:
                    if here in (edge.inner, edge.outer) and rigid(edge):
                        node = self.of[edge.other(here)][0][2]
                        if node is not None and node != self.platform and node not in same:
                            same[node] = number
                            queue.append(edge.other(here))
        edges = {("joint", name): pair for name, pair in self.sides.items()}
        edges |= {("beam", name): tuple(pair) for name, pair in self.beam_nodes.items()}
        edges = {key: tuple(same.get(n, n) for n in pair) for key, pair in edges.items()}
        found = directions(edges, -1, self.platform)
        last = {name: runs[-1] for name, runs in self.written.runs.items()}
        # where both directions occur, the predecessor's side is the inner one
        self.inward = {
            name for kind, name in edges if kind == "joint" and (
                found[kind, name] == {-1} or (len(found[kind, name]) != 1 and not self.written.forward[last[name]])
            )
        }  # fmt: skip
        self.backward = {name for kind, name in edges if kind == "beam" and found[kind, name] == {-1}}
        self.rings = {name for kind, name in edges if 0 in found[kind, name]}


def solve(spec, written, configuration, load=(0, 0, 0, 0, 0, 0), gravity=(0, 0, -9.81), assembly_errors=None):
    """Analyze one pose of a robot of :mod:`small_robots` or :mod:`mechanisms`.

    Errors are by the names of the spec: of a joint what its outer side is displaced relative to its inner one in the robot, at
    its centre, world axes; of a beam ``("length", value)`` or ``("temperature", value)``.
    """
    mechanism = spec if isinstance(spec, Mechanism) else mechanism_of(spec)
    gravity, assembly_errors = np.asarray(gravity, dtype=float), assembly_errors or {}
    frame = Frame(mechanism, written, configuration)
    positions, blocks = frame.positions, []
    forces, thrusts = ([np.zeros(6) for _ in positions] for _ in range(2))

    def weigh(n, mass, com):
        if n is not None:
            f = mass * gravity
            forces[n] += np.concatenate([f, np.cross(com - positions[n], f)])

    weigh(frame.platform, mechanism.mass, frame.point("platform", mechanism.com))
    links = {link.name: link for link in mechanism.links}
    lengths = {name: float(np.linalg.norm(b - a)) for name, (a, b) in frame.beam_points.items()}
    for link in mechanism.links:
        if all(beam.link != link.name for beam in mechanism.beams):
            n = frame.of[link.name][0][2]
            weigh(n, link.mass, positions[n])
    elements = {}
    for b in mechanism.beams:
        start, end = frame.beam_nodes[b.name]
        L = lengths[b.name]
        along = frame.beam_points[b.name][1] - frame.beam_points[b.name][0]
        x = along / L
        y = frame.direction(b.link, b.y_axis) if b.y_axis is not None else np.eye(3)[np.argmin(np.abs(x))]
        y = unit(y - x * (x @ y))
        R = np.column_stack([x, y, np.cross(x, y)])
        G, s = b.E / (2 * (1 + b.nu)), b.section
        GA = b.kappa * G * s.area
        T = np.kron(np.eye(4), R.T)
        K = T.T @ element(L, b.E * s.area, GA, GA, G * s.J, b.E * s.I_y, b.E * s.I_z) @ T
        same = [other.name for other in mechanism.beams if other.link == b.link]
        mass, lever = b.density, np.zeros(3)
        if b.density is None:  # its link's, by length; the centre of all shares is the link's
            mass = links[b.link].mass * L / sum(lengths[name] for name in same)
            middles = [np.mean(frame.beam_points[name], axis=0) for name in same]
            middle = np.average(middles, axis=0, weights=[lengths[name] for name in same])
            lever = frame.point(b.link, links[b.link].com) - middle
        else:
            mass *= s.area * L
        f, m = mass * gravity / 2, np.cross(along, mass * gravity) / 12
        own = np.concatenate([f, m, f, -m]) + np.kron(np.eye(4), R) @ even_moment(
            R.T @ np.cross(lever, mass * gravity) / L, L, GA, b.E * s.I_y, b.E * s.I_z
        )
        kind, value = assembly_errors.get(b.name, ("length", 0.0))
        longer = value if kind == "length" else b.thermal_expansion * value * L
        thrust = np.concatenate([-x, np.zeros(3), x, np.zeros(3)]) * b.E * s.area / L * longer
        for node, part, push in ((start, own[:6], thrust[:6]), (end, own[6:], thrust[6:])):
            forces[node] += part
            thrusts[node] += push
        blocks.append((start, end, K))
        elements[b.name] = K, own + thrust
    constraints = []
    for edge in mechanism.edges:
        joint = edge.joint
        inner, outer = frame.sides[joint.name]
        if joint.name in frame.inward:
            inner, outer = outer, inner
        platform_side = edge.inner if joint.name in frame.inward else edge.outer
        centre = frame.point(platform_side, joint.centre)  # of a sliding joint: on the outer side
        axis, axis2 = frame.direction(edge.inner, joint.axis), frame.direction(edge.outer, joint.axis2)
        S = freedoms(joint, axis, axis2)
        C = np.zeros((6, 6))
        if joint.stiffness is not None:
            owner = written.joint_frames[written.runs[joint.name][-1]][1]
            turn = frame.now.get(owner, np.eye(4))[:3, :3] @ np.array(joint.stiffness.axes)
            S, C = elasticity(joint, S, turn, axis)
        U, _, _ = np.linalg.svd(S, full_matrices=True)
        assembly_error = np.asarray(assembly_errors.get(joint.name, np.zeros(6)), dtype=float)
        constraints.append((joint.name, inner, outer, centre, U[:, S.shape[1] :], C, assembly_error))
    n = 6 * len(positions)
    K, f = np.zeros((n, n)), np.concatenate(forces)
    for start, end, block in blocks:
        rows = np.r_[6 * start : 6 * start + 6, 6 * end : 6 * end + 6]
        K[np.ix_(rows, rows)] += block
    rows, at, springs, gaps = [], {}, [], []
    for name, inner, outer, centre, N, compliance, assembly_error in constraints:
        C = np.zeros((N.shape[1], n))
        if outer is not None:
            C[:, 6 * outer : 6 * outer + 6] += N.T @ to_point(centre - positions[outer])
        if inner is not None:
            C[:, 6 * inner : 6 * inner + 6] -= N.T @ to_point(centre - positions[inner])
        at[name] = (n + sum(len(r) for r in rows), N, centre)
        rows.append(C)
        springs.append(N.T @ compliance @ N)
        gaps.append(N.T @ assembly_error)
    C = np.concatenate(rows)
    size = np.median(np.diag(K)[np.diag(K) > 0]) if blocks else 1.0
    A = np.block([[K / size, C.T], [C, np.zeros((len(C), len(C)))]])
    for (first, N, _), spring in zip(at.values(), springs, strict=True):
        A[first : first + N.shape[1], first : first + N.shape[1]] -= spring * size
    w = np.asarray(load, dtype=float)
    full = np.zeros((len(A), 8))
    full[: len(f), 0] = f
    full[:6, 0] += w  # the platform is the first node
    full[np.arange(6), np.arange(1, 7)] = 1.0
    full[: len(f), 7] = np.concatenate(thrusts)
    full[n:, 7] = np.concatenate(gaps) * size
    values, vectors = np.linalg.eigh(A)  # A is symmetric: its eigenvectors are its singular vectors
    order = np.argsort(-np.abs(values))
    magnitudes = np.abs(values)[order]
    rank = int(np.sum(magnitudes > 1e-10 * magnitudes[0]))
    kept, dropped = vectors[:, order[:rank]], vectors[:, order[rank:]]
    gap = magnitudes[rank - 1] / max(magnitudes[rank], 1e-18) if rank < len(A) else magnitudes[-1] / 1e-18
    x = kept @ ((kept.T @ full) / values[order[:rank], None])
    x += kept @ ((kept.T @ (full - A @ x)) / values[order[:rank], None])
    unbalanced, contradiction = (
        float(np.abs(dropped.T @ full[:, k]).max(initial=0.0)) / max(float(np.abs(full[:, k]).max()), 1e-300) for k in (0, 7)
    )
    x[:, 0] += x[:, 7]
    wrenches, sure = {}, {}
    for name, (first, N, _) in at.items():
        wrenches[name] = -N @ x[first : first + N.shape[1], 0]
        sure[name] = np.abs(N @ dropped[first : first + N.shape[1]]).max(initial=0.0) < 1e-7
    u = x[:n, 0] / size
    displaced, sections = {}, {}
    for name, pair in frame.beam_nodes.items():
        block, own = elements[name]
        found = np.array([u[6 * k : 6 * k + 6] for k in pair])
        put = (block @ found.ravel() - own).reshape(2, 6)  # what is put on the beam's ends
        rows_ = np.r_[6 * pair[0] : 6 * pair[0] + 6, 6 * pair[1] : 6 * pair[1] + 6]
        sure[f"ends of {name}"] = np.abs(dropped[rows_]).max(initial=0.0) < 1e-7
        sure[f"sections of {name}"] = np.abs(block @ dropped[rows_]).max(initial=0.0) < 1e-7 * size
        backward = name in frame.backward
        displaced[name] = found[::-1] if backward else found
        sections[name] = np.array([-put[1], put[0]] if backward else [-put[0], put[1]])
    return Answer(
        u[:6], x[:6, 1:7] / size, wrenches, displaced, sections, bool(np.abs(dropped[:6]).max(initial=0.0) > 1e-7),
        unbalanced, contradiction, float(gap), sure, frame.inward, frame.backward, frame.rings,
        (frame, K, C, full[:n, 0], rows, springs),
    )  # fmt: skip
