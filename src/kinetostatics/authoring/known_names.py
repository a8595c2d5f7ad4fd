"""Mechanisms with names in the field, as examples of the notation."""

from __future__ import annotations

import re
from dataclasses import dataclass

from kinetostatics.files.bundled import shipped_robots


@dataclass(frozen=True)
class KnownName:
    """A mechanism with a name in the field.

    Attributes:
        architecture: its limbs in the notation.
        about: what it is.
        arrangement: how its limbs stand, if not evenly around the vertical.
        words: its names, in small letters and digits alone; short ones count only as a whole.
        robot: one of the kind that comes with the package.
    """

    architecture: str
    about: str
    arrangement: str = "symmetric"
    words: tuple[str, ...] = ()
    robot: str = ""

    @property
    def line(self) -> str:
        """The name with its description, in one line."""
        needs = "" if self.arrangement == "symmetric" else f", with --arrangement {self.arrangement}"
        return f"{self.architecture:16} {self.about}{needs}"


KNOWN_NAMES = (
    KnownName("3-R[P]S", "three telescopes, as the paper's 3RPS: one translation, two rotations", robot="3rps"),
    KnownName("3-[P]RS", "carriages and rods: the same freedoms, a Sprint Z3", words=("sprint", "z3"), robot="3prs"),
    KnownName("2-[P]RU+U[P]R", "two rods on sliders and a telescope, the paper's 2PRU-UPR", robot="2pru_upr"),
    KnownName("2-U[P]R+S[P]R", "Exechon", words=("exechon",), robot="exechon"),
    KnownName("3-U[P]S+UP", "Tricept: the tube in the middle is passive", words=("tricept",), robot="tricept"),
    KnownName("6-U[P]S", "Gough-Stewart platform", words=("stewart", "gough", "hexapod", "6dof"), robot="gough_stewart"),
    KnownName("6-[R]US", "hexapod with cranks", words=("hexapod", "hexa"), robot="6rus"),
    KnownName("3-[R](4S)", "Delta: cranks and pairs of rods", words=("delta", "clavel"), robot="delta"),
    KnownName("3-[P](4S)", "linear Delta", words=("lineardelta", "keops"), robot=""),
    KnownName("3-[P]UU", "linear Delta with one rod in each limb", words=("lineardelta",), robot="linear_delta"),
    KnownName("3-U[P]U", "three translations by telescopes"),
    KnownName("3-[P]RRR", "Tripteron", "cartesian", words=("tripteron",), robot="tripteron"),
    KnownName("3-[P]R(4R)R", "Orthoglide", "cartesian", words=("orthoglide",), robot="orthoglide"),
    KnownName(
        "[R]RR+[R]R",
        "five-bar linkage: a point in a plane",
        "planar",
        words=("5r", "rrrrr", "fivebar", "scara"),
        robot="five_bar",
    ),
    KnownName("3-[R]RR", "two translations and a rotation in a plane", "planar", robot="planar_3rrr"),
    KnownName("3-R[P]R", "the same with telescopes", "planar"),
    KnownName(
        "3-[R]RR", "three rotations about a point, an Agile Eye", "spherical", words=("agileeye", "wrist"), robot="spherical_3rrr"
    ),
)


def answer_to_name(text: str) -> str:
    """Return the notation for a mechanism's common name, such as "Stewart platform" or "5R"; nothing if it is unknown."""
    name = _plain(text)
    found = [known for known in KNOWN_NAMES if any(name == word or (len(word) > 3 and word in name) for word in known.words)]
    robots = [robot for robot in shipped_robots() if _plain(robot) == name] or [known.robot for known in found if known.robot]
    ready = f"ready to be changed: kinetostatics robots --copy {' or '.join(robots)}" if robots else ""
    if not found:
        return f"{text!r} comes with the package, {ready}" if robots else ""
    limbs = " or ".join(known.line.replace(known.architecture, known.architecture + ":", 1) for known in found)
    return f"{text!r} is a name; write its limbs: {' '.join(limbs.split())}{'; ' * bool(ready)}{ready}"


def _plain(text: str) -> str:
    return re.sub("[^a-z0-9]", "", text.lower())
