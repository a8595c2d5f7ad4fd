"""How many operations the exported C does, counted on the records from which it is written."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from kinetostatics.engine.c_code import CProgram
from kinetostatics.functions.values import Facts

#: Columns of the table, and the operations of a record that count there; what is in none is a comparison or a choice.
_KINDS = {
    "additions": ("add", "subtract"),
    "multiplications": ("multiply",),
    "divisions": ("divide",),
    "square roots": ("square_root",),
    "sines, cosines": ("sine", "cosine"),
    "arc tangents": ("angle",),
    "signs, roundings": ("negative", "absolute", "whole"),
}
_REST = "comparisons, choices"


def counted(counts: Mapping[str, int]) -> dict[str, int]:
    """Return how many operations of each column there are."""
    found = {title: sum(counts.get(kind, 0) for kind in kinds) for title, kinds in _KINDS.items()}
    return found | {_REST: sum(counts.values()) - sum(found.values())}


def table(facts: Facts) -> str:
    """Return a table of what is done, how often, and of how many operations it consists."""
    titles = [*_KINDS, _REST]
    rows = [f"| what | how often | {' | '.join(titles)} |", f"|---|---|{'---:|' * len(titles)}"]
    for what, often, program in _done(facts):
        numbers = counted(program.counts)
        rows.append(f"| {what} | {often} | {' | '.join(f'{numbers[title]:,}' for title in titles)} |")
    return "\n".join(rows)


def _done(facts: Facts) -> Iterator[tuple[str, str, CProgram]]:
    """Yield what is done, how often in a call, and its program."""
    parts = facts["parts"]
    search, jacobian = parts.search, parts.jacobian
    line = "step of the line"
    if parts.line.start is not None:
        yield "start of a line", "a line, if angles may be others", parts.line.start
    yield "correction of the loops", f"{line}: 1 to {facts['corrections']}", parts.line.newton
    if parts.line.side is not None:
        yield "is there a singular pose between", line, parts.line.side
    if parts.drives is not None:
        line = "step of the actuators' line"
        yield "correction of the loops, actuators given", f"{line}: 1 to {facts['corrections']}", parts.drives.newton
        if parts.drives.side is not None:
            yield "is there a singular pose between", line, parts.drives.side
    analysed = "1" if search is None else "2, and each step of the search"
    yield "frames", analysed, parts.frames
    yield "statics", analysed, parts.statics
    yield "actuators", "1" if search is None else "2", parts.actuators
    if search is not None:
        yield "where the platform stands", "2, and each step of the search", search.platform
        yield "start of the search", "1", search.begin
        yield "step of the search", f"1 to {facts['searches'] + 1}", search.learn
        yield "what remains", "1", search.remains
        yield "turns of the actuators", "1", search.correct
        yield "limits", "1", search.limits
    if jacobian is not None:
        columns = {value.name: value for _, value, _ in jacobian.pairs}
        inputs = sum(int(value.shape[0]) if value.shape else 1 for value in columns.values())
        moving = sum(not value.shape for value in columns.values())
        yield "derivatives: freedoms", "1", jacobian.rates
        if moving:
            yield "derivatives: frames, actuators", str(moving), jacobian.motion
        yield "derivatives: results", str(inputs), jacobian.tangent
