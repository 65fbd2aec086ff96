"""A server for the tests: a moving picture, all events as lines of JSON on standard output."""

import argparse
import json
import sys
import threading
import time

import numpy as np

from glimt.viewer.web import server
from glimt.viewer.web.canvas import WebCanvas, loop

KEYS = [{"keys": ["W", "↑"], "help": "forward", "group": "Move"},
        {"keys": "H", "help": "<b>this</b> help", "group": "Picture"}]


def say(**what):
    print(json.dumps(what), flush=True)


def picture(width, height, step):
    """A gradient, below it a white bar that moves on by a pixel."""
    image = np.full((height, width, 4), 255, np.uint8)
    image[..., 0] = np.linspace(0, 255, width)
    image[..., 1] = np.linspace(0, 255, height)[:, None]
    image[..., 2] = 64
    image[-height // 10:, step % width:step % width + 8] = 255
    return image


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--port", type=int, default=0)
    parser.add_argument("--host", default="127.0.0.1")
    parser.add_argument("--token")
    parser.add_argument("--size", default="160x100", help="of the picture, or 'canvas'")
    parser.add_argument("--moving", action="store_true", help="without end; else only when something happens")
    parser.add_argument("--ping", type=float, help="seconds between pings, instead of the usual")
    options = parser.parse_args()
    if options.ping:
        server._PING = options.ping
    canvas = WebCanvas(title="glimt — <test & more>", keys=KEYS)
    context = canvas.get_bitmap_context()
    draws = 0

    def draw():
        nonlocal draws
        draws += 1
        width, height = canvas.get_physical_size() if options.size == "canvas" else map(int, options.size.split("x"))
        context.set_bitmap(picture(width, height, draws))
        if options.moving:
            canvas.request_draw()

    def handle(event):
        event = dict(event)
        say(**{key: value for key, value in event.items() if key not in ("time_stamp", "touches")})
        key = event.get("key") if event["event_type"] == "key_down" else None
        if key == "m":
            canvas.set_pointer_captured(True)
        elif key == "Escape":
            canvas.set_pointer_captured(False)
        elif key == "p":
            canvas.offer_file("picture.png", b"content of a file", "image/png")
        elif key == "u":
            canvas.set_fullscreen(not canvas.is_fullscreen)
        elif key == "x":
            canvas.close()
        if event["event_type"] in ("key_down", "pointer_move"):
            canvas.request_draw()

    def answer_questions():
        for line in sys.stdin:
            if line.strip() == "stop":
                canvas.stop()
            loop.call_soon_threadsafe(lambda: say(draws=draws, time=time.monotonic(), visitors=canvas.count_visitors()))

    canvas.add_event_handler(handle, "pointer_down", "pointer_up", "pointer_move", "pointer_enter", "pointer_leave",
                             "double_click", "wheel", "key_down", "key_up", "resize", "close")
    canvas.request_draw(draw)
    threading.Thread(target=answer_questions, daemon=True).start()
    server.serve(canvas, options.host, options.port, options.token, on_ready=lambda url: say(url=url))
    say(ended=True)


if __name__ == "__main__":
    main()
