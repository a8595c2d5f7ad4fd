"""Names from a robot file are text on pages, and pages run their own code only and reach no network."""

import html
import re
from functools import partial

import package_robots
import pytest
from browser_pages import settle, wait

import kinetostatics as ks
from kinetostatics.files.reader import parse_robot_text

IMAGE, QUOTES, SCRIPT = "<img src=x onerror=intrude()>", "\"'><b onclick='intrude()'>&amp;", "</script><script>intrude()</script>"


@pytest.fixture(scope="module")
def hostile():
    """The 3RPS, whose names are markup: of robot, platform, links, joints, beams and a spring."""
    text = package_robots.robot("3rps").description.urdf
    names = {
        "3rps": SCRIPT,
        "platform": IMAGE,
        "rod_1": f"{IMAGE}1",
        "prismatic_1": QUOTES,
        "spherical_1": f"{IMAGE}2",
        "cylinder_2": SCRIPT,
    }
    for name, markup in names.items():
        text = re.sub(f'="{name}(?=[_"])', lambda _, markup=markup: f'="{html.escape(markup)}', text)
    spring = """<spring name="NAME" stiffness="500" free_length="0.9"><predecessor link="base"/>
<successor link="LINK"/></spring></robot>"""
    text = text.replace("</robot>", spring.replace("NAME", html.escape(f"{IMAGE}3")).replace("LINK", html.escape(IMAGE)))
    return ks.Robot(parse_robot_text(text, "hostile.urdf"))


#: Opens all folds and cards of a page, and draws its picture.
SHOW_ALL = """() => { document.querySelectorAll("details").forEach(fold => { fold.open = true; });
  const paths = [...robot_page.solids.values()].map(({ spec }) => spec.path).concat([...robot_page.arrows.keys()]);
  for (const path of paths) robot_page.selectPath(path);
  return [robot_page.picture(1).length, paths.length, document.body.innerText]; }"""
#: Elements that names could have made.
MADE = (
    "document.querySelectorAll('img:not(.still):not(.map), b[onclick], [onerror], [onload]').length + (window.intruded ? 100 : 0)"
)


@pytest.fixture
def watched(browser):
    """Opens pages that note a call of ``intrude()``."""
    context = browser.new_context(viewport={"width": 1000, "height": 700}, offline=True, reduced_motion="reduce")
    context.add_init_script("window.intrude = () => { window.intruded = true; }")

    def visit(file):
        page = context.new_page()
        page.wait_for_function = partial(wait, page)
        page.goto(file.as_uri())
        return page

    yield visit
    context.close()


def result_of(robot):
    link = robot.description.platform
    return ks.analyze(
        robot.assemble(), [10, 20, -50, 1, 2, 3], loads={link: [5, 0, 0, 0, 0, 0]}, payload=ks.Payload(1.0, (0, 0, 0), link=link)
    )


@pytest.mark.few(2)
@pytest.mark.parametrize("kind", ["result", "compared", "pose", "modes"])
def test_names_are_texts_on_the_page_its_cards_and_labels(hostile, watched, tmp_path, kind):
    result = result_of(hostile)
    shown = {"result": result, "compared": result, "pose": result.configuration, "modes": None}[kind] or ks.modes(
        result.configuration, 2
    )
    ks.save_html(shown, tmp_path / "page.html", title=IMAGE, **({"compare": result} if kind == "compared" else {}))
    page = watched(tmp_path / "page.html")
    page.wait_for_function("window.robot_page && robot_page.ready && (robot_page.state.playing || !viewer.needs_render)")
    size, count, words = page.evaluate(SHOW_ALL)
    settle(page)
    assert size > 10_000 and count > 10
    assert IMAGE in words and page.title() == IMAGE
    if kind == "result":
        assert f"load on {IMAGE}" in words and QUOTES in words
    page.wait_for_timeout(100)
    assert page.evaluate(MADE) == 0


@pytest.mark.slow
def test_names_are_texts_in_the_report(hostile, watched, tmp_path):
    ks.save_report(hostile.assemble(), tmp_path / "report.html", title=IMAGE)
    page = watched(tmp_path / "report.html")
    page.wait_for_function("document.querySelector('.still').getAttribute('src')")
    assert QUOTES in page.inner_text("body") and page.title() == IMAGE
    for frame in page.frames:
        assert frame.evaluate(MADE) == 0
    assert len(page.frames) == 2 and page.frames[1].evaluate("robot_page.ready")


#: Notes in ``tried`` what the page's policy lets through, from a timer, as scripts of the page do.
TRY = """() => { window.tried = {};
  const note = (name, attempt) => Promise.resolve().then(attempt).then(
    (x) => { tried[name] = x ?? true; }, () => { tried[name] = false; });
  setTimeout(() => {
    note("eval", () => eval("1") === 1);
    note("function", () => new Function("return 1")() === 1);
    note("fetch", () => fetch("data:text/plain,1"));
    note("module", () => WebAssembly.instantiate(new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0])));
    const script = Object.assign(document.createElement("script"), { textContent: "window.intruded = true" });
    note("inline", () => { document.head.append(script); return window.intruded === true; });
    const image = new Image();
    note("image", () => new Promise((done, fail) => { image.onload = done; image.onerror = fail; image.src = "ELSEWHERE"; }));
  }); }"""


@pytest.mark.parametrize("kind", ["page", "report"])
def test_policy_allows_own_code_only_and_no_network(result, watched, tmp_path, kind):
    if kind == "page":
        ks.save_html(result, tmp_path / "page.html")
    else:
        ks.save_report(result.configuration, tmp_path / "page.html")
    (tmp_path / "dot.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg" width="1" height="1"/>')
    page = watched(tmp_path / "page.html")
    for frame in page.frames:
        frame.evaluate(TRY.replace("ELSEWHERE", (tmp_path / "dot.svg").as_uri()))
        wait(frame, "() => Object.keys(tried).length === 6")
        tried = frame.evaluate("tried")
        assert tried.pop("module")
        assert not any(tried.values()), tried
