"""Links by their matrices for the tests: a uniform beam, and frames of beams with any number of interfaces and inner nodes."""

import numpy as np
from finite_elements import element, skew, to_point

L, EA, GA, GJ, EI_Y, EI_Z, LINE_DENSITY, EXPANSION = 0.7, 2.4e8, 8.1e7, 3.1e4, 4.2e4, 1.9e4, 9.4, 1.2e-5


def beam_stiffness():
    return element(L, EA, GA, 0.8 * GA, GJ, EI_Y, EI_Z)


def beam_gravity():
    """Return the loads (12, 3) of a beam along x due to unit gravity: those of the clamped beam, reversed."""
    half, couple = LINE_DENSITY * L / 2, LINE_DENSITY * L**2 / 12
    loads = np.zeros((12, 3))
    for node, sign in ((0, 1), (6, -1)):
        loads[node : node + 3] = half * np.eye(3)
        loads[node + 5, 1], loads[node + 4, 2] = sign * couple, -sign * couple
    return loads


class Frame:
    """A frame of random beams between random nodes, each with a rigid body; the first ``ports`` nodes are interfaces.

    ``at``: positions of the interfaces; by default they are random.
    """

    def __init__(self, seed=0, ports=3, inner=2, at=()):
        rng = np.random.default_rng(seed)
        self.ports, count = ports, ports + inner
        self.nodes = rng.uniform(-0.5, 0.5, (count, 3))
        self.nodes[: len(at)] = np.reshape(at, (-1, 3))
        self.K, self.M = np.zeros((6 * count, 6 * count)), np.zeros((6 * count, 6 * count))
        edges = [(k, (k + 1) % count) for k in range(count)] + [(0, count // 2)]
        for first, second in edges:
            along = self.nodes[second] - self.nodes[first]
            length = np.linalg.norm(along)
            axes = np.linalg.qr(np.column_stack([along, rng.normal(size=(3, 2))]))[0]
            axes *= np.sign(axes[:, 0] @ along)
            axes[:, 2] *= np.sign(np.linalg.det(axes))
            stiff = element(length, *(10 ** rng.uniform([7, 6, 6, 3, 3, 3], [8, 7, 7, 5, 5, 5])))
            turn = np.kron(np.eye(4), axes)
            rows = np.r_[6 * first : 6 * first + 6, 6 * second : 6 * second + 6]
            self.K[np.ix_(rows, rows)] += turn @ stiff @ turn.T
        self.bodies = []
        for node in range(count):
            mass, centre, spread = rng.uniform(0.5, 2), rng.normal(size=3) / 20, np.diag(rng.uniform(1e-3, 2e-3, 3))
            map_ = to_point(centre)
            own = map_.T @ np.block([[mass * np.eye(3), np.zeros((3, 3))], [np.zeros((3, 3)), spread]]) @ map_
            self.M[6 * node : 6 * node + 6, 6 * node : 6 * node + 6] += own
            self.bodies.append((mass, self.nodes[node] + centre, spread))
        self.rigid = np.vstack([to_point(node) for node in self.nodes])
        turns = np.linalg.qr(rng.normal(size=(ports, 3, 3)))[0]
        self.rotations = turns * np.linalg.det(turns)[:, None, None]
        turn = np.eye(6 * count)
        for port, axes in enumerate(self.rotations):
            turn[6 * port : 6 * port + 6, 6 * port : 6 * port + 6] = np.kron(np.eye(2), axes)
        self.turn = turn

    def link(self, modal=False):
        """Return names, origins, and rotations, stiffness and mass by name.

        Internal coordinates are the displacements of the inner nodes relative to the link carried by the first interface, or
        all amplitudes of fixed-interface modes (``modal``).
        """
        outer = 6 * self.ports
        shapes = np.eye(len(self.K))
        if modal:
            stiff, mass = self.K[outer:, outer:], self.M[outer:, outer:]
            root = np.linalg.inv(np.linalg.cholesky(mass))
            shapes[outer:, outer:] = root.T @ np.linalg.eigh(root @ stiff @ root.T)[1]
            shapes[outer:, :outer] = -np.linalg.solve(stiff, self.K[outer:, :outer])
        else:
            shapes[outer:, :6] = self.rigid[outer:] @ np.linalg.inv(self.rigid[:6])
        shapes = shapes @ self.turn
        matrices = {"stiffness": shapes.T @ self.K @ shapes, "mass": shapes.T @ self.M @ shapes}
        names = tuple(f"joint_{port + 1}" for port in range(self.ports))
        return names, self.nodes[: self.ports], {"rotations": self.rotations, **matrices}

    def body(self):
        """Return mass, centre and inertia about it."""
        mass = sum(part[0] for part in self.bodies)
        centre = sum(part[0] * part[1] for part in self.bodies) / mass
        inertia = sum(part[2] - part[0] * skew(part[1] - centre) @ skew(part[1] - centre) for part in self.bodies)
        return mass, centre, inertia
