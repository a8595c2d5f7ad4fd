"""A process of its own: displacement of one node of a space frame of slender beams by OpenSees, geometrically nonlinear."""

import json
import os
import sys

from kinetostatics.verification.worker import load_opensees

PIECES, STEPS = 16, 10
given = json.load(sys.stdin)
output, sink = os.dup(1), os.open(os.devnull, os.O_WRONLY)
os.dup2(sink, 1)
ops = load_opensees()
A, I_y, I_z, J = given["section"]
ops.wipe()
ops.model("basic", "-ndm", 3, "-ndf", 6)
for tag, point in enumerate(given["nodes"]):
    ops.node(tag, *point)
count, element = len(given["nodes"]), 1
for start, end, stiff in given["beams"]:
    first, last = given["nodes"][start], given["nodes"][end]
    ops.geomTransf(sys.argv[1], element, *((0, 1, 0) if abs(last[1] - first[1]) < 0.5 else (1, 0, 0)))
    transformation, pieces = element, 1 if stiff else PIECES
    before = start
    for k in range(1, pieces + 1):
        now = end if k == pieces else count
        if now == count:
            ops.node(now, *(a + (b - a) * k / pieces for a, b in zip(first, last, strict=True)))
            count += 1
        times = 1e5 if stiff else 1.0
        E, G = given["E"] * times, given["E"] * times / (2 * (1 + 0.3))
        ops.element("elasticBeamColumn", element, before, now, A, E, G, J, I_y, I_z, transformation)
        before, element = now, element + 1
for tag, point in enumerate(given["nodes"]):
    if point[2] == 0:
        ops.fix(tag, 1, 1, 1, 1, 1, 1)
ops.timeSeries("Linear", 1)
ops.pattern("Plain", 1, 1)
ops.load(given["tip"], *given["load"], 0.0, 0.0, 0.0)
ops.constraints("Plain")
ops.numberer("RCM")
ops.system("UmfPack")
ops.test("NormDispIncr", 1e-12, 50)
ops.algorithm("Newton")
ops.integrator("LoadControl", 1 / STEPS)
ops.analysis("Static", "-noWarnings")
done = ops.analyze(STEPS)
moved = [float(value) for value in ops.nodeDisp(given["tip"])]
os.dup2(output, 1)
if done != 0:
    sys.exit("no equilibrium")
print(json.dumps(moved))
