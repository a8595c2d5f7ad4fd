"""The page on the structure of the code: its path from file to twist and its folders are those of the code."""

import json
import re
import subprocess
import sys
from itertools import pairwise

from places import ROOT

#: Evaluates its argument and prints the functions of the package in the order in which they were entered first.
FOLLOW = """
import json, os, sys
import kinetostatics as ks

package, entered = os.path.dirname(ks.__file__) + os.sep, {}

def note(frame, event, _):
    code = frame.f_code
    if event == "call" and code.co_filename.startswith(package):
        entered[code.co_filename[len(package):-3].replace(os.sep, "/"), code.co_name] = True

sys.setprofile(note)
eval(sys.argv[1])
sys.setprofile(None)
print(json.dumps(list(entered)))
"""


def test_calls_from_file_to_twist_are_those_on_the_page():
    page = (ROOT / "docs" / "explanation" / "inside.md").read_text(encoding="utf-8")
    section = page.split("## One path, from file to twist")[1].split("\n## ")[0]
    rows = re.findall(r"^\| `([\w/]+)` \| (`.*`) \|", section, re.MULTILINE)
    told = [[module, name.rpartition(".")[2]] for module, names in rows for name in re.findall(r"`([\w.]+)`", names)]
    expression = re.search(r"`(ks\.analyze\(.*\.twist)`", section)
    assert expression is not None and len(told) > 20
    entered = json.loads(subprocess.check_output([sys.executable, "-c", FOLLOW, expression[1]], text=True))
    assert [one for one in told if one not in entered] == []
    for one, following in pairwise(told):
        assert entered.index(one) < entered.index(following), f"{following} comes before {one}"


def test_page_names_the_folders_of_the_code():
    rooms = (ROOT / "docs" / "explanation" / "inside.md").read_text(encoding="utf-8").partition("## The code")[2]
    named = {name for row in re.findall(r"^\| (`.*?) \|", rooms, re.MULTILINE) for name in re.findall(r"`([a-z_]+)`", row)}
    source = ROOT / "src" / "kinetostatics"
    assert {path.parent.name for path in source.glob("*/__init__.py")} <= named
    assert all(list(source.glob(f"{name}*")) for name in named), named
