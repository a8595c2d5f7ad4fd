"""Functional mock-up units (FMI 3.0 or 2.0, co-simulation, sources): the exported C of a function in a simulation program.

An FMU is a zip archive with a model description (XML), C sources, and a CMakeLists.txt that compiles them to the binary of a
platform. Outputs follow from the inputs at the same time; the pose moves along the straight line from the last one.
"""

from __future__ import annotations

import hashlib
import os
import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np

from kinetostatics.arguments import path_name
from kinetostatics.engine.c_code import literal
from kinetostatics.exceptions import ArgumentError
from kinetostatics.functions.c_export import recorded
from kinetostatics.functions.c_names import identifier
from kinetostatics.functions.c_programs import Exported, Programs
from kinetostatics.functions.c_source import source
from kinetostatics.functions.c_texts import filled, header
from kinetostatics.functions.inputs_outputs import Values
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.math.screws import WRENCH_COMPONENTS, WRENCH_UNITS
from kinetostatics.output_files import replacing

#: Gravity at the start of a simulation [m/s²].
_GRAVITY = (0.0, 0.0, -9.81)
#: Words in the C source and CMake file by version of the standard: names of functions, types, and platforms.
_WORDS = {
    2: ("2", "int", "FMUstate", "DeSerializeFMUstate", "darwin64", "win64", "linux64"),
    3: (
        "3",
        "bool",
        "FMUState",
        "DeserializeFMUState",
        "aarch64-darwin",
        "x86_64-windows",
        "${CMAKE_SYSTEM_PROCESSOR}-${system}",
    ),
}
#: Folder of the C source and CMake file that are completed for a robot.
_TEMPLATES = Path(__file__).parent


@dataclass(frozen=True)
class _Variable:
    name: str
    unit: str
    description: str
    start: float | None = None


def export_fmu(
    function: Exported,
    path: str | os.PathLike[str],
    name: str | None = None,
    near: Configuration | Values | None = None,
    fmi: int = 3,
) -> None:
    """Write a function of a robot as a functional mock-up unit, see :meth:`Function.export_fmu`."""
    file = path_name("path", path)
    if not file.endswith(".fmu"):
        raise ArgumentError(f"{file!r} does not end in .fmu")
    if fmi not in _WORDS:
        raise ArgumentError(f"fmi is {fmi!r}; it must be 2 or 3")
    prefix = identifier(function.robot.name if name is None else name)
    _, parts = recorded(function, near)
    texts = {f"{prefix}.h": header(prefix, "double", parts), f"{prefix}.c": source(prefix, "double", parts)}
    inputs, outputs = [*_inputs(parts)], [*_outputs(parts)]
    token = hashlib.sha256("".join(texts.values()).encode()).hexdigest()
    starts = ", ".join(literal(float(variable.start or 0.0)) for variable in inputs)
    words = {"ROBOT": prefix, "INPUTS": str(len(inputs)), "OUTPUTS": str(len(outputs)), "TOKEN": token, "VALUES_AT_START": starts}
    words |= zip(("MAJOR", "BOOLEAN", "STATE", "DESERIALIZE", "DARWIN", "WINDOWS", "LINUX"), _WORDS[fmi], strict=True)
    texts["fmi.c"] = filled((_TEMPLATES / "fmu.c", _TEMPLATES / f"fmi{fmi}.c"), words)
    texts["CMakeLists.txt"] = filled([_TEMPLATES / "fmi.cmake"], words)
    sources = sorted(text_name for text_name in texts if text_name.endswith(".c"))
    description = _model_description(function, prefix, token, inputs, outputs)
    if fmi == 2:
        _as_fmi_2(description, sources)
    else:
        texts["buildDescription.xml"] = _text(_build_description(prefix, sources))
    with replacing(file) as partial, zipfile.ZipFile(partial, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", _text(description))
        for text_name, text in texts.items():
            archive.writestr(f"sources/{text_name}", text)


def _text(root: ET.Element) -> str:
    ET.indent(root)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ET.tostring(root, encoding="unicode")


def _inputs(parts: Programs) -> Iterator[_Variable]:
    """Yield the inputs in the order of the C structure."""
    for quantity in parts.coordinates:
        yield _Variable(parts.c_names[quantity.name], quantity.units[0], quantity.meaning, parts.at_start[quantity.name])
    for component, unit in zip(WRENCH_COMPONENTS, WRENCH_UNITS, strict=True):
        yield _Variable(f"load.{component.lower()}", unit, "load on the platform about o, world axes", 0.0)
    for axis, value in zip("xyz", _GRAVITY, strict=True):
        yield _Variable(f"gravity.{axis}", "m/s²", "gravity, world axes", value)


def _outputs(parts: Programs) -> Iterator[_Variable]:
    """Yield the outputs in the order of the C structure."""
    for quantity in parts.outputs:
        labels = [*quantity.axes.values()][-len(quantity.shape) :] if quantity.shape else []
        for index in np.ndindex(quantity.shape):
            place = ".".join(identifier(labels[axis][k]) for axis, k in enumerate(index))
            unit = quantity.units[index[-1] if len(quantity.units) > 1 and index else 0]
            yield _Variable(f"{quantity.name}.{place}" if place else quantity.name, unit, quantity.meaning)
    if parts.efforts:
        yield _Variable("effort_exceeded", "1", "1 if an actuator's force is beyond the effort in the file, else 0")
    yield _Variable("residual", "1", "largest residual of the equations of the loops [m or rad]")


def _model_description(
    function: Exported, prefix: str, token: str, inputs: Sequence[_Variable], outputs: Sequence[_Variable]
) -> ET.Element:
    """Return the description of a unit of FMI 3.0."""
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="3.0",
        modelName=function.robot.name,
        instantiationToken=token,
        generationTool="kinetostatics",
        description="sag and actuator forces of a robot from coordinates, load and gravity",
    )
    capabilities = ("canGetAndSetFMUState", "canSerializeFMUState", "canHandleVariableCommunicationStepSize")
    ET.SubElement(root, "CoSimulation", {"modelIdentifier": prefix, **dict.fromkeys(capabilities, "true")})
    units = ET.SubElement(root, "UnitDefinitions")
    for unit in dict.fromkeys(variable.unit for variable in (*inputs, *outputs)):
        ET.SubElement(units, "Unit", name=unit)
    variables, structure = ET.SubElement(root, "ModelVariables"), ET.Element("ModelStructure")
    ET.SubElement(variables, "Float64", name="time", valueReference="0", causality="independent", variability="continuous")
    for reference, variable in enumerate((*inputs, *outputs), 1):
        start = {} if variable.start is None else {"start": repr(variable.start)}
        causality = "input" if reference <= len(inputs) else "output"
        about = {"unit": variable.unit, "description": variable.description, "causality": causality, **start}
        ET.SubElement(variables, "Float64", {"name": variable.name, "valueReference": str(reference), **about})
        if causality == "output":
            ET.SubElement(structure, "Output", valueReference=str(reference))
    last = {"valueReference": str(len(inputs) + len(outputs) + 1)}
    words = f"status of the pose, see {prefix}.h: 0 if all numbers are valid"
    about = {"name": "status", "causality": "output", "variability": "discrete", "description": words}
    ET.SubElement(variables, "Int32", {**about, **last})
    ET.SubElement(structure, "Output", last)
    for output in [*structure]:
        ET.SubElement(structure, "InitialUnknown", output.attrib)
    root.append(structure)
    return root


def _as_fmi_2(root: ET.Element, sources: Sequence[str]) -> None:
    """Change a model description from FMI 3.0 to FMI 2.0, which also names the sources."""
    root.attrib |= {"fmiVersion": "2.0", "guid": root.attrib.pop("instantiationToken")}
    simulation, _, variables, structure = root
    simulation.attrib = {name.replace("FMUState", "FMUstate"): value for name, value in simulation.attrib.items()}
    ET.SubElement(simulation, "SourceFiles").extend(ET.Element("File", name=name) for name in sources)
    for variable in variables:
        numbers: dict[str, str] = {name: variable.attrib.pop(name) for name in ("unit", "start") if name in variable.attrib}
        ET.SubElement(variable, {"Float64": "Real", "Int32": "Integer"}[variable.tag], numbers)
        variable.tag = "ScalarVariable"
    for tag in ("Output", "InitialUnknown"):
        group = ET.SubElement(structure, f"{tag}s")
        for unknown in structure.findall(tag):
            structure.remove(unknown)
            ET.SubElement(group, "Unknown", index=str(int(unknown.attrib["valueReference"]) + 1))


def _build_description(prefix: str, sources: Sequence[str]) -> ET.Element:
    root = ET.Element("fmiBuildDescription", fmiVersion="3.0")
    files = ET.SubElement(ET.SubElement(root, "BuildConfiguration", modelIdentifier=prefix), "SourceFileSet", language="C99")
    files.extend(ET.Element("SourceFile", name=name) for name in sources)
    return root
