"""An independent answer for the tests: every rigid link and both ends of every beam are nodes with six displacements; beams
are Timoshenko elements, joints are constraints with multipliers, solved in one piece. It shares no code with the package."""

from dataclasses import dataclass

import numpy as np
from small_robots import unit


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


def freedoms(joint, axis, axis2):
    """Return a joint's passive freedoms (6, k) as twists about its centre, from its axes as they are now."""
    turn, turn2, slide = np.r_[0, 0, 0, axis], np.r_[0, 0, 0, axis2], np.r_[axis, 0, 0, 0]
    found = {"R": [turn], "U": [turn, turn2], "P": [slide], "C": [slide, turn], "S": list(np.eye(6)[3:]), "F": []}
    return np.array([] if joint.driven else found[joint.kind]).reshape(-1, 6).T


@dataclass
class Answer:
    """About o, world axes; ``ends``: displacements (2, 6) of the beams' ends; ``sure``: what no local freedom or self-stress
    changes; ``free``: whether the platform can move though the drives are locked; ``unbalanced``: part of the loads not carried;
    ``gap``: ratio between the smallest singular value kept and the largest dropped."""

    twist: np.ndarray
    compliance: np.ndarray
    joint_wrenches: dict
    ends: dict
    free: bool
    unbalanced: float
    gap: float
    sure: dict


def solve(spec, written, configuration, load=(0, 0, 0, 0, 0, 0), gravity=(0, 0, -9.81)):
    """Analyze one pose of a robot of :mod:`small_robots`."""
    gravity = np.asarray(gravity, dtype=float)
    now = {}
    for name, F in written.frames.items():
        now[name] = configuration.frame(name) @ np.linalg.inv(F)

    def point(link, p):
        return now[link][:3, :3] @ np.asarray(p, dtype=float) + now[link][:3, 3]

    def direction(link, a):
        return now[link][:3, :3] @ unit(a)

    positions, forces, blocks = [], [], []

    def node(p):
        positions.append(np.asarray(p, dtype=float))
        forces.append(np.zeros(6))
        return len(positions) - 1

    def weigh(n, mass, com):
        f = mass * gravity
        forces[n] += np.concatenate([f, np.cross(com - positions[n], f)])

    o = point("platform", spec.o)
    platform = node(o)
    weigh(platform, spec.mass, point("platform", spec.com))
    carried = {b.link: b for b in spec.beams}
    joints = {j.name: j for limb in spec.limbs for j in limb.joints}
    constraints, ends = [], {}
    for limb in spec.limbs:
        names = [j.name for j in limb.joints]
        links = [k.name for k in limb.links]
        inner = None  # the node on the base side of the next joint; None is the base
        for k, joint in enumerate(limb.joints):
            before = "base" if k == 0 else links[k - 1]
            after = "platform" if k == len(links) else links[k]
            if after == "platform":
                start = end = platform
            elif after in carried:
                b = carried[after]
                sides = []
                for name in (b.start, b.end):
                    at = names.index(name)
                    # the end is fixed to the link that is next to its joint, on the side of the beam
                    owner = links[at] if at <= k else links[at - 1]
                    sides.append(point(owner, joints[name].centre))
                start, end = node(sides[0]), node(sides[1])
                ends[b.name] = (start, end)
                along = sides[1] - sides[0]
                L = np.linalg.norm(along)
                x = along / L
                y = direction(after, b.y_axis) if b.y_axis is not None else np.eye(3)[np.argmin(np.abs(x))]
                y = unit(y - x * (x @ y))
                R = np.column_stack([x, y, np.cross(x, y)])
                G, s = b.E / (2 * (1 + b.nu)), b.section
                GA = b.kappa * G * s.area
                T = np.kron(np.eye(4), R.T)
                K = T.T @ element(L, b.E * s.area, GA, GA, G * s.J, b.E * s.I_y, b.E * s.I_z) @ T
                link = limb.links[k]
                mass = link.mass if b.density is None else b.density * s.area * L
                f, m = mass * gravity / 2, np.cross(along, mass * gravity) / 12
                forces[start] += np.concatenate([f, m])
                forces[end] += np.concatenate([f, -m])
                blocks.append((start, end, K))
            else:
                link = limb.links[k]
                start = end = node(point(after, link.com))
                weigh(start, link.mass, positions[start])
            centre = point(after, joint.centre)  # of a sliding joint: on the outer side
            axis = direction(before, joint.axis)
            S = freedoms(joint, axis, direction(after, joint.axis2))
            U, _, _ = np.linalg.svd(S, full_matrices=True)
            constraints.append((joint.name, inner, start, centre, U[:, S.shape[1] :]))
            inner = end
    n = 6 * len(positions)
    K, f = np.zeros((n, n)), np.concatenate(forces)
    for start, end, block in blocks:
        rows = np.r_[6 * start : 6 * start + 6, 6 * end : 6 * end + 6]
        K[np.ix_(rows, rows)] += block
    rows, at = [], {}
    for name, inner, outer, centre, N in constraints:
        C = np.zeros((N.shape[1], n))
        C[:, 6 * outer : 6 * outer + 6] += N.T @ to_point(centre - positions[outer])
        if inner is not None:
            C[:, 6 * inner : 6 * inner + 6] -= N.T @ to_point(centre - positions[inner])
        at[name] = (n + sum(len(r) for r in rows), N, centre)
        rows.append(C)
    C = np.concatenate(rows)
    size = np.median(np.diag(K)[np.diag(K) > 0]) if blocks else 1.0
    A = np.block([[K / size, C.T], [C, np.zeros((len(C), len(C)))]])
    w = np.asarray(load, dtype=float)
    full = np.zeros((len(A), 7))
    full[: len(f), 0] = f
    full[:6, 0] += w  # the platform is the first node
    full[np.arange(6), np.arange(1, 7)] = 1.0
    values, vectors = np.linalg.eigh(A)  # A is symmetric: its eigenvectors are its singular vectors
    order = np.argsort(-np.abs(values))
    magnitudes = np.abs(values)[order]
    rank = int(np.sum(magnitudes > 1e-10 * magnitudes[0]))
    kept, dropped = vectors[:, order[:rank]], vectors[:, order[rank:]]
    gap = magnitudes[rank - 1] / max(magnitudes[rank], 1e-18) if rank < len(A) else magnitudes[-1] / 1e-18
    x = kept @ ((kept.T @ full) / values[order[:rank], None])
    x += kept @ ((kept.T @ (full - A @ x)) / values[order[:rank], None])
    unbalanced = float(np.abs(dropped.T @ full[:, 0]).max(initial=0.0)) / max(float(np.abs(full[:, 0]).max()), 1e-300)
    wrenches, sure = {}, {}
    for name, (first, N, _) in at.items():
        wrenches[name] = -N @ x[first : first + N.shape[1], 0]
        sure[name] = np.abs(N @ dropped[first : first + N.shape[1]]).max(initial=0.0) < 1e-7
    u = x[:n, 0] / size
    displaced = {}
    for name, pair in ends.items():
        displaced[name] = np.array([u[6 * k : 6 * k + 6] for k in pair])
        rows_ = np.r_[6 * pair[0] : 6 * pair[0] + 6, 6 * pair[1] : 6 * pair[1] + 6]
        sure[f"ends of {name}"] = np.abs(dropped[rows_]).max(initial=0.0) < 1e-7
    return Answer(
        u[:6], x[:6, 1:] / size, wrenches, displaced,
        bool(np.abs(dropped[:6]).max(initial=0.0) > 1e-7), unbalanced, float(gap), sure,
    )  # fmt: skip
