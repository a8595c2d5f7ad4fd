"""Whether all reports say the same, to the letter, on other processors: ``python tests/support/same_everywhere.py``.

The linear algebra library has kernels for many processors, which round differently, and so does NumPy with and without
processors' wide registers. Here the reports of all robots in ``robots/`` and of the odd ones of ``odd_robots.py`` and the
answers on the guide's pages are printed by a process for each kernel, and for one of them with two
threads, and compared. ``--print`` prints them in this process.
"""

import argparse
import difflib
import os
import signal
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from itertools import chain
from pathlib import Path

NARROW = "AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL AVX512_ICL AVX512_SPR X86_V4"
OLD = f"{NARROW} AVX F16C FMA3 AVX2 X86_V3"
#: Kernels by the names that OpenBLAS knows them by, what the processor must have, and which features NumPy does without.
KERNELS = {"Haswell": ("avx2", NARROW), "SkylakeX": ("avx512f", ""), "Nehalem": ("sse4_2", OLD), "Prescott": ("pni", OLD)}


# ---- what is printed -----------------------------------------------------------------------------------------------------


def _said(compute):
    import kinetostatics as ks

    try:
        return str(compute())
    except ks.KinetostaticsError as error:
        return f"{type(error).__name__}: {error}"


def texts_of(robot):
    """Yield what is said of a robot."""
    import kinetostatics as ks

    yield str(robot)
    try:
        poses = {"zero pose": robot.zero_poses, "generic pose": robot.generic_poses}
    except ks.KinetostaticsError as error:
        yield f"{type(error).__name__}: {error}"
        return
    for name, some in poses.items():
        q = robot.model_q(some)[:, 0]
        tolerance = 1e-9 + 1e3 * robot.closing_error

        try:
            pose = robot.configuration(q, closure_tolerance=tolerance)
            found = ks.analyze(pose, load=[10, -20, -30, 1, 2, 3], on_failure="nan")
        except ks.KinetostaticsError as error:
            yield f"---- {name}\n{type(error).__name__}: {error}"
            return
        labels = (f"{limb}: {', '.join(item.labels)}" for limb, item in found.limbs.items())
        yield "\n".join([f"---- {name}", str(pose), ks.Status(int(found.status)).name, *labels, str(found.report())])
        if found.status != ks.Status.OK:
            yield _said(lambda pose=pose: ks.analyze(pose).status)
        yield f"---- vibration\n{_said(lambda pose=pose: ks.modes(pose, 4))}"
        yield f"---- buckling\n{_said(lambda found=found: found.buckling(2))}"
        if name == "zero pose":
            yield f"---- tolerances\n{_said(lambda pose=pose: ks.tolerances(pose))}"


def texts():
    """Yield name and text of all robots."""
    from check_texts import NAMES, ROOT, robot

    for name in NAMES:
        yield name, "\n".join(texts_of(robot(name))).replace(f"{ROOT}/", "")


def pages():
    """Yield name and text of the guide's answers."""
    import guide_pages

    def run(command):  # a page for the viewer costs as much as all the rest, and what the verification shows is rounding
        return "" if command.split()[2] in ("view", "verify") else guide_pages.run(command)

    with tempfile.TemporaryDirectory() as folder:
        for page, blocks in zip(
            guide_pages.GUIDE.pages, guide_pages.answers(guide_pages.GUIDE, Path(folder), run)[0], strict=True
        ):
            yield page.stem, "\n".join(answer for _, answer in blocks)


def _print():
    import numpy  # noqa: F401  (which loads the library)
    from threadpoolctl import threadpool_info

    print(f"kernel {' '.join(sorted({str(info.get('architecture')) for info in threadpool_info()}))}", file=sys.stderr)
    for name, text in chain(texts(), pages()):
        print(f"======== {name}\n{text}")


# ---- who prints it -------------------------------------------------------------------------------------------------------


def _run(kernel, threads):
    environment = {
        **os.environ,
        "OPENBLAS_CORETYPE": kernel,
        "OPENBLAS_NUM_THREADS": str(threads),
        "NPY_DISABLE_CPU_FEATURES": KERNELS[kernel][1],
        "PYTHONIOENCODING": "utf-8",
    }
    command = [sys.executable, __file__, "--print"]
    # NumPy 2.5.5's OpenBLAS 0.3.34 at times jumps to address 0 in solve(), where Haswell's kernel runs on a newer processor
    for _ in range(8):
        done = subprocess.run(command, env=environment, capture_output=True, encoding="utf-8", check=False)
        if done.returncode != -signal.SIGSEGV:
            break
    if done.returncode == -signal.SIGSEGV:
        return None
    if done.returncode:
        sys.exit(f"{kernel}, {threads} threads, exit status {done.returncode}: {done.stderr}")
    return done.stdout.splitlines(), next(
        line for line in done.stderr.splitlines() if line.startswith("kernel ")
    )  # beside warnings


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition(":")[0])
    parser.add_argument("--print", action="store_true", help="print the reports in this process")
    if parser.parse_args().print:
        return _print()
    flags = Path("/proc/cpuinfo").read_text(encoding="utf-8").split()
    usable = [kernel for kernel, (flag, _) in KERNELS.items() if flag in flags]
    print(f"kernels that this processor cannot run: {', '.join(sorted({*KERNELS} - {*usable})) or 'none'}")
    runs = [*((kernel, 1) for kernel in usable), (usable[0], 2)]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        found = list(pool.map(lambda run: _run(*run), runs))
    for (kernel, threads), answer in zip(runs, found, strict=True):
        if answer is None:
            print(f"{kernel}, {threads} threads: the library crashes on this processor")
    runs = [run for run, answer in zip(runs, found, strict=True) if answer is not None]
    found = [answer for answer in found if answer is not None]
    first, different = found[0][0], False
    for (kernel, threads), (lines, ran) in zip(runs, found, strict=True):
        changes = list(difflib.unified_diff(first, lines, "the first", f"{kernel}, {threads} threads", n=2, lineterm=""))
        print(f"{kernel}, {threads} threads ({ran}): {len(lines)} lines, {'DIFFERENT' if changes else 'the same'}")
        print(*changes, sep="\n", end="\n" if changes else "")
        different |= bool(changes)
    seen = {ran for _, ran in found}
    if len(seen) < min(2, len(usable)):
        sys.exit(f"only one kernel ran: {seen}")
    sys.exit(int(different))


if __name__ == "__main__":
    main()
