"""Chromium, and the page of one result, shared by the browser tests."""

import shutil

import pytest
from browser_pages import LOAD, POSES, move, value_of, visits
from playwright.sync_api import sync_playwright

import kinetostatics as ks

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
FLAGS = [
    "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--no-first-run",
]  # fmt: skip


@pytest.fixture(scope="session")
def browser():
    if CHROMIUM is None:
        pytest.skip("Chromium is not installed (Debian: apt install chromium)")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield browser
        browser.close()


@pytest.fixture
def visit(browser):
    with visits(browser) as open_page:
        yield open_page


@pytest.fixture(scope="session")
def root(request):
    return request.config.rootpath


@pytest.fixture(scope="session")
def result(root):
    """One result for the tests that need no robot of their own."""
    robot = ks.load_robot(root / "robots" / "2pru_upr.urdf.xacro")
    return ks.analyze(robot.assemble(platform=POSES["2pru_upr"]), load=LOAD)


@pytest.fixture(scope="session")
def page(browser, result, tmp_path_factory):
    """The page of this result; tests restore what they change."""
    file = tmp_path_factory.mktemp("page") / "shared.html"
    ks.save_html(result, file)
    with visits(browser) as open_page:
        yield open_page(file.as_uri(), (1000, 640))


@pytest.fixture
def operated(page):
    """The same page, whose sliders are set back after the test."""
    values = page.evaluate("[...document.querySelectorAll('input[type=range]')].map(input => [input.name, input.value])")
    yield page
    for name, value in values:
        if value_of(page, name) != float(value):
            move(page, name, value)


def pytest_collection_modifyitems(items):
    for item in items:
        if "browser" in getattr(item, "fixturenames", ()):
            item.add_marker("browser")
