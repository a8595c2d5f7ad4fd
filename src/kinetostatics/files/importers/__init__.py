"""Loops that other tools have already written down, and their conversion to this package's format.

Three sources are read: the ``closing_…_1``/``closing_…_2`` frames of onshape-to-robot (:mod:`.onshape`), the ``robot.yaml``
of Gepetto's example-parallel-robots (:mod:`.gepetto`), and Isaac Sim's ``<loop_joint>`` (:mod:`.isaac`). Each reader
returns records of one kind, :class:`ForeignLoop`; whatever a source leaves open is asked for, never guessed.
The page on other tools' loops describes the three formats and cites where they are defined.
"""

from kinetostatics.files.importers.answers import MissingFactsError, Question
from kinetostatics.files.importers.convert import convert, import_robot
from kinetostatics.files.importers.loop_record import ForeignLoop

__all__ = ["ForeignLoop", "MissingFactsError", "Question", "convert", "import_robot"]
