"""Machine code of a record by LLVM's intermediate representation, for eight poses per instruction, or one.

Operations on parameters alone are executed once per call, all others in a loop over blocks of eight poses. The last block may
overlap the one before it, so that one code serves any number of poses n ≥ 8.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from functools import cache
from types import ModuleType
from typing import TYPE_CHECKING

from kinetostatics.engine.angles import Instructions, angle_of_point, sine_or_cosine
from kinetostatics.engine.scalars import Operation, Tape

if TYPE_CHECKING:
    from llvmlite.binding import TargetMachine

#: Poses per instruction; code for single poses is shorter and faster with one.
LANES = 8
#: Number of operations in a basic block where blocks are kept short.
_BLOCK = 300
#: Name of the compiled function.
NAME = "poses"

#: ``contract`` allows a product and a sum to be fused into one instruction, with one rounding.
_INFIX = {"add": "fadd contract", "subtract": "fsub contract", "multiply": "fmul contract", "divide": "fdiv"}
_INFIX |= {">": "fcmp ogt", ">=": "fcmp oge", "<": "fcmp olt", "<=": "fcmp ole", "==": "fcmp oeq", "!=": "fcmp une"}
_INTRINSICS = {"square_root": "sqrt", "absolute": "fabs", "whole": "nearbyint"}
_DECLARED = {**dict.fromkeys(_INTRINSICS.values(), 1), "copysign": 2, "fmuladd": 3}


def needed_by(tape: Tape, outputs: Iterable[int]) -> list[bool]:
    """Return for each operation whether it is an output, or an output depends on it."""
    needed = [False] * len(tape.operations)
    for number in outputs:
        needed[number] = True
    for number in range(len(needed) - 1, -1, -1):
        if needed[number]:
            for operand in operands(tape.operations[number]):
                needed[operand] = True
    return needed


def operands(operation: Operation) -> tuple[int, ...]:
    """Return the operands of an operation, as numbers of operations."""
    return () if operation[0] in ("input", "parameter", "constant", "truth") else operation[1:]


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
        tape: the record.
        numbers, truths: the operations of the outputs, in order.
        inputs: number of input arrays.
        repeats: 0, or the largest number of iterations: a block of poses is computed again while the first truth value is true
            for one of its poses. Results may then share memory with inputs.
        stages: for each stage 0, 1, …, the quantity of numbers computed in it; truth values are computed in all stages, and all
            numbers in a stage beyond the last.
        lanes: poses per instruction.
        short_blocks: whether to divide the code into short basic blocks, which compile quickly.
    """
    block = _BLOCK if short_blocks else len(tape.operations) + 1
    return _Writer(tape, numbers, truths, inputs, repeats, stages, lanes, block).text()


class _Writer:
    def __init__(
        self,
        tape: Tape,
        numbers: Sequence[int],
        truths: Sequence[int],
        inputs: int,
        repeats: int,
        stages: Sequence[int],
        lanes: int,
        block: int,
    ) -> None:
        self._tape, self._inputs, self._repeats, self._lanes, self._block = tape, inputs, repeats, lanes, block
        self._going = truths[0] if truths else 0
        self._needed = needed_by(tape, (*numbers, *truths))
        self._ends = stages
        needed = [needed_by(tape, (*numbers[:end], *truths)) for end in stages]
        self._stages = [sum(not those[number] for those in needed) for number in range(len(tape.operations))]
        self._rows: dict[int, list[tuple[str, int]]] = {}
        for kind, outputs in (("number", numbers), ("truth", truths)):
            for row, number in enumerate(outputs):
                self._rows.setdefault(number, []).append((kind, row))
        self._varies: list[bool] = []
        for operation in tape.operations:
            self._varies.append(operation[0] == "input" or any(self._varies[k] for k in operands(operation)))
        self._is_truth = [isinstance(value, bool) for value in tape.values]

    def text(self) -> str:
        once: list[str] = []
        parts: list[list[str]] = [[] for _ in range(len(self._ends) + 1)]
        for number, operation in enumerate(self._tape.operations):
            if not self._needed[number]:
                continue
            part = parts[self._stages[number]]
            if number % self._block == self._block - 1:
                part += [f"br label %block{number}", f"block{number}:"]
            if self._varies[number]:
                part += self._instruction(number, operation, f"<{self._lanes} x double>", f"<{self._lanes} x i1>", "v")
            else:
                once += self._instruction(number, operation, "double", "i1", "s")
                part += self._spread(number)
            for kind, row in self._rows.get(number, ()):
                stage = sum(row >= end for end in self._ends) if kind == "number" else 0
                parts[stage] += self._stored(number, kind, row)
        loop, *later = parts
        pointers = [
            line
            for a in range(self._inputs)
            for line in (
                f"%slot{a} = getelementptr ptr, ptr %inputs, i64 {a}",
                f"%input{a} = load ptr, ptr %slot{a}",
                f"%place{a} = getelementptr i64, ptr %strides, i64 {a}",
                f"%stride{a} = load i64, ptr %place{a}",
            )
        ]
        loop += ["br label %done", "done:"] if not (self._repeats or later) else []
        head = ["%first = phi i64 [ 0, %entry ], [ %next, %done ]", "%over = icmp sgt i64 %first, %last"]
        head += ["%i = select i1 %over, i64 %last, i64 %first", f"%next = add i64 %first, {self._lanes}"]
        if self._repeats:
            head += ["br label %again", "again:", "%times = phi i64 [ 0, %loop ], [ %counted, %again ]"]
            loop += [
                "%counted = add i64 %times, 1",
                f"%few = icmp slt i64 %counted, {self._repeats}",
                f"%lanes = bitcast <{self._lanes} x i1> {self._operand(self._going, 'v')} to i{self._lanes}",
                f"%any = icmp ne i{self._lanes} %lanes, 0",
                "%goes = and i1 %few, %any",
                "br i1 %goes, label %again, label %done",
                "done:",
            ]
        if later:
            for k, part in enumerate(later):
                once.append(f"%goes{k} = icmp sgt i64 %stage, {k}")
                loop += [f"br i1 %goes{k}, label %stage{k}, label %done", f"stage{k}:", *part]
            loop += ["br label %done", "done:"]
        tail = ["%more = icmp slt i64 %next, %n", "br i1 %more, label %loop, label %end"]
        body = ["entry:", *pointers, f"%last = sub i64 %n, {self._lanes}", *once, "br label %loop", "loop:", *head, *loop, *tail]
        declared = [
            f"declare {kind} @llvm.{name}.{short}({', '.join([kind] * count)})"
            for name, count in _DECLARED.items()
            for kind, short in (("double", "f64"), (f"<{self._lanes} x double>", f"v{self._lanes}f64"))
        ]
        arguments = ["inputs", "strides", "parameters", "numbers", "truths"]
        alone = "" if self._repeats else " noalias"
        signature = ", ".join(f"ptr{alone} %{name}" for name in arguments)
        attributes = '{ nounwind "prefer-vector-width"="512" "min-legal-vector-width"="512" }'
        return "\n".join(
            [
                *declared,
                f"define void @{NAME}({signature}, i64 %n, i64 %stage) #0 {{",
                *body,
                "end:",
                "ret void",
                "}",
                f"attributes #0 = {attributes}",
            ]
        )

    def _instruction(self, number: int, operation: Operation, real: str, truth: str, letter: str) -> list[str]:
        name, *taken = operation
        result = f"%{letter}{number}"
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
        a = [self._operand(k, letter) for k in taken]
        if name in _INFIX:
            return [f"{result} = {_INFIX[name]} {real} {a[0]}, {a[1]}"]
        if name in ("and", "or"):
            return [f"{result} = {name} {truth} {a[0]}, {a[1]}"]
        if name == "not":
            return [f"{result} = xor {truth} {a[0]}, {self._constant(True, letter)}"]
        if name == "negative":
            return [f"{result} = fneg {real} {a[0]}"]
        if name == "choose":
            return [f"{result} = select {truth} {a[0]}, {real} {a[1]}, {real} {a[2]}"]
        short = "f64" if letter == "s" else f"v{self._lanes}f64"
        if name in ("sine", "cosine", "angle"):
            integer = "i64" if letter == "s" else f"<{self._lanes} x i64>"
            lines = Instructions(result, real, integer, truth, short, lambda value: self._constant(value, letter))
            if name == "angle":
                angle_of_point(lines, a[0], a[1])
            else:
                sine_or_cosine(lines, a[0], name == "cosine")
            return lines.lines
        return [f"{result} = call {real} @llvm.{_INTRINSICS[name]}.{short}({real} {a[0]})"]

    def _operand(self, number: int, letter: str) -> str:
        operation = self._tape.operations[number]
        if operation[0] == "constant":
            return self._constant(float.fromhex(operation[1]), letter)
        if operation[0] == "truth":
            return self._constant(operation[1], letter)
        return f"%{letter}{number}"

    def _spread(self, number: int) -> list[str]:
        """Return instructions that copy a number independent of the pose into all lanes."""
        if self._tape.operations[number][0] in ("constant", "truth"):
            return []
        kind = "i1" if self._is_truth[number] else "double"
        lanes = f"<{self._lanes} x {kind}>"
        return [
            f"%w{number} = insertelement {lanes} poison, {kind} %s{number}, i64 0",
            f"%v{number} = shufflevector {lanes} %w{number}, {lanes} poison, <{self._lanes} x i32> zeroinitializer",
        ]

    def _stored(self, number: int, kind: str, row: int) -> list[str]:
        name = f"{kind[0]}{row}"
        unit = "double" if kind == "number" else "i8"
        value, lines = self._operand(number, "v"), []
        if kind == "truth":
            lines.append(f"%z{name} = zext <{self._lanes} x i1> {value} to <{self._lanes} x i8>")
            value = f"%z{name}"
        return [
            *lines,
            f"%m{name} = mul i64 %n, {row}",
            f"%q{name} = add i64 %m{name}, %i",
            f"%e{name} = getelementptr {unit}, ptr %{kind}s, i64 %q{name}",
            f"store <{self._lanes} x {unit}> {value}, ptr %e{name}, align {8 if kind == 'number' else 1}",
        ]

    def _constant(self, value: float | bool, letter: str) -> str:
        if isinstance(value, bool):
            kind, digits = "i1", "true" if value else "false"
        else:
            kind, digits = "double", "0x" + struct.pack(">d", value).hex().upper()
        return digits if letter == "s" else "<" + ", ".join([f"{kind} {digits}"] * self._lanes) + ">"


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
    """Return the object code of a module for this processor; optimization passes are omitted, since the record is already
    simplified.

    Args:
        text: see :func:`module_of`.
        level: optimization level of code generation. Level 0 compiles in a tenth of the time of level 1; its code takes almost
            twice as long.
    """
    module = _binding().parse_assembly(text)  # must exist until the code is emitted
    return bytes(_machine(level).emit_object(module))


def processor() -> str:
    """Return the versions of LLVM and its binding and the name of the processor, on which object code depends."""
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
