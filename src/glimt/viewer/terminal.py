"""The terminal: rendercanvas's, with the overlay as text and input of our own; to import it is to ask the terminal."""

import os
import signal
import time
from typing import Any

from glimt.errors import GlimtError
from glimt.viewer.overlay.text_overlay import TextOverlay, help_lines
from glimt.viewer.terminal_input import TerminalInput

os.environ.setdefault("BLESSED_QUERY_TIMEOUT_SECONDS", "1")  # it asks several times, and would wait for 5 s each

from rendercanvas.terminal import TerminalRenderCanvas, loop, resize_nearest, term

_PIXEL_RATIO = 1 / 8  # of pixels to logical ones: a character is one pixel wide and two high


class TerminalCanvas(TerminalRenderCanvas):  # type: ignore[misc]
    """A canvas of half blocks, two pixels a character.

    Of rendercanvas it has the drawing and the way into the full screen and back. Its input took two letters within
    0.1 s for one, so that the first was never released, and a mouse that moves for one that drags.
    """

    _term_size: tuple[int, int]  # columns and rows

    def __init__(self, overlay: TextOverlay, **options: Any) -> None:
        if term.number_of_colors < 8:
            raise GlimtError(f"the terminal shows no colours (TERM={os.environ.get('TERM', '')}); "
                             "use --web for a page in a browser")
        self._overlay = overlay
        self._input = TerminalInput(1 / _PIXEL_RATIO)
        self._lines: dict[int, str] = {}
        super().__init__(pixel_ratio=_PIXEL_RATIO, **options)

    def _rc_gui_poll(self) -> None:
        size = term.width, term.height
        if size != self._term_size:
            self._term_size = size
            self._size_info.set_physical_size(size[0], 2 * size[1], _PIXEL_RATIO)
            self.request_draw()
        now = time.perf_counter()
        while stroke := term.inkey(timeout=0):
            for event in self._input.events(stroke, now):
                self.submit_event(event)
                if event.get("key") in ("c", "C") and "Control" in event["modifiers"]:  # no signal in kitty's protocol
                    loop.stop()
        if not loop.is_kitty_keyboard:
            for event in self._input.released(now):
                self.submit_event(event)

    def _rc_present_bitmap(self, *, data: Any, format: str, **options: Any) -> None:
        """Draw; the base would take a picture for one of the terminal's size if only its width or height is right."""
        columns, rows = self._term_size
        if data.shape[:2] != (2 * rows, columns):
            data = resize_nearest(data, 2 * rows, columns)
        self._lines = self._text_lines(columns, rows)
        super()._rc_present_bitmap(data=data, format=format, **options)

    def _text_lines(self, columns: int, rows: int) -> dict[int, str]:
        """Return the lines of text that lie over the picture, by row."""
        text = self._overlay.text
        lower = [*([term.white_on_red(text.error[:columns].ljust(columns))] if text.error else []),
                 *(term.normal + line[:columns].ljust(columns) for line in text.notices)][-rows:]
        upper = help_lines(text.help, columns, rows - len(lower)) if text.help and len(lower) < rows else []
        return {**{row: term.normal + line for row, line in enumerate(upper)},
                **{rows - len(lower) + k: line for k, line in enumerate(lower)}}

    def _get_overlay(self, overlay_builder: Any, y: int, width: int) -> tuple[int, str] | None:
        del overlay_builder, width
        return (0, self._lines[y]) if y in self._lines else None


def run() -> None:
    """Fill the terminal until Ctrl-C or the signal TERM; then it is as it was."""
    before = signal.signal(signal.SIGTERM, lambda *_: loop.stop())
    try:
        loop.run()
    finally:
        signal.signal(signal.SIGTERM, before)
