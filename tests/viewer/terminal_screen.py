"""A terminal for tests: runs a program, answers what programs ask terminals, and knows what is on the screen."""

import codecs
import fcntl
import os
import re
import select
import signal
import struct
import subprocess
import termios
import threading
import time

import numpy as np

_TOKEN = re.compile(r"\x1b\[([?>=]?)([\d;:]*)\$?([@-~])|\x1b[P\]](?:[^\x07\x1b]|\x1b(?!\\))*(?:\x07|\x1b\\)|([^\x1b])",
                    re.DOTALL)
_BLACK = (0, 0, 0)


class Terminal:
    """Answers as xterm does, or as kitty, or not at all.

    Attributes
    ----------
    modes : set of str
        Private modes that are on, such as "1049" for the alternate screen; "25" is the cursor.
    lines : list of str
        What was printed outside of the alternate screen.
    """

    def __init__(self, command, environment, columns=80, rows=24, kind="xterm"):
        self.kind, self.modes, self.printed = kind, {"25"}, ""
        self._master, self._slave = os.openpty()
        self.resize(columns, rows)
        self.attributes_before = termios.tcgetattr(self._slave)
        self._place, self._colors = (0, 0), (_BLACK, _BLACK)
        self._rest, self._decoder = "", codecs.getincrementaldecoder("utf-8")()
        self._lock = threading.Lock()
        self._stop = False
        self.process = subprocess.Popen(command, stdin=self._slave, stdout=self._slave, stderr=self._slave,
                                        env=environment, start_new_session=True)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def resize(self, columns, rows):
        """Change the size of the window; the screen becomes empty."""
        self.columns, self.rows = columns, rows
        self._cells = {}
        fcntl.ioctl(self._master, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))

    def type(self, text):
        """Press keys, at once: the same key a second time within 0.1 s is a repetition."""
        os.write(self._master, text.encode())

    def press(self, key):
        """Press a key until it counts as released."""
        self.type(key)
        time.sleep(0.2)

    def wait_for(self, condition, seconds=30.0):
        """Wait until something is so."""
        end = time.perf_counter() + seconds
        while not condition():
            assert time.perf_counter() < end, f"waited in vain; the screen says\n{self.text()}\n{self.printed}"
            time.sleep(0.01)

    def text(self):
        """Return what is written on the screen; half blocks are spaces."""
        with self._lock:
            cells = dict(self._cells)
        return "\n".join("".join(cells.get((x, y), " ")[0].replace("▄", " ") for x in range(self.columns)).rstrip()
                         for y in range(self.rows))

    def picture(self):
        """Return the pixels of the half blocks, (2 rows, columns, 3) uint8; others are black."""
        with self._lock:
            cells = dict(self._cells)
        picture = np.zeros((self.rows, 2, self.columns, 3), np.uint8)
        for (x, y), (character, lower, upper) in cells.items():
            if character == "▄" and x < self.columns and y < self.rows:
                picture[y, :, x] = upper, lower
        return picture.reshape(-1, self.columns, 3)

    def end(self, seconds=20.0):
        """Wait for the end of the program and return its exit code."""
        code = self.process.wait(seconds)
        time.sleep(0.1)
        self._stop = True
        self._reader.join()
        return code

    def attributes(self):
        """Return the settings of the line, to compare with `attributes_before`."""
        return termios.tcgetattr(self._slave)

    def close(self):
        """End the program, if need be."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGKILL)
            self.process.wait()
        self._stop = True
        self._reader.join()
        os.close(self._master)
        os.close(self._slave)

    def _read(self):
        while not self._stop:
            if select.select([self._master], [], [], 0.05)[0]:
                self._rest += self._decoder.decode(os.read(self._master, 65536))
                self._take()

    def _take(self):
        place = 0
        with self._lock:
            while match := _TOKEN.match(self._rest, place):
                place = match.end()
                if match[4]:
                    self._write(match[4])
                elif match[3]:
                    self._obey(*match.group(1, 2, 3), match[0])
        self._rest = self._rest[place:]

    def _write(self, character):
        if "1049" not in self.modes:
            self.printed += character
        elif character >= " ":
            x, y = self._place
            self._cells[x, y] = character, *self._colors
            self._place = x + 1, y

    def _obey(self, mark, numbers, letter, whole):
        if mark == "?" and letter in "hl":
            (self.modes.update if letter == "h" else self.modes.difference_update)(numbers.split(";"))
        elif letter == "H":
            y, x = numbers.split(";")
            self._place = int(x) - 1, int(y) - 1
        elif letter == "m" and not mark:
            fore, back = self._colors
            if found := re.fullmatch(r"([34])8;2;(\d+);(\d+);(\d+)", numbers):
                color = tuple(map(int, found.groups()[1:]))
                self._colors = (color, back) if found[1] == "3" else (fore, color)
            else:
                self._colors = _BLACK, _BLACK
        elif self.kind != "silent":
            answer = {"\x1b[6n": "\x1b[1;1R", "\x1b[c": "\x1b[?62;22c", "\x1b[>q": "\x1bP>|XTerm(390)\x1b\\",
                      "\x1b[?u": "\x1b[?0u" if self.kind == "kitty" else ""}.get(whole, "")
            self.type(f"\x1b[?{numbers};2$y" if whole.endswith("$p") else answer)
