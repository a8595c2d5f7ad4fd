"""One Chromium for all tests of the browser."""

import os
import shutil

import pytest
from browser_pages import visits

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
REQUIRED = os.environ.get("KINETOSTATICS_REQUIRE_BROWSER") == "1"
FLAGS = [
    "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--no-first-run",
]  # fmt: skip


def missing(reason):
    if REQUIRED:
        pytest.fail(f"{reason}, but KINETOSTATICS_REQUIRE_BROWSER is set")
    pytest.skip(reason)


@pytest.fixture(scope="session")
def browser():
    if CHROMIUM is None:
        missing("Chromium is not installed (Debian: apt install chromium)")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        missing("playwright is not installed (pip install 'kinetostatics[test]')")
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
