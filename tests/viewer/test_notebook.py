"""The widget, in a kernel of its own; a page is played by hand."""

import base64
import contextlib
import io
import json
import os
import sys
from pathlib import Path

import nbformat
import numpy as np
import pytest
from nbclient import NotebookClient
from PIL import Image
from viewer_driver import make_scene

import glimt

HERE = Path(__file__).parent
VIEW_TYPE = "application/vnd.jupyter.widget-view+json"
IMPORTS = """
import asyncio, io, os, signal, sys, threading, time
import numpy as np
import glimt
from notebook_page import Page
from viewer_driver import make_scene
import glimt.viewer.viewer
glimt.viewer.viewer.MESSAGE_SECONDS = 0.2
"""


class Kernel:
    """Runs cells and returns their outputs."""

    def __init__(self, client):
        self._client = client

    def run(self, source):
        cell = nbformat.v4.new_code_cell(source)
        self._client.nb.cells.append(cell)
        self._client.execute_cell(cell, len(self._client.nb.cells) - 1)
        return cell.outputs


@contextlib.contextmanager
def started(folder):
    """Start a kernel in a folder, of this Python, whatever kernels are installed."""
    spec = folder / "share" / "kernels" / "own"
    spec.mkdir(parents=True)
    command = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
    (spec / "kernel.json").write_text(json.dumps({"argv": command, "display_name": "own", "language": "python"}))
    path = os.pathsep.join([str(HERE), *filter(None, [os.environ.get("PYTHONPATH")])])
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("JUPYTER_PATH", str(folder / "share"))
        patch.setenv("JUPYTER_RUNTIME_DIR", str(folder / "runtime"))
        patch.setenv("IPYTHONDIR", str(folder / "ipython"))
        patch.setenv("PYTHONPATH", path)
        client = NotebookClient(nbformat.v4.new_notebook(), timeout=60, kernel_name="own",
                                resources={"metadata": {"path": str(folder)}})
        with client.setup_kernel():
            kernel = Kernel(client)
            kernel.run(IMPORTS)
            yield kernel


@pytest.fixture(scope="module")
def kernel(tmp_path_factory):
    with started(tmp_path_factory.mktemp("kernel")) as kernel:
        yield kernel


def _printed(outputs, name="stdout"):
    return "".join(output.text for output in outputs if output.output_type == "stream" and output.name == name)


def _picture(data):
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(data["image/png"])), formats=["PNG"]))


def _expected():
    scene = make_scene()
    scene.settings.samples = 4
    return glimt.render(scene)


def test_a_cell_shows_a_widget_and_a_picture_for_pages_without(kernel):
    output, = kernel.run("widget = glimt.view(make_scene()); widget")
    assert output.data[VIEW_TYPE]["model_id"]
    assert np.array_equal(_picture(output.data), _expected())
    kernel.run("widget.close()")


def test_without_the_widgets_package_there_is_a_picture(tmp_path):
    with started(tmp_path) as kernel:
        output, = kernel.run("sys.modules['anywidget'] = None; glimt.view(make_scene())")
    assert VIEW_TYPE not in output.data
    assert np.array_equal(_picture(output.data), _expected())
    for kind in ("text/plain", "text/html"):
        assert "pip install 'glimt[notebook]'" in output.data[kind]


def test_in_a_thread_there_is_a_picture(kernel):
    output, = kernel.run("await asyncio.to_thread(glimt.view, make_scene())")
    assert VIEW_TYPE not in output.data
    assert np.array_equal(_picture(output.data), _expected())
    assert "not in a thread" in output.data["text/html"]


def test_frames_arrive_and_keys_change_them(kernel):
    kernel.run("""
widget = glimt.view(make_scene()); page = Page(widget)
page.show(96, 64)
await page.rest()
before = page.picture()
assert before.shape == (64, 96, 3)
assert (before[4:60, 70] == [0, 0, 0]).all(axis=1).sum() < 5 and np.ptp(before) > 100
count = len(page.frames)
page.key("b")
await page.rest()
assert len(page.frames) > count
assert widget.thread.viewer.scene.settings.max_bounces == 1
page.event("key_down", key="w", modifiers=[])
await page.until(lambda: widget.thread.viewer.pose.position[2] < 4.5)
page.event("key_up", key="w", modifiers=[])
await page.rest()
assert np.abs(page.picture().astype(int) - before).mean() > 3
widget.close()
""")


def test_the_picture_of_a_page_is_the_scene(kernel):
    kernel.run("""
widget = glimt.view(make_scene()); page = Page(widget)
widget.thread.viewer.overlay_level = 0
page.show(80, 60)
await page.rest()
scene = make_scene()
scene.settings.samples = 4
assert np.abs(page.picture().astype(int) - glimt.render(scene)).mean() < 1
widget.close()
""")


def test_twice_the_pixels_on_fine_screens(kernel):
    kernel.run("""
widget = glimt.view(make_scene()); page = Page(widget)
page.show(160, 120, ratio=2)
await page.rest()
assert page.picture().shape == (120, 160, 3)
assert widget.thread.viewer.pixel_ratio == 2
page.event("pointer_down", x=40, y=30, button=1, buttons=[1], modifiers=[])
page.event("pointer_up", x=22, y=30, button=1, buttons=[], modifiers=[])
await page.until(lambda: widget.thread.viewer.picked)
assert widget.thread.viewer.picked.object.name == "ball"
widget.close()
""")


def test_nothing_is_rendered_while_no_view_is_visible(kernel):
    kernel.run("""
widget = glimt.view(make_scene()); page = Page(widget)
await page.until(lambda: widget.thread.rendered)
await asyncio.sleep(0.3)
assert widget.thread.rendered == 1 and not page.frames
page.show()
await page.rest()
page.hide()
page.key("b")
await page.until(lambda: widget.thread.viewer.scene.settings.max_bounces == 1)
rendered, count = widget.thread.rendered, len(page.frames)
page.event("key_down", key="w", modifiers=[])
await asyncio.sleep(0.5)
assert widget.thread.rendered <= rendered + 1 and len(page.frames) == count
page.show()
await page.until(lambda: len(page.frames) > count + 2)
widget.close()
""")


def test_a_page_that_does_not_answer_is_sent_no_more_than_two_frames(kernel):
    kernel.run("""
widget = glimt.view(make_scene()); page = Page(widget, confirms=False)
page.show()
page.event("key_down", key="w", modifiers=[])
await page.until(lambda: len(page.frames) == 2)
await asyncio.sleep(0.3)
assert len(page.frames) == 2
page.confirm()
await page.until(lambda: len(page.frames) == 4)
widget.close()
""")


def test_a_page_that_is_loaded_again_sees_the_picture(kernel):
    kernel.run("""
widget = glimt.view(make_scene()); page = Page(widget, confirms=False)
page.show()
await page.until(lambda: len(page.frames) == 2)
page.hide()
page = Page(widget)
page.show()
await page.rest()
widget.close()

widget = glimt.view(make_scene()); page = Page(widget)
page.show()
await page.rest()
page.hide()
page = Page(widget)
page.show()
await page.until(lambda: page.frames)
widget.close()
""")


def test_not_more_frames_a_second_than_asked_for(kernel):
    kernel.run("""
widget = glimt.view(make_scene(), max_fps=5); page = Page(widget)
page.show()
page.event("key_down", key="w", modifiers=[])
start = time.perf_counter()
await page.until(lambda: len(page.frames) >= 4)
assert time.perf_counter() - start >= 3 / 5
widget.close()
""")


def test_memory_stays_the_same(kernel):
    growth, = _printed(kernel.run("""
import psutil
memory = lambda: psutil.Process().memory_info().rss / 1e6
widget = glimt.view(make_scene(), size=(320, 240)); page = Page(widget)
page.show(320, 240)
for i in range(500):
    if i == 100:
        before = memory()
    page.event("key_up" if i % 2 else "key_down", key="wasd"[i // 2 % 4], modifiers=[])
    page.event("pointer_move", x=i % 80, y=30, button=0, buttons=[1], modifiers=[])
    await asyncio.sleep(0.004)
print(memory() - before)
assert widget._rfb_frame_index > 50
widget.close()
""")).split()
    print("MB in 400 interactions:", growth)
    assert float(growth) < 5


def test_closed_widgets_leave_nothing_behind(kernel):
    kernel.run("""
import gc, weakref
left, threads = [], set(threading.enumerate())
for _ in range(3):
    widget = glimt.view(make_scene()); page = Page(widget)
    page.show()
    await page.until(lambda: page.frames)
    left += [weakref.ref(widget), weakref.ref(widget.thread.viewer)]
    thread = widget.thread
    widget.close()
    widget.close()
    assert not thread.running and thread.error is None
    del widget, page, thread
await asyncio.sleep(0.1)
gc.collect()
assert [reference() for reference in left] == [None] * 6
await Page.until(lambda: not [t for t in set(threading.enumerate()) - threads if t.name.startswith("glimt")])
""")


def test_a_closed_page_closes_the_widget(kernel):
    kernel.run("""
widget = glimt.view(make_scene()); page = Page(widget)
page.show()
await page.until(lambda: page.frames)
page.event("close")
assert widget.get_closed() and not widget.thread.running
page.key("b")
""")


def test_an_error_closes_the_widget_and_is_told_below_the_cell(kernel):
    outputs = kernel.run("""
widget = glimt.view(make_scene()); page = Page(widget)
page.show()
await page.rest()
widget.thread.viewer.frame = lambda now: 1 / 0
page.key("b")
await page.until(widget.get_closed)
assert not widget.thread.running and isinstance(widget.thread.error, ZeroDivisionError)
""")
    assert "ZeroDivisionError" in _printed(outputs, "stderr")
    assert "lambda now: 1 / 0" in _printed(outputs, "stderr")


def test_two_widgets_beside_one_another(kernel):
    kernel.run("""
widgets = [glimt.view(make_scene()), glimt.view(make_scene(max_bounces=2), size=(64, 64))]
pages = [Page(widget) for widget in widgets]
pages[0].show(80, 60); pages[1].show(64, 64)
for page in pages:
    await page.rest()
assert [page.picture().shape for page in pages] == [(60, 80, 3), (64, 64, 3)]
pages[1].key("b")
await pages[1].until(lambda: widgets[1].thread.viewer.scene.settings.max_bounces == 3)
assert widgets[0].thread.viewer.scene.settings.max_bounces == 0
widgets[0].close()
pages[1].key("b")
await pages[1].until(lambda: widgets[1].thread.viewer.scene.settings.max_bounces == 4)
await pages[1].rest()
widgets[1].close()
""")


def test_cells_run_while_a_frame_takes_its_time(kernel):
    kernel.run("""
widget = glimt.view(make_scene()); page = Page(widget)
page.show()
await page.rest()
frame, go_on, begun = widget.thread.viewer.frame, threading.Event(), threading.Event()
def slow(now):
    begun.set()
    assert go_on.wait(50)
    return frame(now)
widget.thread.viewer.frame = slow
page.key("b")
await page.until(begun.is_set)
count = len(page.frames)
""")
    assert _printed(kernel.run("print(begun.is_set(), go_on.is_set(), len(page.frames) - count)")) == "True False 0\n"
    kernel.run("""
go_on.set()
await page.until(lambda: len(page.frames) > count)
widget.close()
""")


def test_cells_can_be_interrupted_while_a_widget_lives(kernel):
    kernel.run("""
before = signal.getsignal(signal.SIGINT)
widget = glimt.view(make_scene()); page = Page(widget)
page.show()
await page.rest()
assert signal.getsignal(signal.SIGINT) is before
widget.close()
""")


def test_mouse_look_without_capture_and_no_full_screen(kernel):
    kernel.run("""
widget = glimt.view(make_scene()); page = Page(widget)
page.show()
page.key("F11")
page.key("m")
look = widget.thread.viewer.pose.look
for x in range(20, 60, 4):
    page.event("pointer_move", x=x, y=30, button=0, buttons=[], modifiers=[])
await page.until(lambda: widget.thread.viewer.pose.look != look)
page.key("Escape")
page.key("Escape")
await page.until(lambda: not widget.thread.viewer.mouse_look)
await page.rest()
assert widget.thread.error is None
widget.close()
""")


def test_pictures_are_saved_where_the_kernel_runs(kernel):
    kernel.run("""
widget = glimt.view(make_scene()); page = Page(widget)
page.show()
page.key("p")
await page.until(lambda: len([name for name in os.listdir() if name.startswith("two-")]) == 2)
widget.close()
""")


def test_a_cell_that_runs_again_closes_its_widgets(kernel):
    kernel.run("""
shell = get_ipython()
def cell(name, run):
    shell.get_parent = lambda: {"header": {"msg_id": run}, "metadata": {"cellId": name} if name else {}}
    return glimt.view(make_scene())
first, second, other, unknown = cell("a", "1"), cell("a", "1"), cell("b", "2"), cell(None, "3")
again = cell("a", "4")
assert [widget.get_closed() for widget in (first, second, other, unknown, again)] == [True, True, False, False, False]
del shell.get_parent
for widget in (other, unknown, again):
    widget.close()
""")
