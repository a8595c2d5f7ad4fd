"""Draws the two sketches of the guide: ``python examples/guide_robot/draw_sketches.py [FOLDER]``.

The lift table in its zero pose, with the dimensions of ``lift_table.urdf.xacro``, and the graph of its bodies and joints.
"""

import sys
from math import atan2, cos, degrees, hypot, pi, sin
from pathlib import Path

FOLDER = Path(__file__).parents[2] / "docs" / "pictures"

ARM, WHEELBASE, HALF_WIDTH, HOME = 0.7, 0.9, 0.25, pi / 4
LUG, CYLINDER_FOOT = 0.3, 0.7

INK, GREY, BLUE, ORANGE, TEAL, RED = "#22272e", "#8a929c", "#2f6fb0", "#d9822b", "#1f8f88", "#c0392b"


class Drawing:
    """A picture in SVG: shapes in pixels, y downwards."""

    def __init__(self, width: int, height: int, title: str) -> None:
        self.head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
            'font-family="sans-serif" font-size="15">'
        )
        self.parts = [f"<title>{title}</title>", f'<rect width="{width}" height="{height}" fill="white"/>']

    def line(self, *points: tuple[float, float], colour: str = INK, width: float = 2, dash: str = "") -> None:
        """Draw a line through points."""
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        dashes = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(
            f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="{width:g}" stroke-linecap="round"{dashes}/>'
        )

    def circle(self, x: float, y: float, radius: float, fill: str = "white", colour: str = INK) -> None:
        """Draw a circle."""
        self.parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:g}" fill="{fill}" stroke="{colour}" stroke-width="2"/>')

    def box(self, x: float, y: float, width: float, height: float, fill: str, colour: str = INK, radius: float = 0) -> None:
        """Draw a rectangle by its middle and sizes."""
        self.parts.append(
            f'<rect x="{x - width / 2:.1f}" y="{y - height / 2:.1f}" width="{width:.1f}" height="{height:.1f}" rx="{radius:g}" '
            f'fill="{fill}" stroke="{colour}" stroke-width="2"/>'
        )

    def text(self, x: float, y: float, words: str, colour: str = INK, anchor: str = "start", size: int = 15) -> None:
        """Write words; the point is on their base line."""
        self.parts.append(
            f'<text x="{x:.1f}" y="{y:.1f}" fill="{colour}" text-anchor="{anchor}" font-size="{size}">{words}</text>'
        )

    def dimension(self, a: tuple[float, float], b: tuple[float, float], words: str) -> None:
        """Draw a level dimension with its number below."""
        self.line(a, b, colour=GREY, width=1)
        for x, y in (a, b):
            self.line((x - 4, y + 4), (x + 4, y - 4), colour=GREY, width=1)
        self.text((a[0] + b[0]) / 2, a[1] + 17, words, GREY, "middle", 13)

    def svg(self) -> str:
        """Return the file's text."""
        return "\n".join([self.head, *self.parts, "</svg>"]) + "\n"


def sketch() -> str:
    """Return the side view and the view from above."""
    drawing = Drawing(900, 640, "A lift table: side view and view from above")
    scale, left, floor = 430.0, 110.0, 345.0

    def at(x: float, z: float) -> tuple[float, float]:
        return left + scale * x, floor - scale * z

    top = (ARM * cos(HOME), ARM * sin(HOME))
    lug = (LUG * cos(HOME), LUG * sin(HOME))
    lean = atan2(lug[1], lug[0] - CYLINDER_FOOT)
    length = hypot(lug[0] - CYLINDER_FOOT, lug[1])

    # ground and table
    drawing.line(at(-0.12, 0), at(1.05, 0), colour=GREY, width=3)
    for k in range(24):
        x, y = at(-0.12 + 0.05 * k, 0)
        drawing.line((x, y), (x - 9, y + 11), colour=GREY, width=1)
    drawing.line(at(top[0] - 0.08, top[1] + 0.05), at(top[0] + WHEELBASE + 0.12, top[1] + 0.05), colour=TEAL, width=9)
    for x in (top[0], top[0] + WHEELBASE):
        drawing.line(at(x, top[1]), at(x, top[1] + 0.05), colour=TEAL, width=5)
    drawing.text(*at(top[0] + WHEELBASE + 0.15, top[1] + 0.04), "table", TEAL)
    # arms
    for x, name in ((0.0, "rear_arm"), (WHEELBASE, "left_arm, right_arm")):
        drawing.line(at(x, 0), at(x + top[0], top[1]), colour=BLUE, width=9)
        drawing.text(at(x + 0.62 * top[0], 0)[0] + (-82 if x == 0 else 24), at(0, 0.62 * top[1])[1], name, BLUE)
    # cylinder
    middle = (CYLINDER_FOOT + 0.6 * length * cos(lean), 0.6 * length * sin(lean))
    drawing.line(at(CYLINDER_FOOT, 0), at(*middle), colour=ORANGE, width=15)
    drawing.line(at(*middle), at(*lug), colour=ORANGE, width=6)
    drawing.text(*at(0.5, 0.17), "cylinder", ORANGE)
    drawing.text(*at(0.285, 0.225), "rod", ORANGE)
    # joints
    for point, words, shift, anchor in (
        ((0, 0), "rear_foot", (-12, -12), "end"),
        (top, "rear_top", (-14, 4), "end"),
        ((WHEELBASE, 0), "left_foot, right_foot", (-6, 30), "start"),
        ((top[0] + WHEELBASE, top[1]), "left_top, right_top", (14, 18), "start"),
    ):
        x, y = at(*point)
        drawing.circle(x, y, 7)
        drawing.text(x + shift[0], y + shift[1], words, anchor=anchor)
    x, y = at(*lug)
    drawing.circle(x, y, 7, fill=INK)
    drawing.text(x - 14, y - 2, "rod_end (ball)", anchor="end")
    x, y = at(CYLINDER_FOOT, 0)
    drawing.circle(x, y, 9)
    drawing.circle(x, y, 3, fill=INK)
    drawing.text(x + 10, y + 30, "cylinder_foot (universal)", anchor="end")
    # o and the axes of the ground
    x, y = at(top[0] + WHEELBASE / 2, top[1] + 0.05)
    drawing.circle(x, y, 4, fill=RED, colour=RED)
    drawing.text(x, y - 12, "o", RED, "middle")
    x, y = at(0, 0)
    for end, words, where in (((70, 0), "x", (76, 5)), ((0, -70), "z", (-16, -58))):
        drawing.line((x, y), (x + end[0], y + end[1]), colour=RED)
        drawing.text(x + where[0], y + where[1], words, RED)
    # dimensions
    drawing.dimension(at(0, -0.105), at(CYLINDER_FOOT, -0.105), "0.7")
    drawing.dimension(at(0, -0.165), at(WHEELBASE, -0.165), "0.9")
    x, y = at(0.02, 0.02)
    drawing.text(x + 27, y - 8, "45°", GREY, size=13)
    drawing.text(*at(1.14, 0.17), "arms 0.7, lug at 0.3", GREY, size=13)
    drawing.text(20, 30, "side view, zero pose (m)", GREY)
    # from above
    floor_y, width = 545.0, 140.0
    drawing.text(20, 475, "from above", GREY)
    start = left + scale * CYLINDER_FOOT
    drawing.line((start, floor_y), (left + scale * lug[0], floor_y), colour=ORANGE, width=4)
    drawing.circle(start, floor_y, 6)
    drawing.text(start + 12, floor_y + 5, "cylinder", ORANGE)
    for x, y, name, anchor, shift in (
        (0.0, 0.0, "rear_arm", "end", -12),
        (WHEELBASE, HALF_WIDTH, "left_arm", "start", 14),
        (WHEELBASE, -HALF_WIDTH, "right_arm", "start", 14),
    ):
        start, row = left + scale * x, floor_y - width * y / HALF_WIDTH / 2
        end = start + scale * top[0]
        drawing.line((start, row), (end, row), colour=BLUE, width=7)
        for place in (start, end):
            drawing.line((place, row - 11), (place, row + 11))
        drawing.text(start + shift if anchor == "end" else end + shift, row + 5, name, BLUE, anchor)
    x = left + scale * (WHEELBASE + top[0]) + 96
    drawing.line((x, floor_y - width / 2), (x, floor_y + width / 2), colour=GREY, width=1)
    for y in (floor_y - width / 2, floor_y, floor_y + width / 2):
        drawing.line((x - 5, y), (x + 5, y), colour=GREY, width=1)
    drawing.text(x + 8, floor_y - width / 4 + 5, "0.25", GREY, size=13)
    drawing.text(x + 8, floor_y + width / 4 + 5, "0.25", GREY, size=13)
    x, y = 60.0, 622.0
    for end, words, where in (((50, 0), "x", (56, 5)), ((0, -50), "y", (8, -42))):
        drawing.line((x, y), (x + end[0], y + end[1]), colour=RED)
        drawing.text(x + where[0], y + where[1], words, RED)
    return drawing.svg()


def graph() -> str:
    """Return bodies as boxes and joints as lines; dashed lines are cut."""
    drawing = Drawing(860, 415, "The graph of the lift table: bodies, joints, and the three joints that are cut")
    places = {
        "ground": (430, 385, 560), "table": (430, 45, 560), "rear_arm": (250, 215, 120), "rod": (90, 130, 90),
        "cylinder": (90, 260, 110), "left_arm": (480, 215, 110), "right_arm": (640, 215, 110),
    }  # fmt: skip
    joints = (
        ("rear_foot  R", (250, 367), (250, 233), False, (258, 305)),
        ("rear_top  R", (250, 197), (250, 63), False, (258, 130)),
        ("left_foot  R", (480, 367), (480, 233), False, (488, 305)),
        ("left_top  R", (480, 197), (480, 63), True, (488, 130)),
        ("right_foot  R", (640, 367), (640, 233), False, (648, 305)),
        ("right_top  R", (640, 197), (640, 63), True, (648, 130)),
        ("cylinder_foot  U", (165, 367), (90, 278), False, (12, 335)),
        ("stroke  P", (90, 242), (90, 148), False, (98, 200)),
        ("rod_end  S", (135, 140), (198, 197), True, (172, 160)),
    )
    for words, start, end, cut, where in joints:
        drawing.line(start, end, colour=RED if cut else INK, dash="7 6" if cut else "", width=2.5)
        drawing.text(*where, words, RED if cut else INK)
    fills = {"ground": "#e8eaed", "table": "#d5efec", "rod": "#fbe6cc", "cylinder": "#fbe6cc"}
    for name, (x, y, width) in places.items():
        drawing.box(x, y, width, 36, fills.get(name, "#d9e6f4"), radius=6)
        drawing.text(x, y + 5, name, anchor="middle")
    drawing.line((725, 145), (765, 145), width=2.5)
    drawing.text(773, 150, "tree")
    drawing.line((725, 175), (765, 175), colour=RED, dash="7 6", width=2.5)
    drawing.text(773, 180, "cut: a loop", RED)
    return drawing.svg()


#: The files and what is in them.
SKETCHES = {"lift_table_sketch.svg": sketch, "lift_table_graph.svg": graph}

if __name__ == "__main__":
    assert abs(degrees(HOME) - 45) < 1e-9
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER
    for name, draw in SKETCHES.items():
        (folder / name).write_text(draw(), encoding="utf-8")
        print(folder / name)
