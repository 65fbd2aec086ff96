"""The viewer in a browser, from end to end: a scene served as `glimt view --web` does, and headless Chromium."""

import io
import json
import math
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from chromium import chromium, needs_chromium, wait_until

HERE = Path(__file__).parent
STONE_ROOM = HERE.parents[1] / "examples" / "stone_room.toml"

pytestmark = needs_chromium


class App:
    """The served viewer, in a process of its own."""

    def __init__(self, folder, port=0):
        self.process = subprocess.Popen(
            [sys.executable, str(HERE / "view_web_app.py"), str(STONE_ROOM), str(port), str(folder)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.url = self.process.stdout.readline().strip()
        assert self.url.startswith("http://127.0.0.1:"), self.url

    def state(self):
        self.process.stdin.write("state\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())

    def wait_for(self, condition, seconds=10.0):
        end = time.monotonic() + seconds
        while not condition(state := self.state()):
            assert time.monotonic() < end, state
            time.sleep(0.02)
        return state

    def close(self):
        self.process.terminate()
        with self.process:  # closes its pipes
            self.process.wait(10)


@pytest.fixture(scope="module")
def app(tmp_path_factory):
    app = App(tmp_path_factory.mktemp("files"))
    yield app
    app.close()
    assert app.process.returncode == 0


@pytest.fixture(scope="module")
def browser():
    with chromium() as browser:
        yield browser


@pytest.fixture
def page(app, browser):
    context = browser.new_context(viewport={"width": 640, "height": 400})
    page = context.new_page()
    page.goto(app.url)
    wait_for_picture(page)
    yield page
    context.close()


def shot(page):
    return np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB")).astype(int)


def wait_for_picture(page, seconds=10.0):
    """Wait until the middle of the page shows something lit; return how long that took."""
    start = time.monotonic()
    while shot(page)[150:350, 200:600].std() < 15:
        assert time.monotonic() - start < seconds, "no picture"
        time.sleep(0.02)
    return time.monotonic() - start


def test_the_picture_is_there_soon_after_the_page(app, browser):
    context = browser.new_context(viewport={"width": 640, "height": 400})
    page = context.new_page()
    start = time.monotonic()
    page.goto(app.url)
    wait_for_picture(page)
    seconds = time.monotonic() - start
    print(f"{seconds:.2f} s from opening the page to the picture")
    assert seconds < 5  # 2 on a machine that does nothing else
    assert "glimt" in page.title()
    assert "stone_room" in page.title()
    context.close()


def test_keys_and_pointer_move_the_camera_and_the_picture(app, page):
    app.wait_for(lambda state: tuple(state["size"]) == (640, 400))
    before, picture = app.state(), shot(page)
    page.keyboard.down("w")
    time.sleep(0.4)
    page.keyboard.up("w")
    state = app.wait_for(lambda state: math.dist(state["position"], before["position"]) > 0.05)
    page.mouse.move(300, 200)
    page.mouse.down()
    page.mouse.move(400, 220, steps=5)
    page.mouse.up()
    app.wait_for(lambda now: math.dist(now["look"], state["look"]) > 0.02)
    time.sleep(0.3)
    assert np.abs(shot(page) - picture).mean() > 2
    page.keyboard.press("b")
    page.keyboard.press("l")
    app.wait_for(lambda now: (now["bounces"], now["lights"]) == (before["bounces"] + 1, before["lights"] + 1))
    page.keyboard.press("Shift+B")
    page.keyboard.press("Shift+L")
    app.wait_for(lambda now: (now["bounces"], now["lights"]) == (before["bounces"], before["lights"]))
    page.keyboard.press("r")


def test_the_picture_follows_the_size_of_the_page(app, page):
    page.set_viewport_size({"width": 500, "height": 300})
    app.wait_for(lambda state: tuple(state["size"]) == (500, 300))
    wait_for_picture_again = shot(page)
    assert wait_for_picture_again.shape == (300, 500, 3)


def test_a_reload_connects_again(app, page):
    page.reload()
    wait_for_picture(page)
    before = app.state()
    page.keyboard.down("s")
    time.sleep(0.3)
    page.keyboard.up("s")
    app.wait_for(lambda state: math.dist(state["position"], before["position"]) > 0.02)


def test_a_second_visitor_watches_and_cannot_steer(app, page, browser):
    context = browser.new_context(viewport={"width": 640, "height": 400})
    second = context.new_page()
    second.goto(app.url)
    second.wait_for_selector("#status[data-state=watching]", state="attached")
    wait_for_picture(second)
    page.keyboard.press("t")  # lights stand: both come to show the same
    app.wait_for(lambda state: state["at_rest"], 20)
    before = app.state()
    second.keyboard.down("w")
    time.sleep(0.4)
    second.keyboard.up("w")
    time.sleep(0.5)
    assert app.state()["position"] == before["position"]
    time.sleep(0.5)
    difference = np.abs(shot(page) - shot(second))[40:, 200:]
    assert difference.mean() < 2  # the same picture, as two JPEGs of it
    page.keyboard.press("t")
    context.close()


def test_without_visitors_nothing_is_computed(app, page):
    page.close()
    time.sleep(1.0)
    start, first = time.monotonic(), app.state()["cpu_seconds"]
    time.sleep(2.0)
    share = (app.state()["cpu_seconds"] - first) / (time.monotonic() - start)
    print(f"{100 * share:.1f} % of a core without visitors, though a light moves")
    assert share < 0.1


def test_frames_a_second_in_the_browser(app, page):
    """Counts what the page shows of the stone room at 640×400 while the lamp moves; printed, for a machine at rest."""
    page.evaluate("""() => {
        window.shown = 0;
        const canvas = document.querySelector("canvas");
        const context = canvas.getContext("bitmaprenderer");
        const transfer = context.transferFromImageBitmap.bind(context);
        context.transferFromImageBitmap = (image) => { window.shown += 1; transfer(image); };
    }""")
    time.sleep(0.5)
    first, start = page.evaluate("window.shown"), time.monotonic()
    time.sleep(3.0)
    rate = (page.evaluate("window.shown") - first) / (time.monotonic() - start)
    print(f"{rate:.0f} frames a second in the browser")
    assert rate > 5


def test_full_screen_comes_again_after_the_browser_has_ended_it(app, page):
    for _ in range(2):
        page.keyboard.press("u")
        wait_until(page, "Boolean(document.fullscreenElement)")
        page.wait_for_timeout(100)  # for the server to hear of it
        page.evaluate("document.exitFullscreen()")  # as Esc does, which no page sees
        wait_until(page, "!document.fullscreenElement")
        page.wait_for_timeout(100)
    page.keyboard.press("u")
    wait_until(page, "Boolean(document.fullscreenElement)")
    page.wait_for_timeout(100)
    page.keyboard.press("u")
    wait_until(page, "!document.fullscreenElement")


def test_screenshots_are_downloaded(app, page):
    with page.expect_download() as download:
        page.keyboard.press("p")
    assert download.value.suggested_filename.startswith("stone_room-")
