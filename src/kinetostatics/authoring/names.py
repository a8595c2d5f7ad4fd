"""Names that are known in the field, as examples of the notation."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class KnownName:
    """A mechanism with a name in the field.

    Attributes:
        architecture: its limbs in the notation.
        about: what it is.
        arrangement: how its limbs stand, if not evenly around the vertical.
    """

    architecture: str
    about: str
    arrangement: str = "symmetric"

    @property
    def line(self) -> str:
        """The name, and what it is, in a line."""
        needs = "" if self.arrangement == "symmetric" else f", with --arrangement {self.arrangement}"
        return f"{self.architecture:16} {self.about}{needs}"


KNOWN_NAMES = (
    KnownName("3-R[P]S", "three telescopes, as the paper's 3RPS: one translation, two rotations"),
    KnownName("3-[P]RS", "carriages and rods: the same freedoms, a Sprint Z3"),
    KnownName("2-[P]RU+U[P]R", "two rods on sliders and a telescope, the paper's 2PRU-UPR"),
    KnownName("2-U[P]R+S[P]R", "Exechon"),
    KnownName("3-U[P]S+UP", "Tricept: the tube in the middle is passive"),
    KnownName("6-U[P]S", "Gough-Stewart platform"),
    KnownName("6-[R]US", "hexapod with cranks"),
    KnownName("3-[R](4S)", "Delta: cranks and pairs of rods"),
    KnownName("3-[P](4S)", "linear Delta"),
    KnownName("3-[P]UU", "linear Delta with one rod in each limb"),
    KnownName("3-U[P]U", "three translations by telescopes"),
    KnownName("3-[P]RRR", "Tripteron", "cartesian"),
    KnownName("3-[P]R(4R)R", "Orthoglide", "cartesian"),
    KnownName("3-[R]RR", "two translations and a rotation in a plane", "planar"),
    KnownName("3-R[P]R", "the same with telescopes", "planar"),
    KnownName("3-[R]RR", "three rotations about a point, an Agile Eye", "spherical"),
)
