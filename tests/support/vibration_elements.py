"""An independent answer for the tests: natural frequencies by consistent-mass finite elements.

Beams are cut into Timoshenko elements whose masses come from their static deflections, with rotary inertia; rigid links are mass
and inertia of their nodes; joints are constraints, kept by the null space of their equations. It shares no code with the package.
Errors have even powers of the length of elements, from the second on: three meshes extrapolate.
"""

import itertools

import finite_elements as fe
import numpy as np


def element_mass(L, section, E, GA, density, lever):
    """Return the consistent mass (12, 12) of an element along x, with its line of mass at ``lever`` (3,), beam axes."""
    points, weights = np.polynomial.legendre.leggauss(6)
    M = np.zeros((12, 12))
    about = np.diag([section.I_y + section.I_z, section.I_y, section.I_z]) / section.area
    for s, weight in zip((points + 1) / 2, weights / 2, strict=True):
        N = np.zeros((6, 12))
        N[0, [0, 6]] = N[3, [3, 9]] = 1 - s, s
        for v, turn, EI, sign in ((1, 5, E * section.I_z, 1), (2, 4, E * section.I_y, -1)):
            phi = 12 * EI / (GA * L**2) if np.isfinite(GA) else 0.0
            a = 1 / (1 + phi)
            rows = [v, turn, v + 6, turn + 6]
            N[v, rows] = (
                a * (1 - 3 * s**2 + 2 * s**3 + phi * (1 - s)),
                sign * a * L * (s - 2 * s**2 + s**3 + phi / 2 * (s - s**2)),
                a * (3 * s**2 - 2 * s**3 + phi * s),
                sign * a * L * (s**3 - s**2 - phi / 2 * (s - s**2)),
            )
            N[turn, rows] = (
                sign * a * 6 / L * (s**2 - s),
                a * (1 - 4 * s + 3 * s**2 + phi * (1 - s)),
                sign * a * 6 / L * (s - s**2),
                a * (3 * s**2 - 2 * s + phi * s),
            )
        moved = N[:3] - fe.skew(lever) @ N[3:]
        M += weight * density * L * (moved.T @ moved + N[3:].T @ about @ N[3:])
    return M


def frequencies(mechanism, written, configuration, count, pieces=(4, 8, 16)):
    """Return the lowest frequencies that are not zero [Hz], and the number of those that are."""
    answer = fe.solve(mechanism, written, configuration, gravity=(0, 0, 0))
    meshes = [_squares(mechanism, answer, number) for number in pieces]
    free = int(np.sum(meshes[0] < 1e-10 * meshes[0][len(meshes[0]) // 4]))
    powers = np.vander(1 / np.square(pieces, dtype=float), increasing=True)
    squares = np.linalg.solve(powers, [mesh[free : free + count] for mesh in meshes])[0]
    return np.sqrt(squares) / (2 * np.pi), free


def _squares(mechanism, answer, pieces):
    frame, _, _, _, rows, springs = answer.system
    n = 6 * len(frame.positions)
    size = n + 6 * (pieces - 1) * len(mechanism.beams)
    K, M = np.zeros((2, size, size))

    def add_mass(node, mass, com):
        X = fe.to_point(com - frame.positions[node])
        own = X.T @ np.diag([mass] * 3 + [1.0] * 3) @ X  # all links of the tests have an inertia of 1 kg m²
        M[6 * node : 6 * node + 6, 6 * node : 6 * node + 6] += own

    if mechanism.mass:
        add_mass(frame.platform, mechanism.mass, frame.point("platform", mechanism.com))
    links = {link.name: link for link in mechanism.links}
    carriers = {beam.link for beam in mechanism.beams}
    for link in mechanism.links:
        if link.mass and link.name not in carriers:
            node = frame.of[link.name][0][2]
            add_mass(node, link.mass, frame.positions[node])
    lengths = {name: float(np.linalg.norm(b - a)) for name, (a, b) in frame.beam_points.items()}
    for number, b in enumerate(mechanism.beams):
        start, end = frame.beam_points[b.name]
        L = lengths[b.name]
        x = (end - start) / L
        y = frame.direction(b.link, b.y_axis) if b.y_axis is not None else np.eye(3)[np.argmin(np.abs(x))]
        y = fe.unit(y - x * (x @ y))
        R = np.column_stack([x, y, np.cross(x, y)])
        G, s = b.E / (2 * (1 + b.nu)), b.section
        GA, h = b.kappa * G * s.area, L / pieces
        density, lever = b.density, np.zeros(3)
        if density is None:
            same = [other.name for other in mechanism.beams if other.link == b.link]
            total = sum(lengths[name] for name in same)
            density = links[b.link].mass / total
            middle = np.average(
                [np.mean(frame.beam_points[name], axis=0) for name in same], axis=0, weights=[lengths[name] for name in same]
            )
            lever = R.T @ (frame.point(b.link, links[b.link].com) - middle)
        else:
            density *= s.area
        T = np.kron(np.eye(4), R.T)
        stiff = T.T @ fe.element(h, b.E * s.area, GA, GA, G * s.J, b.E * s.I_y, b.E * s.I_z) @ T
        heavy = T.T @ element_mass(h, s, b.E, GA, density, lever) @ T
        inner = [n + 6 * ((pieces - 1) * number + k) for k in range(pieces - 1)]
        path = [6 * frame.beam_nodes[b.name][0], *inner, 6 * frame.beam_nodes[b.name][1]]
        for one, other in itertools.pairwise(path):
            at = np.r_[one : one + 6, other : other + 6]
            K[np.ix_(at, at)] += stiff
            M[np.ix_(at, at)] += heavy
    closed = [np.zeros((0, size))]
    for C, compliance in zip(rows, springs, strict=True):
        values, axes = np.linalg.eigh(compliance)
        soft = values > 1e-12 * max(values.max(initial=0.0), 1e-300)
        C = axes.T @ np.pad(C, [(0, 0), (0, size - n)])
        K += C[soft].T @ (C[soft] / values[soft, None])
        closed.append(C[~soft])
    base = frame.base
    assert base is None
    C = np.concatenate(closed)
    _, values, null = np.linalg.svd(C)
    Z = null[int(np.sum(values > 1e-9 * values[0])) :].T
    K, M = Z.T @ K @ Z, Z.T @ M @ Z
    scale = np.sqrt(np.diag(K) + np.diag(M) * np.trace(K) / np.trace(M))
    scale[scale == 0] = 1.0
    K, M = K / np.outer(scale, scale), M / np.outer(scale, scale)
    shift = np.trace(K) / np.trace(M) * 1e-6
    values, axes = np.linalg.eigh(K + shift * M)
    keep = values > 1e-13 * values[-1]
    W = axes[:, keep] / np.sqrt(values[keep])
    inverse = np.linalg.eigvalsh(W.T @ M @ W)[::-1]
    found = 1 / inverse[inverse > 1e-13 * inverse[0]] - shift
    return np.where(np.abs(found) < 1e-9 * shift, 0.0, found)
