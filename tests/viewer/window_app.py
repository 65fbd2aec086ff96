"""A window with a known picture that tells what happens, a line of JSON each, and does what its standard input says.

``window_app.py WIDTH HEIGHT PICTURE_WIDTH PICTURE_HEIGHT``; input is one expression a line, of `canvas` and `loop`.
"""

import json
import sys
import threading

import numpy as np

from glimt.viewer.window.canvas import WindowCanvas, loop


def picture_of(width, height):
    """Return the picture that the window shows."""
    picture = np.random.default_rng(7).integers(0, 256, (height, width, 4), np.uint8)
    picture[..., 3] = 255
    return picture


def _tell(event):
    print(json.dumps(event), flush=True)


def main(width, height, picture_width, picture_height):
    """Show the window until it is closed."""
    canvas = WindowCanvas(size=(width, height), title="glimt test", vsync=False)
    context = canvas.get_bitmap_context()
    picture = picture_of(picture_width, picture_height)

    def draw():
        context.set_bitmap(picture)
        _tell({"event_type": "draw"})

    def obey():
        for line in sys.stdin:
            loop.call_soon_threadsafe(lambda line=line: _tell({"event_type": "done", "value": eval(
                line, {"canvas": canvas, "loop": loop})}))

    canvas.add_event_handler(_tell, "*")
    canvas.request_draw(draw)
    threading.Thread(target=obey, daemon=True).start()
    loop.run()
    _tell({"event_type": "end"})


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
