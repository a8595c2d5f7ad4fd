"""Machine code of recorded scalar operations, by LLVM; an instruction computes eight poses (lanes), or one.

Operations that depend on parameters only are executed once per call, all others in a loop over blocks of eight poses. The last
block may overlap the one before it, so that the code is valid for any number of poses n ≥ 8.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.engine.angles import Instructions, angle_of_point, constant, kind_of, sine_or_cosine, suffix
from kinetostatics.engine.scalars import Tape, needed_by, operands

if TYPE_CHECKING:
    from llvmlite.binding import TargetMachine

#: Poses per instruction; code for single poses is shorter and faster with one.
LANES = 8
#: Number of operations in a short basic block.
_BLOCK = 300
#: Name of the compiled function.
NAME = "poses"

#: ``contract`` permits one instruction for a product and a sum, with a single rounding.
_INFIX = {"add": "fadd contract", "subtract": "fsub contract", "multiply": "fmul contract", "divide": "fdiv"}
_INFIX |= {">": "fcmp ogt", ">=": "fcmp oge", "<": "fcmp olt", "<=": "fcmp ole", "==": "fcmp oeq", "!=": "fcmp une"}
_INTRINSICS = {"square_root": "sqrt", "absolute": "fabs", "whole": "nearbyint"}
_DECLARED = {**dict.fromkeys(_INTRINSICS.values(), 1), "copysign": 2, "fmuladd": 3}


def module_of(
    tape: Tape,
    numbers: Sequence[int],
    truths: Sequence[int],
    inputs: int,
    repeats: int = 0,
    stages: Sequence[int] = (),
    lanes: int = LANES,
    short_blocks: bool = False,
) -> str:
    """Return the text of an LLVM module with one function of many poses.

    ``void poses(double **inputs, int64 *strides, double *parameters, double *numbers, int8 *truths, int64 n, int64 stage)``:
    component k of input a at pose i is ``inputs[a][k * strides[a] + i]``, the k-th result ``numbers[k * n + i]``, n ≥ lanes.

    Args:
        tape: the recorded operations.
        numbers, truths: indices of the operations whose results are written to the arrays of the same names.
        inputs: number of input arrays.
        repeats: largest number of iterations of a block of poses, or 0: the block is computed again while the first truth value
            of any of its poses is true. Results may then share memory with inputs.
        stages: how many of ``numbers`` are computed by a call with ``stage`` 0, 1, …; a call with a larger ``stage`` computes
            all. Truth values are always computed.
        lanes: poses per instruction.
        short_blocks: whether to divide the code into short basic blocks, which compile quickly.
    """
    block = _BLOCK if short_blocks else len(tape.operations) + 1
    writer = _Writer(tape, lanes)
    needed = needed_by(tape, (*numbers, *truths))
    before = [needed_by(tape, (*numbers[:end], *truths)) for end in stages]
    rows: dict[int, list[tuple[str, int]]] = {}
    for kind, outputs in (("number", numbers), ("truth", truths)):
        for row, number in enumerate(outputs):
            rows.setdefault(number, []).append((kind, row))
    once: list[str] = []  # before the loop over the poses
    parts: list[list[str]] = [[] for _ in range(len(stages) + 1)]  # in the loop, by stage
    for number in np.flatnonzero(needed).tolist():
        part = parts[sum(not those[number] for those in before)]
        if number % block == block - 1:
            part += [f"br label %block{number}", f"block{number}:"]
        if writer.varies[number]:
            part += writer.instruction(number, lanes)
        else:
            once += writer.instruction(number, 0)
            part += writer.spread(number)
        for kind, row in rows.get(number, ()):
            stage = sum(row >= end for end in stages) if kind == "number" else 0
            parts[stage] += writer.stored(number, kind, row)
    loop, *later = parts
    pointers = [
        line
        for a in range(inputs)
        for line in (
            f"%slot{a} = getelementptr ptr, ptr %inputs, i64 {a}",
            f"%input{a} = load ptr, ptr %slot{a}",
            f"%place{a} = getelementptr i64, ptr %strides, i64 {a}",
            f"%stride{a} = load i64, ptr %place{a}",
        )
    ]
    head = ["%first = phi i64 [ 0, %entry ], [ %next, %done ]", "%over = icmp sgt i64 %first, %last"]
    head += ["%i = select i1 %over, i64 %last, i64 %first", f"%next = add i64 %first, {lanes}"]
    if repeats:
        head += ["br label %again", "again:", "%times = phi i64 [ 0, %loop ], [ %counted, %again ]"]
        loop += [
            "%counted = add i64 %times, 1",
            f"%few = icmp slt i64 %counted, {repeats}",
            f"%lanes = bitcast <{lanes} x i1> {writer.operand(truths[0], lanes)} to i{lanes}",
            f"%any = icmp ne i{lanes} %lanes, 0",
            "%goes = and i1 %few, %any",
            "br i1 %goes, label %again, label %done",
        ]
    for k, part in enumerate(later):
        once.append(f"%goes{k} = icmp sgt i64 %stage, {k}")
        loop += [f"br i1 %goes{k}, label %stage{k}, label %done", f"stage{k}:", *part]
    if not repeats:
        loop.append("br label %done")
    tail = ["done:", "%more = icmp slt i64 %next, %n", "br i1 %more, label %loop, label %end"]
    declared = [
        f"declare {kind} @llvm.{name}.{suffix(width)}({', '.join([kind] * count)})"
        for name, count in _DECLARED.items()
        for width, kind in ((0, "double"), (lanes, kind_of("double", lanes)))
    ]
    alone = "" if repeats else " noalias"
    signature = ", ".join(f"ptr{alone} %{name}" for name in ("inputs", "strides", "parameters", "numbers", "truths"))
    return "\n".join(
        [
            *declared,
            f"define void @{NAME}({signature}, i64 %n, i64 %stage) #0 {{",
            "entry:",
            *pointers,
            f"%last = sub i64 %n, {lanes}",
            *once,
            "br label %loop",
            "loop:",
            *head,
            *loop,
            *tail,
            "end:",
            "ret void",
            "}",
            'attributes #0 = { nounwind "prefer-vector-width"="512" "min-legal-vector-width"="512" }',
        ]
    )


class _Writer:
    """LLVM instructions of recorded operations, which are named by their indices.

    Attributes:
        varies: True for each operation whose result depends on the pose.
    """

    def __init__(self, tape: Tape, lanes: int) -> None:
        self._tape, self._lanes = tape, lanes
        self.varies: list[bool] = []
        for operation in tape.operations:
            self.varies.append(operation[0] == "input" or any(self.varies[k] for k in operands(operation)))

    def instruction(self, number: int, lanes: int) -> list[str]:
        """Return the instructions of an operation, for blocks of ``lanes`` poses, 8 or 1; 0: the operation depends on no pose."""
        name, *taken = self._tape.operations[number]
        result, real, truth = f"%{'v' if lanes else 's'}{number}", kind_of("double", lanes), kind_of("i1", lanes)
        if name == "input":
            array, component = taken
            return [
                f"%o{number} = mul i64 %stride{array}, {component}",
                f"%p{number} = add i64 %o{number}, %i",
                f"%a{number} = getelementptr double, ptr %input{array}, i64 %p{number}",
                f"{result} = load {real}, ptr %a{number}, align 8",
            ]
        if name == "parameter":
            return [
                f"%a{number} = getelementptr double, ptr %parameters, i64 {taken[0]}",
                f"{result} = load double, ptr %a{number}, align 8",
            ]
        if name in ("constant", "truth"):
            return []
        a = [self.operand(k, lanes) for k in taken]
        if name in _INFIX:
            return [f"{result} = {_INFIX[name]} {real} {a[0]}, {a[1]}"]
        if name in ("and", "or"):
            return [f"{result} = {name} {truth} {a[0]}, {a[1]}"]
        if name == "not":
            return [f"{result} = xor {truth} {a[0]}, {constant(True, lanes)}"]
        if name == "negative":
            return [f"{result} = fneg {real} {a[0]}"]
        if name == "choose":
            return [f"{result} = select {truth} {a[0]}, {real} {a[1]}, {real} {a[2]}"]
        lines = Instructions(result, lanes)
        if name == "angle":
            angle_of_point(lines, a[0], a[1])
        elif name in ("sine", "cosine"):
            sine_or_cosine(lines, a[0], name == "cosine")
        else:
            lines.call(_INTRINSICS[name], a[0], last=True)
        return lines.lines

    def operand(self, number: int, lanes: int) -> str:
        """Return the text by which instructions refer to an operation's result: its name or a constant."""
        name, *taken = self._tape.operations[number]
        if name == "constant":
            return constant(float.fromhex(taken[0]), lanes)
        if name == "truth":
            return constant(taken[0], lanes)
        return f"%{'v' if lanes else 's'}{number}"

    def spread(self, number: int) -> list[str]:
        """Return the instructions that copy a result that is independent of the pose into all lanes."""
        if self._tape.operations[number][0] in ("constant", "truth"):
            return []
        kind = "i1" if isinstance(self._tape.values[number], bool) else "double"
        lanes = kind_of(kind, self._lanes)
        return [
            f"%w{number} = insertelement {lanes} poison, {kind} %s{number}, i64 0",
            f"%v{number} = shufflevector {lanes} %w{number}, {lanes} poison, <{self._lanes} x i32> zeroinitializer",
        ]

    def stored(self, number: int, kind: str, row: int) -> list[str]:
        """Return the instructions that store a result of kind "number" or "truth" in row ``row`` of the result array."""
        name, value = f"{kind[0]}{row}", self.operand(number, self._lanes)
        unit, size = ("double", 8) if kind == "number" else ("i8", 1)
        lines = []
        if kind == "truth":
            lines.append(f"%z{name} = zext <{self._lanes} x i1> {value} to <{self._lanes} x i8>")
            value = f"%z{name}"
        return [
            *lines,
            f"%m{name} = mul i64 %n, {row}",
            f"%q{name} = add i64 %m{name}, %i",
            f"%e{name} = getelementptr {unit}, ptr %{kind}s, i64 %q{name}",
            f"store <{self._lanes} x {unit}> {value}, ptr %e{name}, align {size}",
        ]


class MachineCode:
    """Object code loaded for calls.

    Attributes:
        address: address of the function.
    """

    def __init__(self, code: bytes) -> None:
        binding = _binding()
        self._engine = binding.create_mcjit_compiler(binding.parse_assembly(""), _machine())
        self._engine.add_object_file(binding.ObjectFileRef.from_data(code))
        self._engine.finalize_object()
        self.address = int(self._engine.get_function_address(NAME))


def compiled(text: str, level: int = 1) -> bytes:
    """Return the object code of a module for this processor, without optimization passes: the operations are already simplified.

    Args:
        text: see :func:`module_of`.
        level: optimization level of code generation. Level 0 takes a tenth of the time of level 1 to compile; its code takes
            almost twice as long to run.
    """
    module = _binding().parse_assembly(text)  # must exist until the code is emitted
    return bytes(_machine(level).emit_object(module))


def processor() -> str:
    """Return the versions of LLVM and llvmlite, the platform and the processor with its features: object code depends on them."""
    binding = _binding()
    features = binding.get_host_cpu_features().flatten()
    import llvmlite

    host = f"{binding.get_process_triple()} {binding.get_host_cpu_name()} {features}"
    return f"{llvmlite.__version__} {binding.llvm_version_info} {host}"


def _machine(level: int = 1) -> TargetMachine:
    binding = _binding()
    target = binding.Target.from_triple(binding.get_process_triple())
    return target.create_target_machine(
        cpu=binding.get_host_cpu_name(), features=binding.get_host_cpu_features().flatten(), opt=level, jit=True
    )


@cache
def _binding() -> ModuleType:
    import llvmlite.binding as binding

    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    return binding
