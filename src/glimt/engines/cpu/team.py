"""Threads that wait for jobs.

An executor of the standard library does the same. But a frame of a few milliseconds leaves nothing of Python in the
caches: what is done between two of them takes ten times as long as when it is repeated, and of futures, conditions and
work items there is much. Here a job costs an entry in a queue and one back.
"""

import contextlib
import threading
import weakref
from collections.abc import Callable
from queue import Empty, SimpleQueue


class Jobs:
    """Jobs that are under way together, and how they end.

    Attributes
    ----------
    given : int
        How many were given to threads.
    """

    def __init__(self) -> None:
        self.given = 0
        self._ended: list[BaseException | None] = []
        self._bell: SimpleQueue[None] = SimpleQueue()
        """Rings when one has ended. Ctrl-C may be faster than who hears it: what counts is the list."""

    def do(self, job: Callable[[], object]) -> None:
        """Do a job, in the thread that it was given to."""
        try:
            job()
        except BaseException as error:  # for those who wait
            self._ended.append(error)
        else:
            self._ended.append(None)
        self._bell.put(None)

    def have_ended(self, seconds: float) -> bool:
        """Return whether all have ended, after some seconds in which none has; one that failed raises its error."""
        with contextlib.suppress(Empty):
            while len(self._ended) < self.given:
                self._bell.get(timeout=seconds)
        for error in self._ended:
            if error:
                raise error
        return len(self._ended) == self.given

    def wait(self, seconds: float) -> None:
        """Wait until all have ended, failed or not; look every few seconds."""
        while len(self._ended) < self.given:
            with contextlib.suppress(Empty):
                self._bell.get(timeout=seconds)


_Inbox = SimpleQueue[tuple[Jobs, Callable[[], object]] | None]


class Team:
    """Threads that start when they are needed, and end with the team or with the program."""

    def __init__(self) -> None:
        self._inboxes: list[_Inbox] = []
        self._threads: list[threading.Thread] = []
        weakref.finalize(self, _dismiss, self._inboxes, self._threads)

    def give(self, number: int, jobs: Jobs, job: Callable[[], object]) -> None:
        """Have thread `number`, counted from 0, do one of some jobs after what it was given before."""
        while number >= len(self._inboxes):
            inbox: _Inbox = SimpleQueue()
            thread = threading.Thread(target=_work, args=(inbox,), name=f"glimt-{len(self._inboxes)}", daemon=True)
            thread.start()
            self._inboxes.append(inbox)
            self._threads.append(thread)
        self._inboxes[number].put((jobs, job))
        jobs.given += 1


def _work(inbox: _Inbox) -> None:
    while entry := inbox.get():
        jobs, job = entry
        jobs.do(job)
        del entry, jobs, job  # they hold a scene


def _dismiss(inboxes: list[_Inbox], threads: list[threading.Thread]) -> None:
    """Have threads end when they have done what they were given, and wait for that."""
    for inbox in inboxes:
        inbox.put(None)
    for thread in threads:
        if thread is not threading.current_thread():
            thread.join()
