"""A server with a moving picture in another process, as the tests see it."""

import json
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

SCRIPT = Path(__file__).with_name("moving_picture.py")
TIMEOUT = 20


class WebHost:
    """Runs `moving_picture.py`; `said` are the objects it has printed."""

    def __init__(self, *options):
        self.said = []
        self._news = threading.Condition()
        self.process = subprocess.Popen([sys.executable, "-W", "error", str(SCRIPT), *map(str, options)], text=True,
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        self.url = self.wait_for(lambda said: "url" in said)["url"]
        self.port = int(self.url.split(":")[2].split("/")[0])

    def _read(self):
        for line in self.process.stdout:
            with self._news:
                self.said.append(json.loads(line))
                self._news.notify_all()
        with self._news:
            self.said.append({"exit": True})
            self._news.notify_all()

    def wait_for(self, wanted, start=0):
        """Return the first object from number `start` on for which `wanted` is true; wait until there is one."""
        deadline = time.monotonic() + TIMEOUT
        with self._news:
            while True:
                for said in self.said[start:]:
                    if wanted(said):
                        return said
                if self.said[-1:] == [{"exit": True}]:
                    raise AssertionError(f"ended: {self.said[-5:]} {self.process.stderr.read()}")
                if not self._news.wait(deadline - time.monotonic()):
                    raise AssertionError(f"not said in {TIMEOUT} s; last was {self.said[-5:]}")

    def wait_for_event(self, event_type, start=0, **fields):
        fields = {"event_type": event_type, **fields}
        return self.wait_for(lambda said: fields.items() <= said.items(), start)

    def events(self, start=0):
        return [said for said in self.said[start:] if "event_type" in said]

    def ask(self, line="?"):
        """Return how many draws there were so far, and how many visitors there are."""
        start = len(self.said)
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        return self.wait_for(lambda said: "draws" in said, start)

    def wait_until_alone(self):
        """Wait until the server has no visitors; return the number of draws then."""
        deadline = time.monotonic() + TIMEOUT
        while (answer := self.ask())["visitors"]:
            assert time.monotonic() < deadline
            time.sleep(0.02)
        return answer["draws"]

    def end(self, number=signal.SIGINT):
        """Return the seconds it takes to end after a signal, its exit code and what it wrote on standard error."""
        start = time.monotonic()
        if self.process.poll() is None:
            self.process.send_signal(number)
        code = self.process.wait(TIMEOUT)
        seconds = time.monotonic() - start
        self._reader.join()
        errors = self.process.stderr.read()
        for stream in (self.process.stdin, self.process.stdout, self.process.stderr):
            stream.close()
        return seconds, code, errors

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if not self.process.stdout.closed:
            self.end()
