"""rendercanvas's event loop on GLFW's own waiting: asleep while nothing happens, awake at once when something does."""

import atexit
import heapq
import itertools
import time
from collections import deque
from collections.abc import Callable

import glfw
from rendercanvas.base import BaseLoop

_REST = 0.1
"""Seconds that timers may be late at rest."""
_AWAKE = 0.3
"""Seconds without an event of a window or a callback of another thread until there is rest."""
_EARLY = 0.002
"""Seconds that a wait may end before its time with nothing having happened, where clocks are coarse."""

Callback = Callable[[], None]


class GlfwLoop(BaseLoop):  # type: ignore[misc]
    """Runs callbacks when their time comes or another thread asks, while events of windows arrive.

    rendercanvas looks for events and draws on a timer, 120 times a second say, whether there are any or not. So at
    rest timers wait for up to 0.1 s more, until something happens: an event of a window, `call_soon_threadsafe`, or
    `glfw.post_empty_event` from any thread. (On Windows a thread of rendercanvas's keeps the time: no rest there.)
    """

    def __init__(self) -> None:
        super().__init__()
        self._timers: list[tuple[float, int, Callback]] = []
        self._order = itertools.count()  # of timers for the same time
        self._soon: deque[Callback] = deque()  # any thread appends
        self._stopping = self._is_running = False

    def stop(self, *, force: bool = False) -> None:
        """Close all windows and end; with `force` at once."""
        if force or not self._is_running:
            super().stop(force=force)
        else:  # Ctrl-C comes anywhere, in the middle of painting a window that would be gone then
            self._rc_call_soon_threadsafe(super().stop)

    def _rc_init(self) -> None:
        self._stopping = False

    def _rc_run(self) -> None:
        self._is_running = True
        try:
            self._run()
        finally:
            self._is_running = False

    def _run(self) -> None:
        last_event = time.perf_counter()
        while not self._stopping:
            now = time.perf_counter()
            while self._timers and self._timers[0][0] <= now:
                self._soon.append(heapq.heappop(self._timers)[2])
            for _ in range(len(self._soon)):  # but not what those add: events have their turn first
                self._soon.popleft()()

            now = time.perf_counter()
            wait = 0.0 if self._soon else self._timers[0][0] - now if self._timers else _REST
            if wait > 0 and now - last_event > _AWAKE:
                wait = max(wait, _REST)
            if wait <= 0:
                glfw.poll_events()
            else:
                glfw.wait_events_timeout(wait)
                if time.perf_counter() < now + wait - _EARLY:
                    last_event = now

    def _rc_stop(self) -> None:
        self._stopping = True

    def _rc_call_later(self, delay: float, callback: Callback) -> None:
        if delay <= 0:
            self._soon.append(callback)
        else:
            heapq.heappush(self._timers, (time.perf_counter() + delay, next(self._order), callback))

    def _rc_call_soon_threadsafe(self, callback: Callback) -> None:
        self._soon.append(callback)
        glfw.post_empty_event()


loop = GlfwLoop()
atexit.register(loop.stop, force=True)  # Python complains of tasks that never started, where nobody ran the loop
