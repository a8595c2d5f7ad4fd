"""What is measured for the page, topic by topic, and what is said about it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import grids
import scaling
import yardsticks
from opensees_frames import OpenSees
from page import Page, mebibytes, micro, report, table, times


@dataclass(frozen=True)
class Effort:
    """How much is measured.

    Attributes:
        poses: of a grid.
        frames: how many of them OpenSees solves.
        repeats: how often everything is measured.
        sizes: of the maps in processes of their own, each with its repeats.
        cores: poses of the maps on several cores.
        robots, edges: which are compared with OpenSees, and with poses out of reach.
    """

    poses: int
    frames: int
    repeats: int
    sizes: tuple[tuple[int, int], ...]
    cores: int
    robots: tuple[str, ...] = tuple(grids.WORKSPACES)
    edges: tuple[str, ...] = tuple(grids.EDGES)


FULL = Effort(20_000, 20, 3, ((5_000, 6), (20_000, 5), (100_000, 2), (1_000_000, 1)), 100_000)
QUICK = Effort(20_000, 10, 1, ((5_000, 3), (20_000, 2), (100_000, 1)), 40_000)
TINY = Effort(200, 2, 1, ((300, 1),), 300, ("3rps", "five_bar"), ("2pru_upr",))

#: How OpenSees is asked, and how often faster a robot is wanted to be.
WAYS = (("plain", "A, as `verify` asks it"), ("all_cases", "B, all numbers, lean"), ("one", "C, one analysis, lean"))
WANTED = {"3rps": 150, "2pru_upr": 150, "gough_stewart": 80}
AT_LEAST = 30


def opensees(page: Page, effort: Effort) -> None:
    """All robots beside OpenSeesPy."""
    solver = OpenSees()
    found = {}
    for name in effort.robots:
        found[name] = yardsticks.compare(name, effort.poses, effort.frames, effort.repeats, solver)
        report(f"{name}: {micro(found[name].ours)} µs, OpenSees {micro(found[name].plain)}")

    def ratio(name: str, way: str) -> float:
        return float(getattr(found[name], way) / found[name].ours)

    way, said = WAYS[0]
    for name, wanted in WANTED.items():
        if name in found:
            reached = ratio(name, way)
            page.require(f"`{name}`: times faster than OpenSeesPy, {said}", f"≥ {wanted}", times(reached), reached >= wanted)
    low = min(found, key=lambda name: ratio(name, way))
    short = [name for name in found if ratio(name, way) < AT_LEAST]
    all_of_them = f"{times(ratio(low, way))} (`{low}`); {len(found) - len(short)} of {len(found)} robots reach it"
    page.require(f"every robot: times faster than OpenSeesPy, {said}", f"≥ {AT_LEAST}", all_of_them, not short)
    rows = []
    for name, item in found.items():
        parts = " + ".join(micro(part) for part in item.parts)
        theirs = [micro(getattr(item, way)) for way, _ in WAYS]
        ratios = [times(ratio(name, way)) for way, _ in WAYS]
        wanted = str(WANTED.get(name, AT_LEAST))
        own = (f"{item.poses:,}", micro(item.ours), parts, micro(item.sweep))
        rows.append((f"`{name}`", *own, *theirs, *ratios, wanted, f"{item.difference:.0e}"))
    head = ("robot", "poses", "map", "loops + statics + arrays", "`ks.sweep`", "A", "B", "C")
    spans = {key: [times(pick(ratio(name, key) for name in found)) for pick in (min, max)] for key, _ in WAYS}
    page.add(
        "Beside OpenSeesPy",
        OPENSEES.format(frames=effort.frames, **{key: f"{low} … {high}" for key, (low, high) in spans.items()}),
        table((*head, "A : map", "B : map", "C : map", "wanted", "difference"), rows),
    )


OPENSEES = """\
Processor time per pose in microseconds. **map**: from the arrays of coordinates to everything that a map holds: loops
closed (`robot.assemble`), `twist`, `contributions`, `stiffness`, `compliance`, `actuator_forces`, `status`, every
limb's `intensities` and `attached_intensities`. **`ks.sweep`**: the same as a labelled Dataset in memory by one
process, with joints' coordinates, and every pose compared with its neighbours. OpenSeesPy builds and solves {frames}
poses of the same grid in the same process. It is told where all points are: closing the loops is not counted for it.
It can be asked in three ways:

- **A**: the frame of `kinetostatics verify` at one of its penalties, with an element for every joint of the file and
springs in all six directions. Three analyses under the loads, the second and third of what rounding has left
unbalanced, and two under each of six unit loads; the answer is the twist, the compliance and all forces. The matrix
is made anew for each.
- **B**: as fast as we could make it give the numbers of a map. The frame is lean, as if made by hand: locked drives
are no elements, crossing hinges are one `zeroLength` with springs where it blocks, a piece has one node where it has
one point; beams are `ElasticTimoshenkoBeam` with `beamUniform`. The matrix (`ProfileSPD`) is factorised once, for all
loads together, six unit loads, and the weight of each limb but one; the rest follows by superposition.
- **C**: the lean frame and one analysis, under all loads together. The answer is the twist and all forces; it has no
compliance and no contributions, and is less than a map.

What was wanted is meant for a model like A, which takes about 2 ms for the robots of the paper: a map is {plain} times
faster. A lean model that is factorised once asks more of whoever writes it and is much faster itself: beside B a map is
{all_cases} times faster, beside C {one} times, loops closed and contributions included.

**difference** is that of the twists of C and ours, relative: what the springs of its joints give way, and rounding."""


def pinocchio(page: Page, effort: Effort) -> None:
    """The 3RPS beside Pinocchio's dynamics."""
    found = yardsticks.compare_with_pinocchio("3rps", effort.poses, 2 * effort.repeats)
    ratio = found.ours / found.rnea
    page.require("`3rps`: times the cost of Pinocchio's `rneaInParallel`", "≤ 5", times(ratio), ratio <= 5)
    rows = [
        ("`rneaInParallel`, C++, one thread", micro(found.rnea), "1"),
        ("map, its statics and arrays alone", micro(found.statics), times(found.statics / found.rnea)),
        ("map, loops closed", micro(found.ours), times(ratio)),
        ("`ks.sweep`", micro(found.sweep), times(found.sweep / found.rnea)),
    ]
    text = f"""\
{found.poses:,} poses of the 3RPS. Pinocchio computes the inverse dynamics of the model, a tree of {found.joints}
joints with the loops cut, at the coordinates of the same poses in random order, with velocities and accelerations
zero. What it finds are the forces of drives that hold a tree without loops and elasticity: no alternative, but what a
compiled program needs for one pass over the bodies."""
    page.add("Beside Pinocchio", text, table(("", "µs per pose", "times"), rows))


def sizes(page: Page, effort: Effort) -> None:
    """From few poses to many."""
    found = []
    for poses, repeats in effort.sizes:
        found.append(scaling.measure_size("3rps", poses, repeats))
        report(f"3rps, {found[-1].poses:,} poses: {micro(found[-1].cpu)} µs dropped, {micro(found[-1].stored_cpu)} µs stored")
    span = f"from {found[0].poses:,} to {found[-1].poses:,} poses"
    values = [item.cpu for item in found]
    spread = max(values) / min(values)
    said = f"{micro(min(values))} … {micro(max(values))} µs, {spread:.2f} times"
    page.require(f"cost per pose of a batch {span}", "the same (≤ 1.2 times)", said, spread <= 1.2)
    peak = found[-1].memory / scaling.GIB
    page.require(f"memory of a map of {found[-1].poses:,} poses, stored", "< 2 GiB", f"{peak:.2f} GiB", peak < 2)
    rows = [
        (
            f"{item.poses:,}",
            *map(micro, (item.cpu, item.wall, item.stored_cpu, item.stored_wall)),
            mebibytes(item.memory),
            mebibytes(item.file),
        )
        for item in found
    ]
    once = (found[0].stored_cpu - found[0].cpu) * found[0].poses
    text = f"""\
The 3RPS; each size in a process of its own with one thread. *Dropped*: the map is computed in blocks of at most
100,000 poses, whose numbers are not kept. *Stored*: `ks.sweep(…, out="map.nc", workers=1)`. Processor time and, less
to be relied on, time by the clock, both in µs per pose; memory is the most that the process had in use while it
stored, Python and libraries included. A small map has less to share: the poses that lead others are more of it, and
making and opening a file takes {once:.2f} s in any case."""
    head = ("poses", "dropped", "by the clock", "stored", "by the clock", "memory", "file")
    page.add("By the number of poses", text, table(head, rows))


def reach(page: Page, effort: Effort) -> None:
    """Poses out of reach."""
    found = {name: scaling.measure_reach(name, effort.poses, effort.repeats) for name in effort.edges}
    rows = []
    for what, before, after, part in (
        ("corners of the grid", "outside_without", "outside", "corner"),
        ("corners, beside a smaller grid", "inside", "outside", "corner"),
        ("corners, beside a smaller grid, `ks.sweep`", "inside_swept", "outside_swept", "corner"),
        ("scattered", "all_reached", "some_missing", "scattered"),
    ):
        more = {}
        for name, item in found.items():
            without, having = getattr(item, before), getattr(item, after)
            more[name] = having / without - 1
            share = f"{100 * getattr(item, part):.1f} %"
            rows.append((f"`{name}`, {what}", share, micro(without), micro(having), f"{100 * more[name]:+.0f} %"))
        said = ", ".join(f"{100 * value:+.0f} % (`{name}`)" for name, value in more.items())
        if what != "corners, beside a smaller grid":
            page.require(f"1 % of the poses out of reach, {what}", "< +10 % of time", said, max(more.values()) < 0.1)
    text = """\
Processor time in µs per pose. *Corners*: a grid whose corners are beyond the robot's reach, and the same without the
poses out of reach. *Beside a smaller grid*: that grid, and one of equally many poses that ends shortly before the
reach of the robot does. More poses of the larger one lie near the rim, where no polynomial predicts them and steps are
smaller; that they are there costs more than those that are out of reach. *Scattered*: the smaller grid in random
order, without and with 1 % of its poses far outside. `ks.sweep` has more to do: what the line from the zero pose does
not reach it tries from neighbours, and it marks what another assembly mode reaches."""
    page.add("Poses out of reach", text, table(("", "out of reach", "none", "some", "more"), rows))


def cores(page: Page, effort: Effort) -> None:
    """Threads, processes, Dask."""
    found = scaling.measure_cores("3rps", effort.cores, max(2, effort.repeats // 2))
    rows = [
        (what, micro(one / found.poses), micro(two / found.poses), f"{one / two:.2f}") for what, (one, two) in found.wall.items()
    ]
    each = found.wall[scaling.DASK][0] / found.poses
    hours, tasks = each * 1e9 / 3600, 2 * 1e9 / 20_000
    on_64, on_1000, scheduling = 60 * hours / 64, 3.6 * hours, tasks * 1e-3
    enough = 3600 * hours / scheduling
    whole = found.bytes_per_pose * 1e9 / 1e12
    text = f"""\
Time by the clock in µs per pose, {found.poses:,} poses of the 3RPS where nothing else is said. The first row is a
loop that needs nothing but a core: what it gains by the second core is what there was to be gained while this ran,
because others use the machine too. Each call of `ks.sweep` starts its processes anew, which small maps do not pay
for; without `workers=` it starts none for them."""
    paper = f"""\
**1e9 poses, on paper.** A pose has {found.bytes_per_pose:,.0f} bytes in a map, all of them {whole:.1f} TB: not to be
stored, but to be reduced to indices where they are computed, as in the last row. With its {micro(each)} µs a pose and
worker, chunks of 20,000 poses, and nothing to be exchanged between them, 1e9 poses take {hours:.1f} hours of one
core, {on_64:.0f} minutes of 64, and {on_1000:.0f} seconds of 1,000 if the rest keeps up. It would not: Dask's scheduler
needs something like a millisecond a task, which for {tasks:,.0f} tasks are {scheduling:.0f} seconds. With more than some
{enough:.0f} cores, chunks should be larger, or several sweeps be made side by side."""
    page.add("Cores", text, table(("", "1 worker", "2 workers", "gain"), rows), paper)


def single(page: Page, effort: Effort) -> None:
    """Single poses, and the command."""
    rows = []
    for name in effort.robots[:3]:
        found = scaling.measure_single(name, 2 * effort.repeats)
        numbers = (found.twist, found.numbers, found.everything)
        rows.append((f"`{name}`", *(f"{1e3 * value:.2f}" for value in numbers), f"{found.command:.2f} s"))
    text = """\
Processor time in milliseconds, loops closed: of the twist; of the numbers of a map; of these and the wrenches of all
joints, bent lines and stresses of beams. And `kinetostatics analyze ROBOT` from start to end, by the clock.
`benchmarks/speed.py` has more."""
    page.add("Single poses", text, table(("robot", "twist", "map", "everything", "command"), rows))


TOPICS: dict[str, Callable[[Page, Effort], None]] = {
    "opensees": opensees,
    "pinocchio": pinocchio,
    "sizes": sizes,
    "reach": reach,
    "cores": cores,
    "single": single,
}
