"""The report in headless Chromium: no errors, the scene on screen, a picture of it in print."""

from browser_pages import wait

import kinetostatics as ks


def test_report_opens_without_errors_and_prints_a_still_image(browser, result, tmp_path, monkeypatch):
    monkeypatch.setattr("kinetostatics.report_page.verification_html", lambda *_: "")
    file = tmp_path / "report.html"
    ks.save_report(result.configuration, file, result.load)
    context = browser.new_context(viewport={"width": 900, "height": 700}, offline=True)
    page = context.new_page()
    page.set_default_timeout(90_000)  # a busy machine draws slowly
    problems = []
    page.on("console", lambda message: problems.append(message.text) if message.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.goto(file.as_uri())
    wait(page, "document.querySelector('.still').naturalWidth > 300")
    assert page.locator("h2").all_inner_texts()[:3] == ["In short", "The robot at the pose", "Where the sag comes from"]
    twist = page.evaluate("document.querySelector('iframe').contentWindow.robot_page.scene.title")
    assert twist == result.robot.name
    shown = "[...document.querySelectorAll('.scene, .still')].map(item => item.getBoundingClientRect().height > 0)"
    assert page.evaluate(shown) == [True, False]
    ground = "getComputedStyle(document.body).backgroundColor"
    assert page.evaluate(ground) == "rgb(255, 255, 255)"
    page.emulate_media(color_scheme="dark")  # as the scene
    for frame in page.frames:
        wait(frame, f"{ground} === 'rgb(20, 24, 31)'")
    page.emulate_media(media="print", color_scheme="dark")
    assert page.evaluate(ground) == "rgb(255, 255, 255)"
    assert page.evaluate(shown) == [False, True]
    page.set_viewport_size({"width": 690, "height": 1000})  # an A4 page between its margins
    assert page.evaluate("document.documentElement.scrollWidth") <= 690
    assert problems == []
    context.close()
