"""An independent answer for the tests: the largest ratio of forces to those at which a robot buckles, by finite elements.

Beams are cut into pieces with cubic deflections; constraints of joints are kept by the null space of their equations. What the
package leaves out by definition is left out here: shear, bending moments, torques, and in rigid bodies the coupling of torsion
and bending of parallel beams. It shares no code with the package.
"""

import finite_elements as fe
import numpy as np
import small_robots as sr


def hermite(first, last, L):
    """Return the geometric stiffness (12, 12) of a beam along x under a tension that varies linearly."""
    points, weights = np.polynomial.legendre.leggauss(4)
    s, weights = (points + 1) / 2, weights / 2
    slopes = np.array([6 * (s**2 - s) / L, 1 - 4 * s + 3 * s**2, 6 * (s - s**2) / L, 3 * s**2 - 2 * s])
    block = np.einsum("q,iq,jq->ij", L * weights * (first + (last - first) * s), slopes, slopes)
    G = np.zeros((12, 12))
    for rows, sign in (([1, 5, 7, 11], 1), ([2, 4, 8, 10], -1)):
        turn = np.diag([1, sign, 1, sign])
        G[np.ix_(rows, rows)] += turn @ block @ turn
    return G


def work_of_turning(forces, arms):
    """Return the (3, 3) second derivative of the work of forces on a body that turns, by differences of exact rotations."""

    def work(t):
        angle = np.linalg.norm(t)
        if angle == 0:
            return 0.0
        K = fe.skew(t / angle)
        R = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
        return sum(f @ (R @ r - r) for f, r in zip(forces, arms, strict=True))

    h, e = 1e-3, np.eye(3)
    terms = [[work(h * (a + b)) - work(h * (a - b)) - work(h * (b - a)) + work(-h * (a + b)) for b in e] for a in e]
    return np.array(terms) / (4 * h * h)


def largest_ratio(spec, load, gravity=(0, 0, 0), pieces=6):
    """Return the largest ratio of the robot's forces to those at which it buckles, and the robot, written with whole beams."""
    cut = sr.split(spec, pieces)
    written = sr.write(cut)
    answer = fe.solve(cut, written, written.robot().assemble(), load, gravity)
    return ratio_of(sr.mechanism_of(cut), answer, load, gravity), sr.write(sr.split(spec, 1))


def ratio_of(mechanism, answer, load, gravity):
    """Return the largest ratio of a mechanism whose equilibrium is known; its beams have no shear."""
    A, _ = _on_held_motions(mechanism, answer, load, gravity)
    return float(max(np.linalg.eigvalsh(-A)[-1], 0.0))


def _on_held_motions(mechanism, answer, load, gravity):
    """Return K_G on motions with which K is 1, and these, in the coordinates of the nodes."""
    frame, K, C, *_ = answer.system
    n = len(K)
    G = np.zeros((n, n))
    at = {node: slice(6 * node, 6 * node + 6) for node in range(len(frame.positions))}
    forces = {node: [] for node in at}  # (force, point)
    axes = {node: [] for node in at}
    forces[frame.platform].append((np.asarray(load[:3], dtype=float), frame.positions[frame.platform]))
    g = np.asarray(gravity, dtype=float)
    forces[frame.platform].append((mechanism.mass * g, frame.point("platform", mechanism.com)))
    beams = {beam.link for beam in mechanism.beams}
    for link in mechanism.links:
        if link.name not in beams:
            node = frame.of[link.name][0][2]
            forces[node].append((link.mass * g, frame.positions[node]))
    for beam in mechanism.beams:
        nodes, points = frame.beam_nodes[beam.name], frame.beam_points[beam.name]
        L = np.linalg.norm(points[1] - points[0])
        x = (points[1] - points[0]) / L
        sections = answer.sections[beam.name][:, :3]
        if beam.name in frame.backward:
            sections = -sections[::-1]
        forces[nodes[0]].append((sections[0], points[0]))
        forces[nodes[1]].append((-sections[1], points[1]))
        for node in nodes:
            axes[node].append(x)
        y = np.cross(x, np.eye(3)[np.argmin(np.abs(x))])
        R = np.column_stack([x, y / np.linalg.norm(y), np.cross(x, y / np.linalg.norm(y))])
        T = np.kron(np.eye(4), R.T)
        rows = np.r_[at[nodes[0]], at[nodes[1]]]
        G[np.ix_(rows, rows)] += T.T @ hermite(*(sections @ x), L) @ T
    same = {node: node for node in at}
    for edge in mechanism.edges:
        inner, outer = frame.sides[edge.joint.name]
        if (edge.joint.kind == "F" or edge.joint.driven) and inner is not None and outer is not None:
            a, b = same[inner], same[outer]
            same = {node: (a if root == b else root) for node, root in same.items()}
    for edge in mechanism.edges:
        joint = edge.joint
        inner, outer = frame.sides[joint.name]
        turned = joint.name in frame.inward
        where = edge.inner if turned else edge.outer
        centre = frame.point(where, joint.centre)
        force = answer.joint_wrenches[joint.name][:3] * (-1 if turned else 1)  # of the inner side on the outer one
        for node, f in ((outer, force), (inner, -force)):
            if node is not None:
                forces[node].append((f, centre))
        if joint.kind in "PCE" and not joint.driven and inner is not None:
            ui, uo = np.zeros((2, 3, n))
            ui[:, at[inner]] = fe.to_point(centre - frame.positions[inner])[:3]
            if outer is not None:
                uo[:, at[outer]] = fe.to_point(centre - frame.positions[outer])[:3]
            theta = np.zeros((3, n))
            theta[:, at[inner]][:, 3:] = np.eye(3)
            mixed = theta.T @ fe.skew(-force) @ (uo - ui)  # f · (θ × u)
            G += mixed + mixed.T
    for root in set(same.values()):
        mine = [node for node in at if same[node] == root]
        centre = frame.positions[root]
        given = [item for node in mine for item in forces[node]]
        W = work_of_turning([f for f, _ in given], [p - centre for _, p in given])
        along = [x for node in mine for x in axes[node]]
        if along and all(np.linalg.norm(np.cross(along[0], x)) < 1e-9 for x in along):
            P = np.outer(along[0], along[0])
            W = P @ W @ P + (np.eye(3) - P) @ W @ (np.eye(3) - P)
        turn = slice(at[root].start + 3, at[root].stop)
        G[turn, turn] -= W
    _, values, null = np.linalg.svd(C)
    Z = null[int(np.sum(values > 1e-9 * values[0])) :].T
    Kz, Gz = Z.T @ K @ Z, Z.T @ G @ Z
    size = np.sqrt(np.where(np.diag(Kz) > 0, np.diag(Kz), 1.0))
    Kz, Gz = Kz / np.outer(size, size), Gz / np.outer(size, size)
    values, vectors = np.linalg.eigh(Kz)
    basis = vectors[:, values > 1e-10 * values[-1]] / np.sqrt(values[values > 1e-10 * values[-1]])
    return basis.T @ Gz @ basis, Z @ (basis / size[:, None])
