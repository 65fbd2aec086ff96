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
        all_have = self._listen(seconds)
        for error in self._ended:
            if error:
                raise error
        return all_have

    def wait(self, seconds: float) -> None:
        """Wait until all have ended, failed or not; look every few seconds."""
        while not self._listen(seconds):
            pass

    def _listen(self, seconds: float) -> bool:
        """Return whether all have ended, after some seconds in which none has."""
        with contextlib.suppress(Empty):
            while len(self._ended) < self.given:
                self._bell.get(timeout=seconds)
        return len(self._ended) == self.given


class _Worker(threading.Thread):
    """One of the threads."""

    def __init__(self, number: int) -> None:
        super().__init__(name=f"glimt-{number}", daemon=True)
        self.inbox: SimpleQueue[tuple[Jobs, Callable[[], object]] | None] = SimpleQueue()

    def run(self) -> None:
        while entry := self.inbox.get():
            jobs, job = entry
            jobs.do(job)
            del entry, jobs, job  # they hold a scene


class Team:
    """Threads that start when they are needed, and end with the team or with the program."""

    def __init__(self) -> None:
        self._workers: dict[int, _Worker] = {}
        weakref.finalize(self, _dismiss, self._workers)

    def give(self, number: int, jobs: Jobs, job: Callable[[], object]) -> None:
        """Have thread `number`, counted from 0, do one of some jobs after what it was given before."""
        worker = self._workers.get(number)
        if worker is None or not worker.is_alive():  # a forked process has no threads of its parent's
            worker = self._workers[number] = _Worker(number)
            worker.start()
        worker.inbox.put((jobs, job))
        jobs.given += 1


def _dismiss(workers: dict[int, _Worker]) -> None:
    """Have threads end when they have done what they were given, and wait for that."""
    for worker in workers.values():
        worker.inbox.put(None)
    for worker in workers.values():
        if worker is not threading.current_thread():
            worker.join()
