"""Matrices of a link from finite element programs: CalculiX, Abaqus, ANSYS and Simscape Multibody.

Each reader returns a :class:`_Substructure`: the *freedoms* of retained nodes, then amplitudes of modes that vanish at these
nodes. The nodes of an interface move rigidly, nodes of no interface follow without force. Sources of the formats: CalculiX 2.20,
``*SUBSTRUCTURE MATRIX OUTPUT``; the Abaqus keywords ``*USER ELEMENT`` and ``*MATRIX``; listings of nodes and master freedoms of
ANSYS; MathWorks' page of Simscape Multibody's block Reduced Order Flexible Solid.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from kinetostatics.description.link_matrices import LinkMatrices
from kinetostatics.exceptions import ArgumentError, RobotFileError, near_names
from kinetostatics.math.arrays import Array
from kinetostatics.math.rotations import skew

#: Freedoms of a node in ANSYS, in the order of the numbers 1 to 6 of the other programs.
LABELS = ("UX", "UY", "UZ", "ROTX", "ROTY", "ROTZ")
#: Keywords of an input file with which coordinates or freedoms would not be along the axes of the model, or elsewhere.
MOVED = ("*INCLUDE", "*INSTANCE", "*NGEN", "*NCOPY", "*NFILL", "*NMAP", "*SYSTEM", "*TRANSFORM")
#: Largest size of a link [m]; larger ones are probably in millimetres.
LARGEST = 20.0


@dataclass(frozen=True)
class _Substructure:
    """Matrices of the ``freedoms`` (node, 0 … 5), then of modes; ``points`` and ``sets`` of nodes, by names in capitals."""

    file: str
    freedoms: Sequence[tuple[int, int]]
    points: Mapping[int, Array]
    stiffness: Array
    mass: Array | None = None
    sets: Mapping[str, Sequence[int]] = field(default_factory=dict)


def import_link(
    path: str | os.PathLike[str],
    interfaces: Mapping[str, str | int | Sequence[int]],
    nodes: str | os.PathLike[str] | None = None,
    unit: Literal["m", "mm"] = "m",
) -> LinkMatrices:
    """Read the matrices of a link from a finite element program.

    The file is a text ``.mtx`` of CalculiX (``*SUBSTRUCTURE MATRIX OUTPUT``) or Abaqus (``OUTPUT FILE=USER DEFINED``), a ``.csv``
    of ANSYS with the stiffness matrix (the mass matrix is beside it: ``arm_mat_K.CSV``, ``arm_mat_M.CSV``), or a ``.mat`` of
    Simscape's Reduced Order Flexible Solid with ``P``, ``K`` and ``M``. The axes of all interfaces are those of the model.

    Args:
        path: the file.
        interfaces: by name of the joint, or ``o``: a node, several nodes that move rigidly, or the name of a set of nodes in the
            input file; of Simscape, the number of the row of ``P``, from 1. The origin is the mean of the nodes. Nodes of no
            interface follow without force.
        nodes: file with coordinates; default: the ``.inp`` beside the ``.mtx``; ``arm_out_nodes_3D.txt`` for ``arm_mat_K.CSV``.
        unit: ``mm``: the model is in mm, N, tonne; ``m``: in SI units.

    Raises:
        RobotFileError: a file cannot be read, has contents that are not known, or matrices that are not those of a link; the
            message names file and line.
        ArgumentError: an interface is not in the file.
    """
    name = os.fspath(path)
    readers = {".mtx": _user_element, ".csv": _ansys, ".mat": _simscape}
    suffix = Path(name).suffix.lower()
    if suffix not in readers:
        raise ArgumentError(f"{name}: files end in .mtx (CalculiX, Abaqus), .csv (ANSYS) or .mat (Simscape)")
    return _link(readers[suffix](name, None if nodes is None else os.fspath(nodes)), interfaces, unit)


def _link(part: _Substructure, interfaces: Mapping[str, str | int | Sequence[int]], unit: str) -> LinkMatrices:
    rows = {freedom: row for row, freedom in enumerate(part.freedoms)}
    internal = len(part.stiffness) - len(rows)
    groups = {name: _nodes_of(part, name, given) for name, given in interfaces.items()}
    retained = list(dict.fromkeys(node for node, _ in part.freedoms))
    used = [node for group in groups.values() for node in group]
    for node in used:
        if node not in retained:
            raise ArgumentError(f"{part.file} has no matrix of node {node}; its nodes are {', '.join(map(str, retained[:12]))}")
        if used.count(node) > 1:
            raise ArgumentError(f"node {node} of {part.file} is in several interfaces, or twice in one; once would be right")
    free = [row for row, (node, _) in enumerate(part.freedoms) if node not in used]
    motions = np.zeros((len(part.stiffness), 6 * len(groups) + internal))
    motions[len(rows) :, 6 * len(groups) :] = np.eye(internal)
    origins = [np.mean([part.points[node] for node in group], axis=0) for group in groups.values()]
    for k, group in enumerate(groups.values()):
        for node in group:
            rigid = np.block([[np.eye(3), -skew(part.points[node] - origins[k])], [np.zeros((3, 3)), np.eye(3)]])
            for direction in range(6):
                if (node, direction) in rows:
                    motions[rows[node, direction], 6 * k : 6 * k + 6] = rigid[direction]
    held = part.stiffness[np.ix_(free, free)]
    motions[free] = -np.linalg.solve(held, (part.stiffness @ motions)[free])
    factor, length = (1e3, 1e-3) if unit == "mm" else (1.0, 1.0)
    scales = np.concatenate([np.tile([1.0, 1.0, 1.0, length, length, length], len(groups)), np.ones(internal)])

    def reduced(matrix: Array) -> Array:
        return factor * np.outer(scales, scales) * (motions.T @ matrix @ motions)

    centres = length * np.array(origins)
    if np.ptp(centres, axis=0).max() > LARGEST:
        raise ArgumentError(
            f"{part.file}: the interfaces are {np.ptp(centres, axis=0).max():.6g} m apart; if it is in mm, give the unit mm"
        )
    mass = None if part.mass is None else reduced(part.mass)
    try:
        return LinkMatrices(tuple(groups), centres, stiffness=reduced(part.stiffness), mass=mass)
    except ArgumentError as error:
        raise RobotFileError(str(error), part.file) from None


def _nodes_of(part: _Substructure, name: str, given: str | int | Sequence[int]) -> list[int]:
    if isinstance(given, str):
        words = given.replace(",", " ").split()
        if not words or not all(word.isdecimal() for word in words):
            if given.strip().upper() not in part.sets:
                known = near_names(given, part.sets)
                raise ArgumentError(f"interface {name}: {given!r} is no set of nodes and no node number; {known}")
            return list(part.sets[given.strip().upper()])
        given = [int(word) for word in words]
    return [given] if isinstance(given, int) else list(dict.fromkeys(given))


# ---- CalculiX and Abaqus -------------------------------------------------------------------------------------------------


def _user_element(name: str, nodes: str | None) -> _Substructure:
    listed: list[int] = []
    freedoms: dict[int, list[int]] = {}
    numbers: dict[str, list[float]] = {}
    begins: dict[str, int] = {}
    kind, count = "", 0
    naming = False
    for line, text in _lines(name):
        if text.startswith("**"):
            words = text.strip("* ").upper()
            if naming and re.fullmatch(r"[-\d,\s]+", words):
                listed += [int(word) for word in words.replace(",", " ").split()]
            else:
                naming = words == "ELEMENT NODES"
        elif text.startswith("*"):
            keyword, options = _keyword(text)
            kind = keyword + options.get("TYPE", "")
            if keyword == "*USER ELEMENT" and not count and set(options) <= {"NODES", "LINEAR", "TYPE"}:
                count, kind = int(options.get("NODES", 0)), keyword
            elif kind not in ("*MATRIXSTIFFNESS", "*MATRIXMASS") or len(options) > 1 or kind in numbers or not count:
                expected = "one *USER ELEMENT, NODES=…, LINEAR, then *MATRIX, TYPE=STIFFNESS and *MATRIX, TYPE=MASS"
                raise RobotFileError(f"{text!r} is not known here; {expected} would be right", name, line)
            else:
                numbers[kind], begins[kind] = [], line
        elif kind in numbers:
            numbers[kind] += _numbers(text, name, line)
        elif kind == "*USER ELEMENT":
            first, *others = map(int, _numbers(text, name, line))
            position, directions = (first, others) if freedoms else (1, [first, *others])
            if not directions or not set(directions) <= set(range(1, 7)):
                raise RobotFileError(f"{text!r} has freedoms other than 1 to 6 of a node", name, line)
            freedoms[position] = directions
        else:
            raise RobotFileError(f"{text!r} stands before *USER ELEMENT", name, line)
    if not count or len(listed) != count or "*MATRIXSTIFFNESS" not in numbers:
        given = f"{count} nodes, the comment ELEMENT NODES {len(listed)}"
        raise RobotFileError(f"*USER ELEMENT has {given}; equal numbers and a *MATRIX, TYPE=STIFFNESS would be right", name)
    retained: list[tuple[int, int]] = []
    directions = []
    for position, node in enumerate(listed, 1):
        directions = freedoms.get(position, directions)
        retained += [(node, direction - 1) for direction in directions]
    matrices = {}
    for kind, entries in numbers.items():
        size = len(retained)
        if len(entries) != size * (size + 1) // 2:
            right = f"{size * (size + 1) // 2} for its {size} freedoms would be right"
            raise RobotFileError(f"the matrix has {len(entries)} numbers; {right}", name, begins[kind])
        triangle = np.zeros((size, size))
        triangle[np.tril_indices(size)] = entries
        matrices[kind] = triangle + np.tril(triangle, -1).T
    points, sets = _input_file(nodes or str(Path(name).with_suffix(".inp")), [node for node, _ in retained])
    return _Substructure(name, retained, points, matrices["*MATRIXSTIFFNESS"], matrices.get("*MATRIXMASS"), sets)


def _input_file(name: str, retained: Sequence[int]) -> tuple[dict[int, Array], dict[str, list[int]]]:
    """Return coordinates and sets of nodes of an input file of CalculiX or Abaqus."""
    points: dict[int, Array] = {}
    sets: dict[str, list[int]] = {}
    keyword = ""
    options: dict[str, str] = {}
    for line, text in _lines(name):
        if text.startswith("*"):
            if text.startswith("**"):
                continue
            keyword, options = _keyword(text)
            if keyword in MOVED or (keyword == "*NODE" and "SYSTEM" in options):
                raise RobotFileError(
                    f"{text!r} is not known here; a file with all nodes in *NODE, in the model's axes, would be right", name, line
                )
            continue
        if keyword == "*NODE":
            number, *point = _numbers(text, name, line)
            points[int(number)] = np.array((point + [0.0] * 3)[:3])
            members = [int(number)]
        elif keyword == "*NSET":
            words = [word.strip() for word in text.split(",") if word.strip()]
            members = [member for word in words for member in ([int(word)] if word.isdecimal() else sets.get(word.upper(), []))]
            if "GENERATE" in options:
                members = list(range(members[0], members[1] + 1, *members[2:]))
        else:
            continue
        if "NSET" in options:
            sets.setdefault(options["NSET"].upper(), []).extend(members)
    if missing := [node for node in retained if node not in points]:
        raise RobotFileError(f"*NODE has no coordinates of node {missing[0]}, which has a matrix", name)
    return points, {key: list(dict.fromkeys(members)) for key, members in sets.items()}


def _keyword(text: str) -> tuple[str, dict[str, str]]:
    """Return the keyword of a line in capitals, and its options."""
    keyword, *options = (word.strip() for word in text.split(","))
    pairs = (option.partition("=") for option in options if option)
    return re.sub(r"\s+", " ", keyword.upper()), {key.strip().upper(): value.strip() for key, _, value in pairs}


# ---- ANSYS and Simscape --------------------------------------------------------------------------------------------------


def _ansys(name: str, nodes: str | None) -> _Substructure:
    stem, suffix = os.path.splitext(name)
    base = stem.removesuffix("_mat_K")
    masses = [path for path in (f"{base}_mat_M{suffix}",) if base != stem and os.path.exists(path)]
    listing = nodes or f"{base}_out_nodes_3D.txt"
    points: dict[int, Array] = {}
    freedoms: list[tuple[int, int]] = []
    kind = ""
    for line, text in _lines(listing):
        words = text.upper().split()
        if not words[0].isdecimal():
            known = words[:4] == ["NODE", "X", "Y", "Z"] or words[:2] in (["NODE", "LABEL"], ["NODE", "DOF"])
            kind = words[1] if known else ""
        elif kind == "X":
            values = _numbers(text.replace(",", " "), listing, line)
            if len(values) < 4:
                raise RobotFileError(f"{text!r} is not a node's number with its x, y, z", listing, line)
            points[int(values[0])] = np.array(values[1:4])
        elif kind:
            if not set(words[1:]) <= set(LABELS):
                raise RobotFileError(f"{text!r} is not a node's number with {', '.join(LABELS)}", listing, line)
            freedoms += [(int(words[0]), LABELS.index(word)) for word in words[1:]]
    if not points or not freedoms:
        raise RobotFileError(
            "a table NODE X Y Z and a list NODE LABEL or NODE DOF of the freedoms, in the order of the matrix, would be right",
            listing,
        )
    if missing := [node for node, _ in freedoms if node not in points]:
        raise RobotFileError(f"the table NODE X Y Z has no coordinates of node {missing[0]}", listing)
    matrices = [_comma_separated(path) for path in (name, *masses)]
    if len(freedoms) > len(matrices[0]):
        raise RobotFileError(f"the matrix has {len(matrices[0])} rows for {len(freedoms)} freedoms in {listing}", name)
    return _Substructure(name, freedoms, points, matrices[0], matrices[1] if masses else None)


def _comma_separated(name: str) -> Array:
    rows: list[list[float]] = []
    lines = list(_lines(name))
    for line, text in lines:
        rows.append(_numbers(text, name, line))
        if len(rows[-1]) != len(lines):
            raise RobotFileError(
                f"the row has {len(rows[-1])} numbers; a square matrix of {len(lines)} would be right", name, line
            )
    return np.array(rows)


def _simscape(name: str, nodes: str | None) -> _Substructure:
    try:
        from scipy.io.matlab import MatReadError, loadmat
    except ImportError:
        raise ArgumentError(f"{name}: reading .mat needs SciPy: pip install 'kinetostatics[optimize]'") from None
    try:
        contents = {key: value for key, value in loadmat(name).items() if not key.startswith("__")}
    except (OSError, ValueError, NotImplementedError, MatReadError) as error:  # not implemented: version 7.3
        reason = getattr(error, "strerror", None) or "it is no .mat of version 7 or older; save(…, '-v7') would be right"
        raise RobotFileError(f"not readable: {reason}", name) from None
    structures = [value for value in contents.values() if value.dtype.names]
    if "P" not in contents and len(structures) == 1:
        contents = {key: structures[0][key].ravel()[0] for key in structures[0].dtype.names}
    if missing := [key for key in "PK" if key not in contents]:
        raise RobotFileError(f"the variable {missing[0]!r} is missing; P (n, 3), K and M would be right", name)
    P, K = (np.asarray(contents[key], dtype=float) for key in "PK")
    M = np.asarray(contents["M"], dtype=float) if "M" in contents else None
    if P.ndim != 2 or P.shape[1] != 3 or len(K) < 6 * len(P):
        raise RobotFileError(f"P has the shape {P.shape}, K {K.shape}; (n, 3) and 6n or more rows would be right", name)
    freedoms = [(node + 1, direction) for node in range(len(P)) for direction in range(6)]
    return _Substructure(name, freedoms, dict(enumerate(P, 1)), K, M)


# ---- text ----------------------------------------------------------------------------------------------------------------


def _lines(name: str) -> Iterator[tuple[int, str]]:
    """Yield the numbers and texts of the lines that are not blank."""
    try:
        with open(name, encoding="utf-8-sig") as file:
            lines = file.read().splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise RobotFileError(f"cannot be read: {getattr(error, 'strerror', None) or error}", name) from None
    yield from ((number, text.strip()) for number, text in enumerate(lines, 1) if text.strip())


def _numbers(text: str, name: str, line: int) -> list[float]:
    words = text.upper().replace("D", "E").replace(",", " ").split()
    try:
        return [float(word) for word in words]
    except ValueError:
        raise RobotFileError(f"{text[:60]!r} are no numbers", name, line) from None
