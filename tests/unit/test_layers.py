"""Imports run one way also where a module would be imported by a name in a string, which import-linter does not see."""

import ast
import re
from pathlib import Path

import kinetostatics

PACKAGE = Path(kinetostatics.__file__).parent
MODULES = [path for path in PACKAGE.rglob("*.py") if "robots" not in path.parts]


def test_only_commands_import_modules_by_strings() -> None:
    users = {
        path.relative_to(PACKAGE).parts[0]
        for path in MODULES
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if (isinstance(node, ast.Attribute) and node.attr == "import_module")
        or (isinstance(node, ast.alias) and node.name == "import_module")
        or (isinstance(node, ast.Name) and node.id == "__import__")
    }
    assert users <= {"cli"}  # the top layer, which imports a command's functions when it is called


def test_no_string_outside_of_commands_names_a_function_in_a_module() -> None:
    modules = {".".join(path.relative_to(PACKAGE).with_suffix("").parts) for path in MODULES}
    strings = [
        (path, node.value)
        for path in MODULES
        if path.relative_to(PACKAGE).parts[0] != "cli"
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    ]
    named = [
        (path, text)
        for path, text in strings
        if (m := re.fullmatch(r"(?:kinetostatics\.)?([\w.]+):\w+", text)) and m[1] in modules
    ]
    assert not named
