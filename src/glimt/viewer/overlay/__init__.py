"""What is drawn over the viewer's picture: numbers, the graph of frame times, notices, errors and the help."""

from glimt.viewer.overlay.frame_info import FrameInfo
from glimt.viewer.overlay.frame_times import FrameTimes
from glimt.viewer.overlay.overlay import Overlay

__all__ = ["FrameInfo", "FrameTimes", "Overlay"]
