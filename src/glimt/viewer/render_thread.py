"""The thread that makes the pictures, so that a window's or a server's thread never waits for one."""

import threading
import time
from collections import deque
from collections.abc import Callable

from glimt.viewer.keys import Event
from glimt.viewer.presenter import Picture
from glimt.viewer.viewer import Viewer

_MOST_EVENTS = 10_000
"""Events that may wait; beyond, the oldest are dropped: a flood must not fill the memory."""


class RenderThread:
    """Lets a viewer work: events go in from any thread, pictures come out.

    A picture is made while the one before is being shown, and none when `ahead` of them and one more wait to be taken:
    soon nothing is rendered for a window that is hidden or a browser that has gone.

    Parameters
    ----------
    viewer : Viewer
        Belongs to this thread once it runs.
    announce : function
        Is called, in this thread, when there is a new picture to take, and when the thread ends.
    ahead : int
        How many pictures may be made while the last one waits to be taken, 0 or 1. With 1 the newest is taken, and
        neither side waits for the other.
    """

    def __init__(self, viewer: Viewer, announce: Callable[[], None], ahead: int = 0) -> None:
        self.viewer = viewer
        self.rendered = 0
        self.taken = 0
        self.error: BaseException | None = None
        self._announce = announce
        self._events: deque[Event] = deque(maxlen=_MOST_EVENTS)
        self._picture: Picture | None = None
        self._untaken, self._ahead = 0, ahead
        self._stopping = self._ended = False
        self._condition = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="glimt-render", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def post(self, event: Event) -> None:
        """Hand over an event."""
        with self._condition:
            self._events.append(event)
            self._condition.notify()
        self.viewer.interrupt()

    def do(self, job: Callable[[], None]) -> None:
        """Have a job done between two pictures."""
        with self._condition:
            self.viewer.jobs.append(job)
            self._condition.notify()
        self.viewer.interrupt()

    def take(self) -> Picture | None:
        """Return the last picture and ask for the next; None before the first."""
        with self._condition:
            self.taken += self._untaken > 0
            self._untaken = 0
            self._condition.notify()
            return self._picture

    @property
    def running(self) -> bool:
        """Whether it has begun and will make pictures still; no longer when its end is announced."""
        return self._thread.is_alive() and not self._ended

    def stop(self) -> None:
        """End, in the middle of a picture if need be, and wait for the end."""
        with self._condition:
            self._stopping = True
            self._condition.notify()
        while self._thread.is_alive():
            self.viewer.interrupt()
            self.viewer.renderer.cancel()
            self._thread.join(0.05)

    def _run(self) -> None:
        try:
            while self._wait():
                self._work()
        except BaseException as error:
            if not self._stopping:
                self.error = error
        finally:
            self.viewer.presenter.close()
            self._ended = True
            self._announce()

    def _wanted(self) -> bool:
        """Return whether a picture may be begun."""
        return self._untaken <= self._ahead

    def _wait(self) -> bool:
        """Wait for something to do; return whether to go on."""
        with self._condition:
            while not (self._stopping or self._events or self.viewer.jobs):
                seconds = self.viewer.due(time.perf_counter()) if self._wanted() else None
                if seconds == 0.0:
                    break
                self._condition.wait(None if seconds is None or seconds == float("inf") else seconds)
            return not self._stopping

    def _work(self) -> None:
        viewer = self.viewer
        while self._events:
            viewer.handle(self._events.popleft(), time.perf_counter())
        viewer.do_jobs()
        if not self._wanted():
            return
        picture = viewer.frame(time.perf_counter())
        if picture is None:
            return
        with self._condition:
            self._picture = picture
            self._untaken += 1
            self.rendered += 1
        self._announce()
