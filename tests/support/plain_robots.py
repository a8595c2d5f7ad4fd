"""The URDFs of the package example-robot-data: ``python tests/support/plain_robots.py`` prints a table of all of them.

Each is extended as ``kinetostatics new --from`` does it, without looking at it: its platform is the first link that the error of
the missing platform proposes, its actuators are as stiff as their efforts suggest.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from places import ROOT

import kinetostatics as ks
from kinetostatics.authoring.from_urdf import extension
from kinetostatics.exceptions import PlatformMissingError
from kinetostatics.files.bundled import package_folder

PAGE = ROOT / "docs" / "how_to" / "plain_urdf.md"
FOLDER = package_folder("example-robot-data") / "robots"
#: Of actuators whose efforts are not in the file [N·m/rad].
STIFFNESS = 1000.0
HEAD = """\
| file | platform | actuators | links that could be beams | sag [mm] | compliance [µm/N] |
|---|---|---:|---:|---:|---:|
"""


@dataclass(frozen=True)
class PlainRobot:
    """One file.

    Attributes:
        file: its path in the package.
        platform: the link that was taken as the platform; empty where there is none.
        problem: why it cannot be analysed; empty where it can.
    """

    file: str
    platform: str
    problem: str

    @property
    def path(self) -> Path:
        """Where it lies."""
        return FOLDER / self.file

    def options(self) -> dict[str, object]:
        """Return the options with which it is extended."""
        plain = ks.files.read_robot_file(self.path, platform_link=self.platform)
        efforts = [plain.joints[name].effort for name in plain.driven]
        stiffness = "suggested" if any(efforts) else dict.fromkeys(plain.driven, STIFFNESS)
        return {"platform_link": self.platform, "joint_stiffness": stiffness}

    def row(self) -> str:
        """Return its row of the table."""
        robot = ks.extend_robot(self.path, **self.options())
        beams = extension(str(self.path), "", self.platform)[0].count("<beam ")
        result = ks.analyze(robot.assemble())
        sag = 1e3 * float(np.linalg.norm(result.twist[:3]))
        soft = 1e6 * float(np.linalg.norm(result.compliance[:3, :3], 2))
        numbers = " | ".join("0" if value < 1e-9 else f"{value:.3g}" for value in (sag, soft))
        return f"| `{self.file}` | `{self.platform}` | {len(robot.description.driven)} | {beams} | {numbers} |"


def files() -> list[str]:
    """Return the paths of all URDFs in the package."""
    return sorted(path.relative_to(FOLDER).as_posix() for path in FOLDER.rglob("*.urdf"))


def plain_robot(file: str) -> PlainRobot:
    """Return a file, with the platform that is taken, or that its error proposes first."""
    try:
        return PlainRobot(file, ks.load_robot(FOLDER / file).description.platform, "")
    except PlatformMissingError as error:
        return PlainRobot(file, error.likely[0], "")
    except ks.RobotFileError as error:
        return PlainRobot(file, "", error.reason)


def table() -> str:
    """Return the rows of all files, and what is wrong with the others."""
    robots = [plain_robot(file) for file in files()]
    rows = "".join(f"{robot.row()}\n" for robot in robots if not robot.problem)
    others = "".join(f"- `{robot.file}`: {robot.problem}.\n" for robot in robots if robot.problem)
    count = sum(not robot.problem for robot in robots)
    return f"{count} of {len(robots)}:\n\n{HEAD}{rows}\nThe others have nothing that moves:\n\n{others}"


def example() -> str:
    """Return the file that the page shows."""
    elastic = {"upper_arm_link": "tube 108mm 98mm aluminium", "forearm_link": "tube 86mm 78mm aluminium"}
    return extension(str(FOLDER / "ur_description" / "urdf" / "ur10_robot.urdf"), "", "tool0", elastic=elastic)[0]


if __name__ == "__main__":
    print(table())
