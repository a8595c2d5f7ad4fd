"""An independent answer for robots with links given by matrices: all bodies are nodes, joints are constraints with multipliers.

It reads the elements of :mod:`hub_robots`, whose links are not turned, and shares no code with the package.
"""

from xml.etree import ElementTree

import numpy as np
from finite_elements import element, skew, to_point
from simple_machines import E


def _vector(part, path="origin"):
    found = part.find(path)
    return np.zeros(3) if found is None else np.array(found.get("xyz").split(), dtype=float)


class LinkedFrame:
    """K, M and loads of all nodes, and the constraints A x = 0 of the joints.

    A rigid body is a node at its link's origin, a beam has a node at each of its ends. By link, ``frames`` has a frame, and the
    joints at its first nodes, or ``o``. The base is held at ``o`` or, without it, at its first joint; the platform moves with
    them.
    """

    def __init__(self, parts, frames):
        root = ElementTree.fromstring(f"<robot>{''.join(parts)}</robot>")
        links = {part.get("name"): part for part in root.findall("link")}
        self.origins, joints = {"base": np.zeros(3)}, []
        tree = root.findall("joint")
        while len(self.origins) < len(links):
            for part in tree:
                parent, child = part.find("parent").get("link"), part.find("child").get("link")
                if parent in self.origins and child not in self.origins:
                    self.origins[child] = self.origins[parent] + _vector(part)
        for part in tree:
            parent, child = part.find("parent").get("link"), part.find("child").get("link")
            joints.append((part, parent, child, self.origins[child]))
        for part in root.findall("loop"):
            first, second = part.find("predecessor"), part.find("successor")
            joints.append((part, first.get("link"), second.get("link"), self.origins[first.get("link")] + _vector(first)))
        self.at = {part.get("name"): point for part, _, _, point in joints}
        self.joints = joints
        beams = {part.get("link"): part for part in root.findall("beam")}
        self.nodes, self.slenderness = {}, np.inf  # the least of a beam
        self.inside, count = {}, 0
        for owner, (frame, names) in frames.items():
            self.nodes |= {(owner, name): count + k for k, name in enumerate(names)}
            self.inside[owner], count = slice(6 * count, 6 * count + len(frame.K)), count + len(frame.nodes)
        for name, part in beams.items():
            for end in ("from", "to"):
                self.nodes[name, part.get(end)] = count
                count += 1
        for name in links:
            if name not in ("base", *frames, *beams):
                self.nodes[name] = count
                count += 1
        size = 6 * count
        self.K, self.M, self.weight = np.zeros((size, size)), np.zeros((size, size)), np.zeros((size, 3))
        for owner, (frame, _) in frames.items():
            inside = self.inside[owner]
            self.K[inside, inside], self.M[inside, inside] = frame.K, frame.M
        for name, part in beams.items():
            self._add_beam(name, part)
        for name, node in self.nodes.items():
            if isinstance(name, str) and links[name].find("inertial") is not None:
                inertial, rows = links[name].find("inertial"), slice(6 * node, 6 * node + 6)
                to_centre = to_point(_vector(inertial))
                mass = float(inertial.find("mass").get("value"))
                self.M[rows, rows] += to_centre.T @ np.diag([mass] * 3 + [1.0] * 3) @ to_centre
        shifts = np.tile(np.vstack([np.eye(3), np.zeros((3, 3))]), (count, 1))
        self.weight += self.M @ shifts
        rows, self.rows = [], {}
        for part, parent, child, point in joints:
            relative = self._moved(child, part.get("name"), point) - self._moved(parent, part.get("name"), point)
            kind = part.get("type")
            held = np.eye(6)
            if kind == "revolute" and part.get("name") != "foot":
                axis = _vector(part, "axis")
                held = np.vstack([held[:3], np.pad(np.linalg.svd(axis[None])[2][1:], ((0, 0), (3, 0)))])
            elif kind == "spherical":
                held = held[:3]
            self.rows[part.get("name")] = (sum(map(len, rows)), held)
            rows.append(held @ relative)
        for owner, (_, names) in frames.items():
            self.nodes[owner] = self.nodes[owner, "o" if "o" in names else names[0]]
        if "base" in frames:
            rows.append(np.eye(size)[6 * self.nodes["base"] : 6 * self.nodes["base"] + 6])
        self.A = np.concatenate(rows)
        self.foot_axis = next(_vector(part, "axis") for part, *_ in joints if part.get("name") == "foot")

    def _moved(self, link, joint, point):
        """Return the displacement (6, size) of a link at a joint."""
        found = np.zeros((6, len(self.K)))
        if link in self.nodes or (link, joint) in self.nodes:
            key = (link, joint) if (link, joint) in self.nodes else link
            node = 6 * self.nodes[key]
            found[:, node : node + 6] = np.eye(6) if key != link else to_point(point - self.origins[link])
        return found

    def _add_beam(self, name, part):
        first, second = (self.nodes[name, part.get(end)] for end in ("from", "to"))
        along = self.at[part.get("to")] - self.at[part.get("from")]
        L, d, density = np.linalg.norm(along), float(part.find("circle").get("diameter")), float(part.get("density"))
        self.slenderness, x = min(self.slenderness, L / d), along / L
        y = np.cross(x, np.eye(3)[np.argmin(np.abs(x))])
        axes = np.column_stack([x, y / np.linalg.norm(y), np.cross(x, y / np.linalg.norm(y))])
        area, moment = np.pi * d**2 / 4, np.pi * d**4 / 64
        stiff = element(L, E * area, np.inf, np.inf, E / 2.6 * 2 * moment, E * moment, E * moment)
        turn = np.kron(np.eye(4), axes)
        rows = np.r_[6 * first : 6 * first + 6, 6 * second : 6 * second + 6]
        self.K[np.ix_(rows, rows)] += turn @ stiff @ turn.T
        for node, sign in ((first, 1), (second, -1)):  # the reactions of the clamped beam, reversed
            load = density * area * L * np.vstack([np.eye(3) / 2, sign * L / 12 * skew(x)])
            self.weight[6 * node : 6 * node + 6] += load

    def solve(self, load, gravity, others=(), only=None):
        """Return displacements and multipliers for loads (6, m) on the platform, weights, and loads (6,) on other bodies.

        ``only``: the link given by a frame that alone has weight.
        """
        weight = self.weight @ gravity
        if only is not None:
            weight, every = np.zeros_like(weight), weight
            weight[self.inside[only]] = every[self.inside[only]]
        right = np.tile(weight[:, None], np.shape(load)[1])
        for name, wrenches in {"platform": load, **dict(others)}.items():
            rows = slice(6 * self.nodes[name], 6 * self.nodes[name] + 6)
            right[rows] += np.reshape(wrenches, (6, -1))
        return self._solved(right)

    def _solved(self, right):
        whole = np.block([[self.K, self.A.T], [self.A, np.zeros((len(self.A), len(self.A)))]])
        right = np.vstack([right, np.zeros((len(self.A), right.shape[1]))])
        size = np.ones(len(whole))
        for _ in range(8):  # until the largest number of every row is about 1
            size = size / np.sqrt(np.abs(size[:, None] * whole * size).max(axis=1))
        whole, right = (size[:, None] * whole * size).astype(np.longdouble), size[:, None] * right.astype(np.longdouble)
        answer, rounded = np.zeros_like(right), whole.astype(float)
        for _ in range(4):
            answer = answer + np.linalg.solve(rounded, (right - whole @ answer).astype(float))
        answer = (size[:, None] * answer).astype(float)
        return answer[: len(self.K)], answer[len(self.K) :]

    def platform(self, displacements):
        node = 6 * self.nodes["platform"]
        return displacements[node : node + 6]

    def wrench(self, joint, multipliers):
        """Return the wrench of the parent on the child about the joint."""
        first, held = self.rows[joint]
        return -held.T @ multipliers[first : first + len(held)]

    def frequencies(self, count):
        """Return the lowest natural frequencies [Hz]."""
        values, axes = np.linalg.eigh(self.M)
        root = (axes * np.sqrt(np.maximum(values, 0)))[:, values > 1e-12 * values[-1]]  # M = root rootᵀ
        squares = np.linalg.eigvalsh(root.T @ self._solved(root)[0])[::-1][:count]  # 1/ω²
        return 1 / np.sqrt(squares) / (2 * np.pi)


def alike(found, expected, tolerance=1e-9, same_names=True):
    """Assert that arrays, or arrays by name, are equal; unless ``same_names``, ``found`` may have more names."""
    if hasattr(expected, "items"):
        largest = max(np.abs(value).max(initial=0.0) for value in expected.values())
        assert not same_names or list(found) == list(expected)
        assert max(np.abs(found[key] - expected[key]).max(initial=0.0) for key in expected) <= tolerance * largest
    else:
        assert np.abs(found - expected).max() <= tolerance * np.abs(expected).max()


def agrees(found, frame, moved, wrenches):
    """Assert that an analysis equals a frame's solution: twist, compliance, torque at the foot, wrenches of joints."""
    alike(found.twist, frame.platform(moved)[:, 0])
    alike(found.compliance, frame.platform(frame.solve(np.eye(6), np.zeros(3))[0]))
    axis = frame.foot_axis / np.linalg.norm(frame.foot_axis)
    alike(found.actuator_forces["foot"], frame.wrench("foot", wrenches)[3:, 0] @ axis)
    for name, wrench in found.joint_wrenches.items():
        expected = frame.wrench(name, wrenches)[:, 0]  # of the parent, which may be the outer side
        alike(wrench, expected * np.sign(expected @ wrench))
