"""A page that shows a notebook's widget, for tests in a kernel that has none."""

import asyncio
import io
import time

import numpy as np
from PIL import Image


class Page:
    """Takes what a widget sends, and answers as rendercanvas's JavaScript does.

    Attributes
    ----------
    frames : list of (number, bytes)
    """

    def __init__(self, widget, confirms=True):
        self.widget, self.confirms, self.frames = widget, confirms, []
        widget.send = self._take

    def show(self, width=80, height=60, ratio=1):
        """Make a view visible."""
        self.event("resize", width=width / ratio, height=height / ratio, pwidth=width, pheight=height, ratio=ratio)
        self.widget._has_visible_views = True

    def hide(self):
        """Scroll the view away."""
        self.widget._has_visible_views = False

    def event(self, event_type, **fields):
        """Send an event."""
        self.widget._rfb_handle_msg(self.widget, {"type": event_type, "timestamp": 0.0, **fields}, [])

    def key(self, key):
        """Press a key and let it go."""
        self.event("key_down", key=key, modifiers=[])
        self.event("key_up", key=key, modifiers=[])

    def confirm(self):
        """Tell that the frames have been shown."""
        now = time.time()
        self.widget._frame_feedback = {"index": self.frames[-1][0], "timestamp": now, "localtime": now}

    def picture(self):
        """Return the last frame, (h, w, 3) uint8."""
        return np.asarray(Image.open(io.BytesIO(self.frames[-1][1]), formats=["JPEG"]))

    @staticmethod
    async def until(condition, seconds=20.0):
        """Wait for something; frames come and go meanwhile."""
        end = time.perf_counter() + seconds
        while not condition():
            assert time.perf_counter() < end, "waited in vain"
            await asyncio.sleep(0.005)

    async def rest(self):
        """Wait until the widget has sent its best picture, and everything it said is gone."""
        thread = self.widget.thread
        await self.until(lambda: self.frames and thread.viewer.at_rest and thread._wanted)
        await asyncio.sleep(0.05)

    def _take(self, content, buffers=()):
        assert content["type"] == "framebufferdata"
        assert content["mimetype"] == "image/jpeg"
        self.frames = [*self.frames[-99:], (content["index"], bytes(buffers[0]))]
        if self.confirms:
            asyncio.get_running_loop().call_soon(self.confirm)
