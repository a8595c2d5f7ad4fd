"""All that the package computes for many robots, stored and compared: what a change of the code leaves as it was, and what not.

    python tests/reference.py store FOLDER                # of the present code: some minutes a core
    python tests/reference.py compare FOLDER              # the present code against it; exit 1 where anything differs
    python tests/reference.py compare FOLDER 3rps case:   # only what begins with one of these names

FOLDER/renamed.json, if it is there, says how parts of places in the stored results are called now: {"old": "new", …}.

Stored are, of the robots of the package, of ``tests/cases`` and of random robots: what ``check`` tells; zero pose; poses by
actuators and by every kind of orientation, from near to out of reach; all that analyses tell, under loads, payload and assembly
errors, by both engines; functions and Jacobians; maps; sensitivities, variation, tolerances, compensation, calibration. Texts and
statuses must be the same. Numbers may differ by 1e-11 of the largest of their array, and by what rounding makes of them: each
analysis is repeated at coordinates that differ in their last digits.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(variable, "1")
sys.path[:0] = [str(Path(__file__).parent / "support")]

import hybrid_robots
import numpy as np
import small_robots

import kinetostatics as ks

TESTS = Path(__file__).parent
ROBOTS = sorted(path.name.partition(".")[0] for path in (TESTS.parent / "robots").glob("*.xacro"))
CASES = sorted((TESTS / "cases").glob("*.urdf*"))
RANDOM = 60
#: Relative to the largest number of an array, absolute, and how many times what rounding of the pose makes of it.
CLOSE, LEAST, NOISE = 1e-11, 1e-15, 100.0
ORIENTATIONS = (None, "XYZ", "zyx", "tilt_torsion")
_TILT = {"rx": "tilt", "ry": "azimuth", "rz": "torsion"}
#: What says how a result was made, not what it is.
_NOT_COMPARED = ("units", "file", "date", "history", "robot_files", "robot_path", "arguments", "sweep_sha256")

#: What was found: texts, numbers as arrays, and what rounding of the pose makes of these, by place.
Found = dict[str, object]


def subjects() -> list[str]:
    """Return the names of all that is stored."""
    random = [f"{kind}:{seed}" for kind in ("serial", "hybrid") for seed in range(RANDOM)]
    return [*ROBOTS, *(f"case:{path.name}" for path in CASES), *random]


def robot_named(name: str) -> ks.Robot:
    """Return a robot by its name among the subjects."""
    kind, _, which = name.partition(":")
    if kind == "case":
        return ks.load_robot(TESTS / "cases" / which)
    if kind == "serial":
        rng = np.random.default_rng(int(which))
        limbs = [str(limb) for limb in rng.choice(small_robots.LIMBS, rng.integers(2, 5))]
        return small_robots.robot_of(small_robots.random_spec(limbs, int(which)))
    if kind == "hybrid":
        return hybrid_robots.write_randomly(hybrid_robots.random_hybrid(int(which)), int(which))[1].robot()
    return ks.load_robot(name)


def flat(value: object, place: str = "") -> Iterator[tuple[str, object]]:
    """Yield the parts of plain values with their places; lists of numbers as arrays, None as NaN."""
    if isinstance(value, dict):
        for key, part in value.items():
            if key not in _NOT_COMPARED:
                yield from flat(part, f"{place}/{key}")
        return
    if isinstance(value, (list, tuple, np.ndarray, float, int)) and not isinstance(value, bool):
        try:
            yield place, np.array(value, dtype=float)
            return
        except (TypeError, ValueError):
            pass
    if isinstance(value, (list, tuple)):
        for number, part in enumerate(value):
            yield from flat(part, f"{place}/{number}")
        return
    yield place, str(value)


def attempt(out: Found, place: str, compute: Callable[[], object]) -> object:
    """Put what something computes, or its error in words, at a place; return it."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            found = compute()
        except ks.KinetostaticsError as error:
            out[place] = f"{type(error).__name__}: {error}"
            return None
    out[f"{place}/warned"] = "\n".join(dict.fromkeys(str(item.message) for item in told))
    plain = found.to_dict() if hasattr(found, "to_dict") else found
    if isinstance(plain, (dict, list, np.ndarray, float)):
        out.update(flat(plain, place))
    return found


def study(name: str) -> tuple[str, Found]:
    """Return all that is found about a robot."""
    out: Found = {}
    robot = attempt(out, "robot", lambda: robot_named(name))
    if robot is None:
        return name, out
    facts = robot.to_dict()
    out.update(flat(facts, "check"))
    rng = np.random.default_rng(1)
    zero = attempt(out, "zero", robot.assemble)
    if zero is not None:
        analyses(out, "zero", robot, zero)
    few = name not in ROBOTS
    for place, configuration in poses(out, robot, facts, zero, rng, 8 if few else 24):
        analyses(out, place, robot, configuration)
    if not few and zero is not None:
        designs(out, name, robot, facts, zero)
    return name, out


def poses(out: Found, robot: ks.Robot, facts: dict, zero: ks.Configuration | None, rng: np.random.Generator, count: int):
    """Yield batches of poses, from near the zero pose to out of reach, by actuators and by platform coordinates."""
    size = np.linspace(0.02, 1.2, count)
    turning = ("revolute", "continuous")
    parts = {**robot.description.joints, **robot.description.loops}
    reach = {joint: 1.0 if parts[joint].type in turning else robot.length for joint in robot.description.actuated}
    ways: list[tuple[str, dict]] = [
        ("actuators", {"actuators": {name: reach[name] * size * rng.uniform(-1, 1, count) for name in reach}})
    ]
    names = facts["mobility"]["coordinates"]
    if names and zero is not None:
        for orientation in ORIENTATIONS if count > 8 else (None,):
            steps = {key: (robot.length if key in "xyz" else 1.0) * size * rng.uniform(-1, 1, count) for key in names}
            target = {key: float(zero.platform[key]) + step for key, step in steps.items()}
            if orientation == "tilt_torsion":
                target = {_TILT.get(key, key): value for key, value in target.items()}
            ways.append((f"platform {orientation}", {"platform": target, "orientation": orientation}))
    for place, arguments in ways:
        for engine in ("numpy", "compiled"):
            where = f"{place} {engine}"
            found = attempt(
                out,
                where,
                lambda arguments=arguments, engine=engine: robot.assemble(
                    **arguments, closure_tolerance=1e-6, on_failure="nan", engine=engine
                ),
            )
            if found is not None:
                yield where, found


def analyses(out: Found, place: str, robot: ks.Robot, configuration: ks.Configuration) -> None:
    """Put analyses of a batch of poses under several loads, by both engines, and what rounding makes of the first."""
    description = robot.description
    load, gravity = [20.0, -30, -50, 3, 2, -1], [1.0, -2, -9]
    errors = {beam: {"length": 1e-4} for beam in list(description.beams)[:2]}
    options: dict[str, dict] = {
        "load": {"load": load, "gravity": gravity},
        "payload": {
            "load": load,
            "payload": ks.Payload(3.0, center=(0.05, 0.02, -0.1)),
            "point": (0.1, 0, 0),
            "frame": "platform",
        },
        "errors": {"gravity": gravity, "assembly_errors": errors},
    }
    for kind, arguments in options.items():
        if kind == "errors" and not errors:
            continue
        for engine in ("numpy", "compiled") if kind == "load" else ("numpy",):
            attempt(
                out,
                f"{place}/{kind} {engine}",
                lambda arguments=arguments, engine=engine: ks.analyze(
                    configuration, **arguments, on_failure="nan", engine=engine
                ),
            )
    rng, q = np.random.default_rng(2), np.asarray(configuration.q)
    for number in range(2):
        moved = np.where(np.isfinite(q), q, 0.0) * (1 + 4e-16 * rng.integers(-4, 5, q.shape)) + 1e-16 * rng.integers(
            -4, 5, q.shape
        )
        try:
            again = robot.configuration(moved, closure_tolerance=1.0, on_failure="nan")
            found = ks.analyze(again, load=load, gravity=gravity, on_failure="nan", engine="numpy").to_dict()
        except ks.KinetostaticsError:
            return
        out.update((f"noise {number} {place}/load numpy{key}", value) for key, value in flat(found) if not isinstance(value, str))


def designs(out: Found, name: str, robot: ks.Robot, facts: dict, zero: ks.Configuration) -> None:
    """Put functions, maps and design studies of a robot of the package."""
    names = facts["mobility"]["coordinates"]
    near = {key: float(zero.platform[key]) + (0.02 * robot.length if key in "xyz" else 0.05) for key in names}
    pose = attempt(out, "near", lambda: robot.assemble(platform=near, near=zero))
    if pose is None:
        return
    load = [20.0, -30, -50, 3, 2, -1]
    grid = {key: np.linspace(value - 0.03 * robot.length, value + 0.03 * robot.length, 4) for key, value in near.items()}
    attempt(
        out, "map", lambda: ks.sweep(robot, platform=dict(list(grid.items())[:3]) | {k: near[k] for k in names[3:]}, load=load)
    )
    attempt(out, "compensate", lambda: ks.compensate(pose, load=load))
    attempt(out, "tolerances", lambda: ks.tolerances(pose))
    attempt(out, "sensitivities", lambda: ks.sensitivities(pose, load=load))
    moduli = [f"{beam}.youngs_modulus" for beam in list(robot.description.beams)[:2]]
    attempt(out, "variation", lambda: ks.tolerances(pose, dict.fromkeys(moduli, "1%"), samples=50, seed=1, load=load))

    function = attempt(out, "function", lambda: ks.compile(robot, platform=names, outputs=["twist", "actuator_forces"]))
    if function is not None:
        attempt(out, "function/values", lambda: dict(function(**near, load=load)))
        kinds = {parameter.partition(".")[2]: parameter for parameter in function.parameters}  # one of each kind
        by = ["load", "gravity", *names, *kinds.values()]
        jacobian = function.jacobian("twist", by)
        attempt(out, "function/jacobian", lambda: {of: dict(parts) for of, parts in jacobian(**near, load=load).items()})


def store(folder: Path, names: list[str]) -> None:
    """Compute and write all subjects."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, found in computed(names):
        safe = name.replace(":", "__")
        texts = {key: value for key, value in found.items() if isinstance(value, str)}
        (folder / f"{safe}.json").write_text(json.dumps(texts), encoding="utf-8")
        np.savez_compressed(
            folder / f"{safe}.npz", **{key.replace("/", "|"): v for key, v in found.items() if not isinstance(v, str)}
        )
        print(f"{name}: {len(found)} texts and arrays", flush=True)


def computed(names: list[str]) -> Iterator[tuple[str, Found]]:
    """Yield what is found about each subject, with all cores."""
    with ProcessPoolExecutor(max_workers=os.cpu_count()) as pool:
        yield from pool.map(study, names, chunksize=1)


def compare(folder: Path, names: list[str]) -> int:
    """Print what differs from what is stored; return how many places do."""
    total = 0
    table = folder / "renamed.json"
    renamed = json.loads(table.read_text(encoding="utf-8")) if table.exists() else {}
    for name, found in computed(names):
        safe = name.replace(":", "__")
        stored: Found = json.loads((folder / f"{safe}.json").read_text(encoding="utf-8"))
        with np.load(folder / f"{safe}.npz") as arrays:
            stored |= {key.replace("|", "/"): arrays[key] for key in arrays.files}
        for old, new in renamed.items():
            stored = {key.replace(old, new): value for key, value in stored.items()}
        differences = list(differing(stored, found))
        total += len(differences)
        print(f"{name}: {len(differences)} of {len(found)} differ" if differences else f"{name}: the same", flush=True)
        kinds: dict[str, list[str]] = {}
        for line in differences:
            kinds.setdefault(re.sub(r"[0-9]+", "#", line.partition(": ")[0].rpartition("/")[2]), []).append(line)
        for kind, lines in kinds.items():
            print(f"    {kind}, {len(lines)} times, such as {lines[0]}", flush=True)
    return total


def differing(stored: Found, found: Found) -> Iterator[str]:
    """Yield what differs, in words."""
    for key in sorted({*stored, *found}):
        if key.startswith("noise ") or key.rpartition("/")[2] in _NOT_COMPARED:
            continue
        if key not in stored or key not in found:
            yield f"{key}: only {'found now' if key in found else 'stored'}"
            continue
        old, new = stored[key], found[key]
        if isinstance(old, str) or isinstance(new, str):
            if old != new:
                yield f"{key}: {str(old)[:150]!r} -> {str(new)[:150]!r}"
            continue
        old, new = np.asarray(old), np.asarray(new)
        if old.shape != new.shape or np.any(np.isnan(old) != np.isnan(new)):
            yield f"{key}: shape or NaN: {old.shape} -> {new.shape}"
            continue
        allowed = LEAST + CLOSE * np.nanmax(np.abs(old), initial=0.0) + NOISE * rounding(stored, key, old)
        off = np.nan_to_num(np.abs(new - old))
        if np.any(off > allowed):
            largest = np.nanmax(np.abs(old), initial=0.0)
            yield f"{key}: by {np.max(off):.2e} of {largest:.2e}, rounding {np.max(rounding(stored, key, old)):.1e}"


def rounding(stored: Found, key: str, old: np.ndarray) -> float:
    """Return what rounding of the pose makes of an array of an analysis, the largest of two trials."""
    place, _, rest = key.partition("/")
    kind, _, inner = rest.partition("/")
    if not kind.startswith(("load", "payload", "errors")):
        return 0.0
    found = 0.0
    for number in range(2):
        trial = stored.get(f"noise {number} {place}/load numpy/{inner}")
        if trial is not None and np.shape(trial) == old.shape:
            base = stored.get(f"{place}/load numpy/{inner}")
            found = max(found, float(np.nanmax(np.abs(np.asarray(trial) - np.asarray(base)), initial=0.0)))
    return found


def main() -> int:
    """Run the command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("store", "compare"))
    parser.add_argument("folder", type=Path)
    parser.add_argument("names", nargs="*")
    args = parser.parse_args()
    names = [name for name in subjects() if not args.names or name.startswith(tuple(args.names))]
    if args.what == "store":
        store(args.folder, names)
        return 0
    return 1 if compare(args.folder, names) else 0


if __name__ == "__main__":
    raise SystemExit(main())
