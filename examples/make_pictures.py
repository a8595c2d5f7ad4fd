"""Draws the pictures of the README and of docs/ from exported pages: ``python examples/make_pictures.py [FOLDER]``.

Needs Chromium and ``pip install 'kinetostatics[test]'``. The pages are those of ``kinetostatics view --html``; this script
chooses their options and the camera.
"""

import io
import shutil
import sys
import tempfile
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import Browser, sync_playwright

import kinetostatics as ks
from kinetostatics.viewer.running_meshcat import connected

ROOT = Path(__file__).parent.parent
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]


@dataclass
class Picture:
    """A picture: robot, pose, and options of the page."""

    robot: str
    platform: dict[str, float]
    title: str
    orientation: str | None = None
    load: tuple[float, ...] = (0, 0, 0, 0, 0, 0)
    gravity: tuple[float, ...] = (0, 0, -9.8)
    view: tuple[float, float, float] = (1.5, -2.6, 1.1)
    groups: dict[str, bool] = field(default_factory=dict)
    sliders: bool = False
    colour: str = "deflection"
    card: str = ""
    compare: dict[str, float] | None = None
    size: tuple[int, int] = (1200, 760)


PICTURES = {
    # the paper's configuration 2 of both robots
    "3rps": Picture(
        "3rps",
        {"z": 0.5, "azimuth": np.radians(-170), "tilt": np.radians(10)},
        "3RPS under its own weight",
        orientation="tilt_torsion",
    ),
    "2pru_upr": Picture(
        "2pru_upr",
        {"z": 0.6, "rx": np.radians(-5), "ry": np.radians(-6)},
        "2PRU-UPR under its own weight",
        orientation="XYZ",
        view=(2.2, -1.5, 1.1),
    ),
    "wrenches": Picture(
        "2pru_upr",
        {"z": 0.6, "rx": np.radians(-5), "ry": np.radians(-6)},
        "2PRU-UPR, constraint forces under a load",
        orientation="XYZ",
        load=(0, 0, -500, 0, 0, 0),
        view=(2.2, -1.5, 1.1),
        groups={"constraint forces": True, "actuator forces": False},
    ),
    "page": Picture(
        "3rps",
        {"z": 0.5, "rx": 0.03, "ry": -0.17},
        "3rps",
        load=(100, 50, -500, 0, 0, 0),
        sliders=True,
        size=(1200, 800),
    ),
    "stress": Picture(
        "2pru_upr",
        {"z": 0.6, "rx": 0.1, "ry": 0.1},
        "2pru_upr",
        load=(100, 50, -500, 0, 0, 0),
        view=(2.2, -1.5, 1.1),
        sliders=True,
        colour="stress",
        card="beams/rod_1",
        size=(1200, 800),
    ),
    "compare": Picture(
        "3rps",
        {"z": 0.5, "rx": 0.03, "ry": -0.17},
        "3rps",
        load=(100, 50, -500, 0, 0, 0),
        compare={"z": 0.55, "rx": 0.03, "ry": 0.1},
        groups={"actuator forces": False},
    ),
}


def result_of(picture: Picture) -> ks.Result:
    """Analyze the robot of a picture."""
    robot = ks.load_robot(ROOT / "robots" / f"{picture.robot}.urdf.xacro")
    pose = robot.assemble(platform=picture.platform, orientation=picture.orientation)
    return ks.analyze(pose, load=picture.load, gravity=picture.gravity)


#: Robots that are drawn as the page and as meshcat show them, with their poses.
SIDE_BY_SIDE: dict[str, dict[str, float]] = {
    "3rps": {"z": 0.5, "rx": 0.03, "ry": -0.17},
    "2pru_upr": {"z": 0.6, "rx": 0.1, "ry": 0.1},
    **{name: {} for name in ("gough_stewart", "delta", "ur10", "planar_3rrr")},
}


def draw_side_by_side(browser: Browser, pages: Path, folder: Path) -> None:
    """Draw some robots under a load, as the page shows them and as a running meshcat does."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, platform in SIDE_BY_SIDE.items():
        load = [10, 5, -50, 0, 0, 0] if name == "planar_3rrr" else [100, 50, -500, 0, 0, 0]
        robot = ks.load_robot(name)
        result = ks.analyze(robot.assemble(platform=platform) if platform else robot.assemble(), load=load)
        page, scene = pages / f"{name}_page.html", pages / f"{name}_meshcat.html"
        ks.save_html(result, page)
        with connected(None) as visualizer:
            ks.show(result, visualizer=visualizer)
            scene.write_text(visualizer.static_html(), encoding="utf-8")
        pair = Image.new("RGB", (1680, 560), "white")
        for k, file in enumerate((page, scene)):
            tab = browser.new_page(bypass_csp=True, viewport={"width": 840, "height": 560})
            tab.set_default_timeout(300_000)
            tab.goto(f"{file.as_uri()}#picture")
            tab.wait_for_function("window.robot_page?.ready || viewer.scene_tree.children.Cameras.children.default" + LEGEND)
            if file is scene:
                tab.evaluate("viewer.animator.pause(); viewer.animator.seek(0)")
                tab.evaluate("document.querySelector('.dg.main').style.display = 'none'")
            tab.wait_for_function("!viewer.needs_render")
            tab.wait_for_timeout(500)
            pair.paste(Image.open(io.BytesIO(tab.screenshot())), (840 * k, 0))
            tab.close()
        pair.save(folder / f"{name}.webp", quality=80, method=6)
        print(f"meshcat/{name}.webp: {(folder / f'{name}.webp').stat().st_size / 1e3:.0f} kB")


#: The last thing that is drawn, when it is there.
LEGEND = ".children.rotated.children['<object>'].children.kinetostatics?.children.legend?.children['<object>']"
#: where the camera stands for robots that are flat
VIEWS = {"five_bar": (0.7, -1.6, 1.9), "planar_3rrr": (0.7, -1.6, 1.9)}


#: Shows one mesh alone, in the middle of the picture.
ALONE = """([name, zoom]) => { const deformed = viewer.scene_tree.find(["Deformed"]), node = deformed.find(name.split("/"));
  const kept = ["Deformed", "Cameras", "Lights", "Background"], parts = Object.keys(viewer.scene_tree.children);
  for (const part of parts.filter((part) => !kept.includes(part))) viewer.scene_tree.find([part]).object.visible = false;
  for (const { mesh } of robot_page.solids.values()) mesh.visible = mesh === robot_page.solids.get(`Deformed/${name}`).mesh;
  for (const label of document.querySelectorAll(".robot-label, .robot-leader")) label.remove();
  const middle = new MeshCat.THREE.Box3().setFromObject(node.object).getCenter(new MeshCat.THREE.Vector3());
  viewer.camera.position.add(middle).sub(viewer.controls.target);
  viewer.controls.target.copy(middle); viewer.controls.update();
  viewer.camera.zoom = zoom; viewer.camera.updateProjectionMatrix(); viewer.set_dirty(); }"""


def draw_robot(
    browser: Browser, result: ks.Result, file: Path, view: tuple[float, float, float], alone: str = "", zoom: float = 1.0
) -> None:
    """Draw a robot, or one mesh ``alone``, bent by its load, without the page's panel."""
    made = file.with_suffix(".html")
    ks.save_html(result, made, title=file.stem)
    page = browser.new_page(bypass_csp=True, viewport={"width": 900, "height": 620})
    page.set_default_timeout(300_000)  # drawn without a graphics card
    page.goto(made.as_uri())
    page.wait_for_function("window.robot_page && robot_page.ready")
    page.evaluate("document.body.classList.add('without-panel')")
    page.evaluate("document.body.classList.remove('live')")  # no space for messages
    for part in ("head", "message"):
        page.evaluate("part => { document.getElementById(`robot-${part}`).style.display = 'none'; }", part)
    page.evaluate("view => { robot_page.look(...view); viewer.set_dirty(); }", list(view))
    page.evaluate("for (const { object } of robot_page.handles) object.visible = false")
    if alone:
        page.evaluate(ALONE, [alone, zoom])
    page.wait_for_function("!viewer.needs_render")
    page.wait_for_timeout(200)
    picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    picture.save(file, optimize=True, quality=88, method=6)
    page.close()
    made.unlink()
    print(f"{file.name}: {file.stat().st_size / 1e3:.0f} kB")


def draw_gallery(browser: Browser, folder: Path) -> None:
    """Draw every robot that comes with the package at zero."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in ks.robots():
        result = ks.analyze(ks.load_robot(name).assemble())
        draw_robot(browser, result, folder / f"{name}.webp", VIEWS.get(name, (1.5, -2.6, 1.1)))


#: Load at o [N] and direction of view of the robots of castings, and a part that is drawn alone: its mesh and the zoom.
CASTINGS = {
    "3rps_plate": ((0, 0, -500), (0.8, -1.6, 1.5)),
    "delta_bearings": ((0, 0, -30), (1.5, -2.6, 0.9)),
    "five_bar_castings": ((0, 0, -50), (0.7, -1.6, 1.2)),
}
PARTS_ALONE = {"plate": ("3rps_plate", "links/platform", 2.2), "frame": ("3rps_plate", "links/base", 1.5)}


def draw_castings(browser: Browser, folder: Path) -> None:
    """Draw the robots of castings under load, and parts of them."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, (force, view) in CASTINGS.items():
        robot = ks.load_robot(ROOT / "examples" / "castings" / f"{name}.urdf")
        result = ks.analyze(robot.assemble(), load=[*force, 0, 0, 0])
        draw_robot(browser, result, folder / f"{name}.png", view)
        for part, (_, mesh, zoom) in ((part, which) for part, which in PARTS_ALONE.items() if which[0] == name):
            draw_robot(browser, result, folder / f"{part}.png", (0.5, -1.2, 1.3), mesh, zoom)


def main(folder: Path) -> None:
    """Draw all pictures."""
    folder.mkdir(parents=True, exist_ok=True)
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    with tempfile.TemporaryDirectory() as pages, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        for name, picture in PICTURES.items():
            file = Path(pages) / f"{name}.html"
            second = None if picture.compare is None else result_of(replace(picture, platform=picture.compare))
            ks.save_html(result_of(picture), file, title=picture.title, compare=second)
            page = browser.new_page(bypass_csp=True, viewport={"width": picture.size[0], "height": picture.size[1]})
            page.goto(file.as_uri())
            page.wait_for_function("window.robot_page && robot_page.ready")
            for group, seen in picture.groups.items():
                page.evaluate("([group, seen]) => viewer.set_property(['Arrows', group], 'visible', seen)", [group, seen])
            page.select_option("select[name='colour by']", picture.colour)
            if picture.card:
                page.evaluate("path => robot_page.selectPath(path)", picture.card)
            if not picture.sliders:
                page.evaluate("document.body.classList.add('as-picture')")
                page.wait_for_timeout(200)
            page.evaluate("view => { robot_page.look(...view); viewer.set_dirty(); }", list(picture.view))
            page.wait_for_function("!viewer.needs_render")
            page.wait_for_timeout(200)
            page.screenshot(path=folder / f"{name}.png")
            page.close()
            print(f"{name}.png: {(folder / f'{name}.png').stat().st_size / 1e3:.0f} kB")
        draw_gallery(browser, folder / "robots")
        draw_castings(browser, folder / "castings")
        file = Path(pages) / "live.html"
        ks.save_html(result_of(PICTURES["page"]), file)
        page = browser.new_page(bypass_csp=True, viewport={"width": 1100, "height": 760})
        page.goto(file.as_uri())
        page.wait_for_function("window.robot_page && robot_page.ready && !viewer.needs_render")
        page.wait_for_timeout(200)
        page.screenshot(path=folder / "live.png")
        page.close()
        draw_side_by_side(browser, Path(pages), folder / "meshcat")
        browser.close()


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "pictures")
