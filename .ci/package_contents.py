"""Check that a source archive and a wheel hold what they should: every file of the clone, and every file of the package."""

import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

#: Files of the clone that a wheel holds, and where.
IN_WHEEL = {"src/kinetostatics/": "kinetostatics/", "robots/": "kinetostatics/robots/"}


def tracked(archive: set[str]) -> set[str]:
    """Return the files of the clone; those of the source archive where this is no clone."""
    command = ["git", "-c", "safe.directory=*", "ls-files"]
    try:
        return set(subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines())
    except (OSError, subprocess.CalledProcessError):
        return archive - {"PKG-INFO"}


def differences(wheel: set[str], archive: set[str], files: set[str]) -> list[str]:
    """Say what is missing and what is too much in a wheel and in a source archive.

    Args:
        wheel: names of its files.
        archive: names of its files, without the folder that they are in.
        files: of the clone.
    """
    wanted = {to + name.removeprefix(start) for start, to in IN_WHEEL.items() for name in files if name.startswith(start)}
    found = {name for name in wheel if ".dist-info/" not in name}
    said = [f"the wheel lacks {name}" for name in sorted(wanted - found)]
    said += [f"the wheel holds {name}, which is no part of the package" for name in sorted(found - wanted)]
    said += [
        f"the wheel lacks {ending}"
        for ending in (".dist-info/licenses/LICENSE", ".dist-info/entry_points.txt")
        if not any(name.endswith(ending) for name in wheel)
    ]
    said += [f"the source archive lacks {name}" for name in sorted(files - archive)]
    return said + [f"the source archive holds {name}" for name in sorted(archive - files - {"PKG-INFO"})]


def main(folder: Path) -> int:
    """Print what is wrong; return 1 if something is."""
    (wheel,), (archive,) = folder.glob("*.whl"), folder.glob("*.tar.gz")
    if wheel.name.split("-")[1] != archive.name.removesuffix(".tar.gz").split("-")[1]:
        print(f"{wheel.name} and {archive.name} are of two versions")
        return 1
    with zipfile.ZipFile(wheel) as in_wheel, tarfile.open(archive) as in_archive:
        inside = {item.name.partition("/")[2] for item in in_archive.getmembers() if item.isfile()}
        said = differences(set(in_wheel.namelist()), inside, tracked(inside))
    print("\n".join(said) or f"{wheel.name} and {archive.name} hold what they should")
    return 1 if said else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
