"""Serves a scene as `glimt view --web` does; a line "state" on stdin is answered by a line of JSON on stdout."""

import json
import os
import sys
import threading
from pathlib import Path

from glimt.io import load
from glimt.viewer import show
from glimt.viewer.session import Session


class WatchedSession(Session):
    """Keeps its viewer, for questions."""

    seen = None

    def viewer(self, host=None):
        """Return the viewer."""
        WatchedSession.seen = super().viewer(host)
        return WatchedSession.seen


def answer():
    """Answer questions until nobody asks any more."""
    for _ in sys.stdin:
        viewer = WatchedSession.seen
        state = {"position": viewer.pose.position, "look": viewer.pose.look, "lights": len(viewer.scene.lights),
                 "bounces": viewer.scene.settings.max_bounces, "size": viewer.size, "at_rest": viewer.at_rest,
                 "frame_ms": 1000 * viewer.times.percentile(50), "rendered_size": viewer.rendered_size,
                 "cpu_seconds": sum(os.times()[:2])}
        print(json.dumps(state), flush=True)


def main():
    """Serve sys.argv[1] at port sys.argv[2] (0: any)."""
    threading.Thread(target=answer, daemon=True).start()
    session = WatchedSession(load(sys.argv[1]), folder=Path(sys.argv[3]))
    show.in_browser(session, port=int(sys.argv[2]), on_ready=lambda url: print(url, flush=True))


if __name__ == "__main__":
    main()
