"""A keyboard whose keys go down at once and at a known time: X11's XTest extension, without a process for each key."""

import ctypes
import time


class Keyboard:
    """Presses keys on a display; names are X11's."""

    def __init__(self, display_name):
        self._x11, self._xtst = ctypes.CDLL("libX11.so.6"), ctypes.CDLL("libXtst.so.6")
        self._x11.XOpenDisplay.restype = ctypes.c_void_p
        self._x11.XStringToKeysym.restype = ctypes.c_ulong
        self._x11.XKeysymToKeycode.argtypes = ctypes.c_void_p, ctypes.c_ulong
        self._x11.XFlush.argtypes = self._x11.XCloseDisplay.argtypes = (ctypes.c_void_p,)
        self._xtst.XTestFakeKeyEvent.argtypes = ctypes.c_void_p, ctypes.c_uint, ctypes.c_int, ctypes.c_ulong
        self._display = self._x11.XOpenDisplay(display_name.encode())

    def send(self, name, goes_down):
        """Press or release a key; return the time just before, of `time.perf_counter`, which processes share."""
        code = self._x11.XKeysymToKeycode(self._display, self._x11.XStringToKeysym(name.encode()))
        now = time.perf_counter()
        self._xtst.XTestFakeKeyEvent(self._display, code & 0xFF, goes_down, 0)
        self._x11.XFlush(self._display)
        return now

    def close(self):
        """Leave the display."""
        self._x11.XCloseDisplay(self._display)
