"""What of one quantity has to be paid for less of another; :func:`kinetostatics.pareto` finds it."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from kinetostatics.files.writer import write_text
from kinetostatics.layout.report import Reported
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.results.optimum import Optimum


@dataclass(frozen=True, eq=False, repr=False)
class ParetoFront(Reported, builder="reports.optimum:pareto_report"):
    """Designs of which none is better than another in both of two quantities.

    Attributes:
        points: optima, from the least of the first quantity to the least of the second. Each is one of the first quantity, with a
            limit of the second as its last requirement.
        objectives: (n, 2) both quantities of each, SI.
        minimized: names of both.
        units: of both.
        searched: how it was searched, in a sentence.
        evaluations: robots that were analysed.
    """

    points: tuple[Optimum, ...]
    objectives: Array
    minimized: tuple[str, str]
    units: tuple[str, str]
    searched: str
    evaluations: int

    @property
    def parameters(self) -> dict[str, Array]:
        """The parameters of all points (n,), by name, SI."""
        names = self.points[0].parameters if self.points else ()
        return {name: frozen(np.array([item.parameters[name] for item in self.points])) for name in names}

    def __getitem__(self, number: int) -> Optimum:
        return self.points[number]

    def __iter__(self) -> Iterator[Optimum]:
        return iter(self.points)

    def __len__(self) -> int:
        return len(self.points)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a CSV file: both quantities and all parameters of each point, with units in the titles; one there is replaced.

        Raises:
            ArgumentError: the file cannot be written.
        """
        names = self.parameters
        units = self.points[0].units if self.points else {}
        titles = [*zip(self.minimized, self.units, strict=True), *((name, units.get(name, "")) for name in names)]
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow([f"{name} [{unit}]" if unit else name for name, unit in titles])
        for k, row in enumerate(self.objectives.tolist()):
            writer.writerow([repr(value) for value in (*row, *(float(values[k]) for values in names.values()))])
        write_text(path, text.getvalue())
