"""Condensing a part to its interfaces: refinement until the compliance is accurate, both grips, cache, picture."""

from __future__ import annotations

import hashlib
import io
import json
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from kinetostatics.authoring.file_arguments import MATERIALS
from kinetostatics.condensation.solids import Solid, SolidPart
from kinetostatics.description.elements import Material
from kinetostatics.description.link_matrices import LinkMatrices
from kinetostatics.engine.code import read_stored, store
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.files.link_files import KEYS
from kinetostatics.layout.mapping import ShortRepr
from kinetostatics.math.arrays import Index, frozen
from kinetostatics.output_files import replacing

#: Thermal expansion [1/K] of materials known by name.
EXPANSIONS = {"steel": 12e-6, "aluminium": 23e-6, "titanium": 8.6e-6}
#: Number of tetrahedra above which no finer mesh is made, and smallest growth of their number that counts as a refinement.
MOST, GROWTH = 6_000, 1.5
#: Largest number of displacements that are stored for pictures, 3 by coordinate and point of the surface.
PICTURED = 36_000
#: Number of the method: results of others are not taken from the cache.
METHOD = 4


@dataclass(frozen=True, repr=False)
class CondensedLink(ShortRepr):
    """A part condensed to its interfaces.

    Attributes:
        link: its matrices; internal coordinates are amplitudes of fixed-interface modes.
        grip: grip of the interfaces, see :func:`kinetostatics.condense`.
        change: largest relative change of the compliance, under any wrenches, from the mesh before to the last one.
        error: estimate of the largest relative error of the compliance: the change, if errors fall with the edges' lengths.
        between_grips: largest relative difference of the compliance with even grips from that with rigid ones.
        tetrahedra: number of tetrahedra of the last mesh.
        owner: number (T,) of the interface of each of the link's ``triangles``, or −1.
    """

    link: LinkMatrices
    grip: str
    change: float
    error: float
    between_grips: float
    tetrahedra: int
    owner: Index = field(repr=False)

    def __str__(self) -> str:
        size = " x ".join(f"{1000 * length:.4g}" for length in np.ptp(np.asarray(self.link.points), axis=0))
        return (
            f"{size} mm, {self.link.body[0]:.5g} kg, {self.link.internal} modes, {self.tetrahedra} tetrahedra\n"  # type: ignore[index]
            f"compliance, {self.grip} grips: up to about {100 * self.error:.2g} % too small, for the last refinement "
            f"changed it by {100 * self.change:.2g} %\n"
            f"compliance, even grips: up to {100 * self.between_grips:.2g} % larger than with rigid ones"
        )

    def save_picture(self, path: str | os.PathLike[str]) -> None:
        """Write a picture of the surface and the interfaces (PNG or SVG); it needs Matplotlib."""
        from matplotlib.figure import Figure
        from mpl_toolkits.mplot3d.art3d import Poly3DCollection

        figure = Figure(figsize=(6, 6))
        points, triangles = 1000 * np.asarray(self.link.points), np.asarray(self.link.triangles)
        axes = figure.add_subplot(projection="3d", xlabel="x [mm]", ylabel="y [mm]", zlabel="z [mm]")
        for number, name in enumerate(("", *self.link.names), -1):
            colour, corners = f"C{number}" if name else "#c8c8c840", points[triangles[self.owner == number]]
            edge = colour if name else "#40404060"
            axes.add_collection3d(Poly3DCollection(corners, facecolors=colour, edgecolors=edge, linewidth=0.15))
            if name:
                axes.text(*(1000 * self.link.origins[number]), f"   {name}", color=colour, fontweight="bold", zorder=9)
        low, high = points.min(0), points.max(0)
        axes.set(**{f"{axis}lim": (low[k], high[k]) for k, axis in enumerate("xyz")}, aspect="equal")
        axes.locator_params(nbins=4)
        with replacing(path) as partial:
            figure.savefig(partial, dpi=200, bbox_inches="tight", format=Path(path).suffix[1:])


def condense(
    path: str | os.PathLike[str],
    interfaces: Mapping[str, str],
    material: str | Material = "steel",
    within: float = 0.01,
    modes: int = 6,
    grip: Literal["rigid", "even"] = "rigid",
    unit: Literal["m", "mm"] | None = None,
) -> CondensedLink:
    """Condense a part to its interfaces, by solid finite elements (extra ``cad``).

    The result is stored, and used again for the same content of the file and the same arguments.

    Args:
        path: a STEP or STL file, or a volume mesh of Netgen (``.vol``) or Gmsh (``.msh``), in the link's axes.
        interfaces: by name of the joint, or ``o``: ``cylinder d=20mm near 0 0 0`` (a bore or a shaft), ``face near 0 0 400mm``,
            ``face NAME``, or ``sphere r=10mm at 0 0 0`` (the surface inside it). Lengths without unit are in metres.
        material: ``steel``, ``aluminium``, ``titanium``, ``carbon``, or a material with density and Poisson ratio.
        within: the mesh is refined until the compliance, under any wrenches, changes by no more than this fraction.
        modes: number of fixed-interface modes, the lowest ones.
        grip: ``rigid``: an interface moves as a rigid body; ``even``: its mean motion counts, forces are spread evenly.
        unit: unit of an STL file or a mesh; None: mm if the part would be larger than 5 m.

    Raises:
        ArgumentError: the file cannot be read, an interface is not on the part, or NGSolve is not installed.
    """
    path, chosen = Path(path), _material(material)
    if len(interfaces) < 2 or not 0 < within < 1 or modes < 0 or grip not in ("rigid", "even") or unit not in ("m", "mm", None):
        right = "interfaces: 2 or more, within: between 0 and 1, modes: 0 or more, grip: rigid or even, unit: m or mm"
        raise ArgumentError(f"{right}; given are {len(interfaces)}, {within}, {modes}, {grip}, {unit}")
    try:
        content = path.read_bytes()
    except OSError as error:
        raise ArgumentError(f"{path} cannot be read: {error.strerror}") from None
    settings = [METHOD, path.suffix.lower(), dict(interfaces), asdict(chosen), within, modes, grip, unit]
    key = "part-" + hashlib.sha256(content + json.dumps(settings).encode()).hexdigest()
    stored = read_stored(key)
    if stored is None:
        result = _condensed(SolidPart(path, unit), interfaces, chosen, within, modes, grip)
        file, arrays = io.BytesIO(), {name: getattr(result.link, name) for name in KEYS} | vars(result) | {"link": None}
        np.savez(file, allow_pickle=False, **{name: value for name, value in arrays.items() if value is not None})
        store(key, file.getvalue())
        return result
    with np.load(io.BytesIO(stored), allow_pickle=False) as opened:
        values = {name: frozen(opened[name]) for name in opened}
    link = LinkMatrices(**{name: values.pop(name) for name in KEYS if name in values})
    return CondensedLink(link, **{name: value if value.ndim else value.item() for name, value in values.items()})


def _condensed(
    part: SolidPart, places: Mapping[str, str], material: Material, within: float, modes: int, grip: str
) -> CondensedLink:
    before, change, error, tetrahedra = None, np.inf, np.inf, 0
    for level in range(12):
        solid = Solid(part, level, places, material)
        if solid.tetrahedra < GROWTH * tetrahedra:
            continue
        longer = (solid.tetrahedra / tetrahedra) ** (1 / 3) if tetrahedra else 1.0
        tetrahedra = solid.tetrahedra
        stiffness, shapes, solve = solid.gripped(grip)
        compliance = np.linalg.inv(stiffness[6:, 6:])
        if before is not None:
            change = _difference(compliance, before)
            error = change / (longer - 1)  # beside edges of rigid grips stresses are infinite, and convergence is of first order
        before = compliance
        if change <= within or tetrahedra > MOST:
            break
    squares, modal = solid.modes(solve, modes) if modes else (np.zeros(0), shapes[:, :0])
    whole, outer = np.hstack([shapes, modal]), len(stiffness)
    K = np.diag(np.concatenate([np.zeros(outer), squares]))
    K[:outer, :outer] = stiffness
    thermal = whole.T @ solid.thermal if material.thermal_expansion else None
    points, triangles, recovery, owner = solid.pictured(whole, PICTURED // (3 * len(K)))
    mass, drawn = whole.T @ solid.with_mass(whole), (points, triangles, recovery)
    link = LinkMatrices(tuple(places), solid.origins, K, mass, None, thermal, *drawn)
    other = "even" if grip == "rigid" else "rigid"
    both = {grip: compliance, other: np.linalg.inv(solid.gripped(other)[0][6:, 6:])}
    between = _difference(both["even"], both["rigid"])
    return CondensedLink(link, grip, change, error, between, solid.tetrahedra, frozen(owner))


def _difference(compliance: NDArray[np.floating], other: NDArray[np.floating]) -> float:
    """Return the largest relative difference of the work of any wrenches, |wᵀ (C − C′) w| / wᵀ C′ w."""
    root = np.linalg.cholesky(np.linalg.inv((other + other.T) / 2))
    return float(np.abs(np.linalg.eigvalsh(root.T @ (compliance - other) @ root)).max())


def _material(material: str | Material) -> Material:
    if isinstance(material, Material):
        if not material.density or material.poisson_ratio is None:
            raise ArgumentError("material: it needs a density and a Poisson ratio")
        return material
    if material not in MATERIALS:
        raise ArgumentError(f"material: there is no {material!r}; {near_names(material, MATERIALS)}")
    youngs_modulus, ratio, density = MATERIALS[material]
    return Material(youngs_modulus, ratio, density=density, thermal_expansion=EXPANSIONS.get(material, 0.0))
