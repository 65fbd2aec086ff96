"""The viewer's page in a browser: Debian's Chromium without a screen, driven by Playwright."""

import contextlib
import io
import json
import time

import numpy as np
import pytest
from PIL import Image
from web_host import WebHost

from chromium import chromium, needs_chromium, wait_until

pytestmark = needs_chromium

SIZE = {"width": 640, "height": 400}


@pytest.fixture(scope="module")
def browser():
    with chromium() as browser:
        yield browser


@pytest.fixture(scope="module")
def host():
    with WebHost() as host:
        yield host


@pytest.fixture
def open_page(browser):
    """Open pages that must write nothing on the console, but that a server has gone: no page can prevent that."""
    with contextlib.ExitStack() as stack:
        written = []

        def open_page(url, state="connected", viewport=SIZE, **options):
            context = browser.new_context(viewport=viewport, **options)
            stack.callback(context.close)
            page = context.new_page()
            page.on("console", lambda message: written.append(message.text))
            page.on("pageerror", lambda error: written.append(str(error)))
            page.goto(url)
            wait_for_status(page, state)
            return page

        open_page.written = written
        yield open_page
    assert [line for line in written if "ERR_CONNECTION_REFUSED" not in line] == []


def wait_for_status(page, state):
    page.wait_for_selector(f"#status[data-state={state}]", state="attached")
    assert page.inner_text("#status") == state


def shot(page):
    """Return what is on the screen, as (height, width, 3)."""
    return np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB")).astype(int)


def wait_for_picture(page):
    """Wait until the test picture is there: red grows to the right, green downwards."""
    deadline = time.monotonic() + 10
    while time.monotonic() < deadline:
        image = shot(page)
        height, width = image.shape[:2]
        samples = image[np.ix_((height // 4, height * 3 // 5), (width // 4, width * 3 // 4))]
        expected = [[[255 / 4, 255 / 4, 64], [255 * 3 / 4, 255 / 4, 64]],
                    [[255 / 4, 255 * 3 / 5, 64], [255 * 3 / 4, 255 * 3 / 5, 64]]]
        if np.abs(samples - expected).max() < 8:
            return image
        time.sleep(0.05)
    raise AssertionError(f"another picture: {samples.tolist()}")


def pointer_events(host, start):
    return [(event["event_type"], event["x"], event["y"], event["button"], event["buttons"])
            for event in host.events(start) if "buttons" in event and "button" in event]


def test_the_picture_fills_the_window_smoothly(host, open_page):
    image = wait_for_picture(open_page(host.url))
    row = image[20, 100:500, 0]
    assert len(np.unique(row)) > 150  # 160 pixels wide, drawn 640 wide: the steps are filled
    assert image[0, :, 2].min() > 40  # up to the edge
    assert image[:, -1, 0].min() > 230


def test_the_canvas_follows_the_window_and_its_pixels(host, open_page):
    start = len(host.said)
    page = open_page(host.url, device_scale_factor=3)
    host.wait_for_event("resize", start, width=640, height=400, pixel_ratio=2)  # no more than 2
    page.set_viewport_size({"width": 480, "height": 300})
    host.wait_for_event("resize", start, width=480, height=300, pixel_ratio=2)
    wait_for_picture(page)


def test_title_and_what_the_server_says_about_itself(host, open_page):
    page = open_page(host.url)
    assert page.title() == "glimt — <test & more>"
    assert page.evaluate("document.activeElement.id") == "view"


def test_keys_work_without_a_click(host, open_page):
    page = open_page(host.url)
    start = len(host.said)
    for key in ("w", "Shift+W", "Space", "ArrowLeft", "Tab", "/", "F1", "Control"):
        page.keyboard.press(key)
    host.wait_for_event("key_up", start, key="Control")
    downs = [event["key"] for event in host.events(start) if event["event_type"] == "key_down"]
    ups = [event["key"] for event in host.events(start) if event["event_type"] == "key_up"]
    assert downs == ["w", "Shift", "W", " ", "ArrowLeft", "Tab", "/", "F1", "Control"]
    assert sorted(ups) == sorted(downs)
    assert page.evaluate("document.activeElement.id") == "view"  # Tab has not moved on


def test_a_key_comes_up_as_it_went_down(host, open_page):
    page = open_page(host.url)
    start = len(host.said)
    page.keyboard.down("Shift")
    page.keyboard.down("W")
    page.keyboard.up("Shift")
    page.keyboard.up("w")
    host.wait_for_event("key_up", start, key="W")
    assert "w" not in [event.get("key") for event in host.events(start)]


def test_keys_that_are_held_come_once_and_up_with_the_focus(host, open_page):
    page = open_page(host.url)
    start = len(host.said)
    for _ in range(3):
        page.keyboard.down("w")
    page.mouse.move(5, 5)
    page.mouse.down()
    page.evaluate("window.dispatchEvent(new Event('blur'))")
    host.wait_for_event("pointer_up", start)
    assert [event["event_type"] for event in host.events(start) if "key" in event] == ["key_down", "key_up"]


def test_the_browsers_own_keys_are_left_alone(host, open_page):
    page = open_page(host.url)
    start = len(host.said)
    taken = page.evaluate("""() => ["c", "F5", "a"].map((key) => !document.body.dispatchEvent(new KeyboardEvent(
        "keydown", {key, code: key, ctrlKey: key === "c", bubbles: true, cancelable: true})))""")
    assert taken == [False, False, True]
    host.wait_for_event("key_down", start)
    assert [event["key"] for event in host.events(start)] == ["a"]


def test_pointer_buttons_and_wheel(host, open_page):
    page = open_page(host.url)
    start = len(host.said)
    page.mouse.move(100, 50)
    page.mouse.down()
    page.mouse.down(button="right")
    page.mouse.move(300, 150, steps=5)
    page.mouse.up()
    page.mouse.up(button="right")
    page.mouse.move(10, 20)
    page.mouse.dblclick(10, 20)
    host.wait_for_event("double_click", start, x=10, y=20)
    events = pointer_events(host, start)
    clicks = [event for event in events if event[0] in ("pointer_down", "pointer_up")]
    assert clicks[:4] == [("pointer_down", 100, 50, 1, [1]), ("pointer_down", 100, 50, 2, [1, 2]),
                          ("pointer_up", 300, 150, 1, [2]), ("pointer_up", 300, 150, 2, [])]
    moves = [event for event in events if event[0] == "pointer_move"]
    assert ("pointer_move", 300, 150, 1, [1, 2]) in moves
    assert moves[-1][1:] == (10, 20, 0, [])
    start = len(host.said)
    page.evaluate("""() => [[0, 100], [10, 0], [20, -20]].forEach(([deltaX, deltaY]) => document.getElementById("view")
        .dispatchEvent(new WheelEvent("wheel", {deltaX, deltaY})))""")
    host.wait_for(lambda said: sum(event.get("dx", 0) for event in host.events(start)) == 30, start)
    turned = [event for event in host.events(start) if event["event_type"] == "wheel"]
    assert sum(event["dy"] for event in turned) == 80
    assert all((event["x"], event["y"]) == (10, 20) for event in turned)


def touch(fingers, kind, *points):
    fingers.send("Input.dispatchTouchEvent", {"type": f"touch{kind}", "touchPoints": [
        {"x": x, "y": y, "id": number} for number, (x, y) in enumerate(points)]})


def test_fingers(host, open_page):
    page = open_page(host.url, has_touch=True)
    fingers = page.context.new_cdp_session(page)
    start = len(host.said)
    touch(fingers, "Start", (100, 100))
    for x in (104, 120, 160):  # 104 is a finger that trembles
        touch(fingers, "Move", (x, 100))
    touch(fingers, "End")
    host.wait_for_event("pointer_up", start)
    events = pointer_events(host, start)
    assert events[0] == ("pointer_down", 100, 100, 1, [1])
    assert events[-1] == ("pointer_up", 160, 100, 1, [])
    assert {event[0] for event in events[1:-1]} == {"pointer_move"}

    start = len(host.said)
    touch(fingers, "Start", (200, 100))
    touch(fingers, "Start", (200, 100), (300, 100))
    touch(fingers, "Move", (150, 120), (350, 120))  # twice as far apart, and 20 down
    touch(fingers, "End")
    host.wait_for_event("pointer_up", start)
    events = pointer_events(host, start)
    assert events[0] == ("pointer_down", 250, 100, 3, [3])
    assert events[-1] == ("pointer_up", 250, 120, 3, [])
    wheels = [event for event in host.events(start) if event["event_type"] == "wheel"]
    assert sum(event["dy"] for event in wheels) == pytest.approx(-500)

    start = len(host.said)
    for _ in range(2):
        page.touchscreen.tap(50, 60)
    host.wait_for_event("double_click", start, x=50, y=60)
    page.wait_for_timeout(100)
    assert [event[0] for event in pointer_events(host, start)] == [
        "pointer_down", "pointer_up", "pointer_down", "pointer_up", "double_click"]


def test_the_pointer_is_captured_and_given_back(host, open_page):
    page = open_page(host.url)
    page.mouse.move(600, 200)
    page.keyboard.press("m")
    wait_until(page, "document.pointerLockElement?.id === 'view'")
    start = len(host.said)
    page.evaluate("""() => { for (let step = 0; step < 100; step++) document.getElementById("view").dispatchEvent(
        new PointerEvent("pointermove", {movementX: 30, movementY: -1, clientX: 600, clientY: 200})); }""")
    host.wait_for_event("pointer_move", start, x=3600, y=100)
    page.evaluate("document.exitPointerLock()")  # as Esc does
    host.wait_for_event("key_up", start, key="Escape")
    assert [event["key"] for event in host.events(start) if "key" in event] == ["Escape", "Escape"]
    page.mouse.move(20, 30)
    host.wait_for_event("pointer_move", start, x=20, y=30)


def test_full_screen_on_and_off(host, open_page):
    page = open_page(host.url)
    page.keyboard.press("u")
    wait_until(page, "Boolean(document.fullscreenElement)")
    page.wait_for_timeout(100)  # for the server to hear of it
    page.keyboard.press("u")
    wait_until(page, "!document.fullscreenElement")


def test_a_file_is_saved(host, open_page, tmp_path):
    page = open_page(host.url)
    with page.expect_download() as download:
        page.keyboard.press("p")
    assert download.value.suggested_filename == "picture.png"
    download.value.save_as(tmp_path / "saved")
    assert (tmp_path / "saved").read_bytes() == b"content of a file"


def test_help_lists_the_keys(host, open_page):
    page = open_page(host.url)
    assert "press H for help" in page.inner_text("#hint")
    assert not page.is_visible("#help")
    page.click("#help-button")
    page.wait_for_selector("#help dl")
    assert page.inner_text("#help").split("\n") == ["Move", "W ↑", "forward", "Picture", "H", "<b>this</b> help"]
    page.mouse.click(600, 50)
    assert not page.is_visible("#help")


def test_the_second_visitor_watches_until_the_first_has_gone(host, open_page):
    first = open_page(host.url)
    second = open_page(host.url, "watching", {"width": 300, "height": 400})
    start = len(host.said)
    second.keyboard.press("x")  # would end the server
    second.mouse.click(5, 5)
    first.keyboard.press("k")
    host.wait_for_event("key_up", start, key="k")
    assert [event["event_type"] for event in host.events(start)] == ["key_down", "key_up"]
    image = shot(second)  # the picture keeps its shape: 300×187.5, with bars
    lit = np.flatnonzero(image[:330, 150].max(axis=-1) > 60)
    assert (lit[0], lit[-1]) == (pytest.approx(106, abs=2), pytest.approx(293, abs=2))
    first.context.close()
    wait_for_status(second, "connected")
    host.wait_for_event("resize", start, width=300, height=400)
    second.keyboard.press("j")
    host.wait_for_event("key_down", start, key="j")


def test_reloading_connects_again(host, open_page):
    page = open_page(host.url)
    page.reload()
    wait_for_status(page, "connected")
    wait_for_picture(page)
    start = len(host.said)
    page.keyboard.press("w")
    host.wait_for_event("key_down", start, key="w")


def test_a_page_with_a_token_passes_it_on(open_page):
    with WebHost("--token", "secret & more") as host:
        page = open_page(host.url)
        wait_for_picture(page)
        page.click("#help-button")
        page.wait_for_selector("#help dl")


def test_the_page_waits_for_the_server_to_come_back(open_page):
    with WebHost() as host:
        page = open_page(host.url)
        image = wait_for_picture(page)
    wait_for_status(page, "reconnecting")
    assert np.abs(shot(page)[100:] - image[100:]).mean() < 3  # the last picture stays
    with WebHost("--port", host.port) as host:
        wait_for_status(page, "connected")
        page.keyboard.press("w")
        host.wait_for_event("key_down", key="w")
    assert all("WebSocket" in line for line in open_page.written)
    open_page.written.clear()


def test_nothing_is_drawn_for_a_tab_that_is_closed(open_page, capsys):
    with WebHost("--moving", "--size", "640x400") as host:
        page = open_page(host.url)
        wait_for_picture(page)
        before = host.ask()
        page.wait_for_timeout(2000)
        after = host.ask()
        with capsys.disabled():
            rate = (after["draws"] - before["draws"]) / (after["time"] - before["time"])
            print(f" {rate:.1f} frames/s of 640×400 ", end="")
        page.context.close()
        draws = host.wait_until_alone()
        time.sleep(0.3)
        assert host.ask()["draws"] == draws > before["draws"]


def test_the_pages_files_are_in_the_package():
    from importlib.resources import files
    page = files("glimt.viewer.web") / "page"
    assert {name.name for name in page.iterdir()} >= {"index.html", "page.css", "page.js", "input.js"}
    assert json.dumps((page / "index.html").read_text(encoding="utf-8")).count("$query") == 2
