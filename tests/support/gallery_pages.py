"""Writes what the gallery says of the robots that come with the package: ``python tests/support/gallery_pages.py``.

Each robot's page has a table of facts between two markers, and the gallery a card and a row of every robot; pictures are drawn by
``python examples/make_pictures.py``, sketches by ``python examples/kinematic_sketches.py --docs``.
"""

from __future__ import annotations

import re
from functools import cache
from itertools import groupby
from pathlib import Path

import numpy as np
from places import ROOT

import kinetostatics as ks
from kinetostatics.checks.check import diagnose
from kinetostatics.files.bundled import shipped_robots

GALLERY = ROOT / "docs" / "gallery"
PAGES = GALLERY / "robots"
INDEX = GALLERY / "index.md"
#: What a card describes: limbs and motion of each robot, in the order of the gallery.
KINDS = {
    "3rps": "Telescopic legs on hinges; z and two tilts",
    "2pru_upr": "Rods on sliders and a telescopic leg; z and two tilts",
    "gough_stewart": "Telescopic legs; all six freedoms",
    "tricept": "Telescopic legs around a passive one; x, y and z",
    "exechon": "Telescopic legs; z and two tilts",
    "6rus": "Rods on cranks; all six freedoms",
    "3prs": "Links on carriages; z and two tilts",
    "five_bar": "Two arms in a plane; x and y",
    "planar_3rrr": "Three arms in a plane; x, y and its rotation",
    "spherical_3rrr": "Curved links about a point; three rotations",
    "delta": "Hybrid limbs: arms and parallelograms of rods; x, y and z",
    "linear_delta": "Rods on carriages; x, y and z",
    "orthoglide": "Hybrid limbs: planar parallelograms on rails; x, y and z",
    "tripteron": "Arms on rails, elastic actuators; x, y and z",
    "ur10": "A serial arm, one limb; all six freedoms",
    "anymal_standing": "A quadruped, its trunk on four legs; all six freedoms, twelve actuators",
}
#: Facts that stand in the table of the gallery, not on the pages.
COUNTS = ("mobility", "redundant constraints", "local freedoms", "all that moves, at zero")


def page_of(name: str) -> Path:
    """Return the page of a robot."""
    return PAGES / f"{name}.md"


def title_of(name: str) -> str:
    """Return the heading of a robot's page."""
    return page_of(name).read_text(encoding="utf-8").partition("\n")[0].removeprefix("# ")


# ---- facts -----------------------------------------------------------------------------------------------------------------


@cache
def facts(name: str) -> dict[str, str]:
    """Return what is computed of a robot, each in words."""
    robot = ks.load_robot(shipped_robots()[name])
    words = [limb.word.replace(" ", "").replace("|", "‖") for limb in diagnose(robot).limbs]
    limbs = groupby(re.sub(r"(\w)\(actuated\)", r"[\1]", word) for word in words)
    alike = " + ".join(f"{count}-{word}" if count > 1 else word for word, count in ((w, len(list(g))) for w, g in limbs))
    result = ks.analyze(robot.assemble())
    moved = re.search(r"; (o moves .*?)(, the platform turns by 0 \S+)?>", repr(result))
    assert moved is not None
    soft, *_, stiff = 1e-6 / np.linalg.eigvalsh(result.compliance[:3, :3])[::-1]
    mass = float(robot.weights.masses(robot.zero_frames).sum())
    return {
        "limbs": f"`{alike}`",
        "mobility": str(robot.mobility.platform),
        "redundant constraints": str(robot.mobility.redundant_constraints),
        "local freedoms": str(robot.mobility.local),
        "all that moves, at zero": f"{mass:.4g} kg",
        "sag": moved[1],
        "stiffness": f"{soft:.4g} … {stiff:.4g} N/µm",
    }


def facts_table(name: str) -> str:
    """Return the table of a robot's page."""
    file = f"| file | [`{name}.urdf.xacro`](../../../robots/{name}.urdf.xacro) |\n"
    sketch = f"\n![Sketch](../../pictures/sketches/{name}.svg)\n"
    rows = ((key, value) for key, value in facts(name).items() if key not in COUNTS)
    return "| | |\n|---|---|\n" + file + "".join(f"| {key} | {value} |\n" for key, value in rows) + sketch


def cards() -> str:
    """Return the cards of the gallery."""
    lines = ['<div class="grid cards" markdown>\n']
    for name, kind in KINDS.items():
        title = title_of(name)
        lines.append(
            f"-   [![{title}](../pictures/robots/{name}.webp)](robots/{name}.md)\n\n"
            f"    **[{title}](robots/{name}.md)** · {facts(name)['limbs']}\n\n    {kind}.\n"
        )
    return "\n".join([*lines, "</div>\n"])


def rows() -> str:
    """Return the table of the gallery."""
    lines = ["| robot | mobility | redundant constraints | local freedoms | moving mass |", "|---|---:|---:|---:|---:|"]
    for name in KINDS:
        cells = [f"[`{name}`](robots/{name}.md)", *(facts(name)[key] for key in COUNTS)]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


# ---- writing ---------------------------------------------------------------------------------------------------------------


def between(name: str) -> re.Pattern[str]:
    """Return the pattern of what stands between two markers."""
    return re.compile(rf"(?<=<!-- {name}: begin -->\n).*?(?=<!-- {name}: end -->)", re.DOTALL)


def fresh(page: Path) -> str:
    """Return a page of the gallery as it should be."""
    text = page.read_text(encoding="utf-8")
    if page == INDEX:
        text = between("cards").sub(lambda _: cards() + "\n", text)
        return between("robots").sub(lambda _: rows(), text)
    return between("facts").sub(lambda _: facts_table(page.stem), text)


if __name__ == "__main__":
    for path in (*map(page_of, KINDS), INDEX):
        path.write_text(fresh(path), encoding="utf-8")
