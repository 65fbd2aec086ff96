"""`glimt view`, which answers questions: ``view_app.py ARGUMENT...``, those of the command.

A line on standard input is an expression of `app` and `viewer`; its value comes back as a line of JSON.
"""

import dataclasses
import json
import math
import os
import sys
import threading
import time
from collections import deque

from glimt import GlimtError, cli
from glimt.viewer import session
from glimt.viewer import viewer as viewer_module
from glimt.viewer.controls import Controls
from glimt.viewer.motion import Motion
from glimt.viewer.window.gl_window import glfw

REST_SECONDS = viewer_module.REST_SECONDS


class App:
    """What is known of a running viewer."""

    def __init__(self):
        self.ready = threading.Event()
        self.viewer = self.thread = self.canvas = None
        self.presented = deque(maxlen=5000)
        self._begun, self._made, self._shown = 0, {}, (0, None, 0.0)

    def connect(self, canvas, viewer, **options):
        """Do what `canvas.connect` does, and keep who is connected."""
        self.canvas, self.viewer = canvas, viewer
        self._first = dataclasses.replace(viewer.scene, lights=list(viewer.scene.lights),
                                          settings=dataclasses.replace(viewer.scene.settings))
        self._speed = viewer.motion.speed
        self._frame, viewer.frame = viewer.frame, self._make_frame
        self._paint, canvas._paint = canvas._paint, self._show_frame
        self.thread = _connect(canvas, viewer, **options)
        self._take, self.thread.take = self.thread.take, self._take_frame
        self.ready.set()
        return self.thread

    def _make_frame(self, now):
        self._begun += 1
        picture = self._frame(now)
        if picture is None:
            self._begun -= 1
        else:
            self._made[id(picture)] = self._begun, self.viewer.pose.position, self.viewer.pose.fov_deg
        return picture

    def _take_frame(self):
        picture = self._take()
        if picture is not None:
            self._shown = self._made[id(picture)]
        return picture

    def _show_frame(self):
        self._paint()
        if self.canvas._window:
            glfw.get_window_pos(self.canvas._window)  # is answered when the server has done all that came before
        self.presented.append((time.perf_counter(), *self._shown))

    def frames_since(self, start):
        """Return when pictures came to the screen, their numbers, and where they were taken from."""
        return [frame for frame in self.presented.copy() if frame[0] >= start]

    def state(self):
        """Return all that a key could change."""
        viewer, thread, picked = self.viewer, self.thread, self.viewer.picked
        pose, size = viewer.pose, viewer.size
        on_screen = bool(self.presented) and self.presented[-1][1] == self._begun
        return {
            "position": pose.position, "right": pose.right, "up": pose.up, "look": pose.look, "fov": pose.fov_deg,
            "target": viewer.motion.target, "speed": viewer.motion.speed, "moving": viewer.motion.moving,
            "lights": [getattr(light, "position", None) for light in viewer.scene.lights],
            "bounces": viewer.scene.settings.max_bounces, "samples": viewer.samples, "time": viewer.time,
            "time_runs": viewer.time_runs, "paused": viewer.paused, "mouse_look": viewer.mouse_look,
            "fullscreen": viewer.host.is_fullscreen, "help_shown": viewer.help_shown,
            "overlay_level": viewer.overlay_level,
            "debug_view": viewer.debug_view, "saving_view": viewer.saving_view, "saved": sorted(viewer.saved),
            "picked": picked and (picked.object.name, picked.material.name, picked.triangle),
            "message": viewer.message, "error": viewer.error, "size": size, "rendered_size": viewer.rendered_size,
            "film_samples": viewer.film_samples, "rendered": thread.rendered, "taken": thread.taken,
            "shown": self._shown[0], "p50": viewer.times.percentile(50), "p95": viewer.times.percentile(95),
            # as good as it gets; a message may yet go
            "at_rest": viewer.due(time.perf_counter()) > REST_SECONDS and on_screen,
        }

    def hurry(self):
        """Refine the picture almost at once."""
        viewer_module.REST_SECONDS = REST_SECONDS / 10

    def reset(self):
        """Begin anew, with lights that stand still; mouse look and full screen are the test's to end."""
        done = threading.Event()

        def job():
            viewer, first = self.viewer, self._first
            viewer.scene.lights[:], viewer.scene.settings = first.lights, dataclasses.replace(first.settings)
            vars(viewer).update(
                controls=Controls(viewer), motion=Motion(self._speed),
                pose=viewer.first_pose, samples=first.settings.samples, time=0.0, time_runs=False, paused=False,
                help_shown=False, saving_view=False, debug_view=None, overlay_level=1, picked=None, message=None,
                _message_ends=math.inf, saved={})
            viewer.changed()
            done.set()

        self.thread.do(job)
        return done.wait(5)

    def fail_later(self, frames, error):
        """Have the viewer fail with an error after some frames more."""
        last = self.thread.rendered + frames

        def frame(now):
            if self.thread.rendered >= last:
                raise error
            return self._make_frame(now)

        self.viewer.frame = frame

    def answer(self):
        """Answer what standard input asks, in a thread of its own."""
        self.ready.wait()
        for line in sys.stdin:
            value = eval(line, {"app": self, "viewer": self.viewer, "GlimtError": GlimtError})
            print(json.dumps(value), file=_answers, flush=True)


_connect = session.connect
_answers = os.fdopen(os.dup(1), "w")

if __name__ == "__main__":
    app = App()
    session.connect = app.connect
    threading.Thread(target=app.answer, daemon=True).start()
    os.dup2(2, 1)  # standard output is for answers only
    cli.main()
