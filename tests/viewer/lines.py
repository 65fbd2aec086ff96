"""What another process writes, line by line, with a limit on the wait."""

import queue
import threading


class Lines:
    """The lines of a stream, read by a thread of their own."""

    def __init__(self, stream):
        self._stream = stream
        self._lines = queue.SimpleQueue()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self._stream:
            self._lines.put(line)
        self._lines.put("")

    def next(self, timeout):
        """Return the next line; "" at the end, `queue.Empty` after some seconds without."""
        return self._lines.get(timeout=timeout)

    def join(self):
        """Wait for the end of the stream."""
        self._reader.join()
