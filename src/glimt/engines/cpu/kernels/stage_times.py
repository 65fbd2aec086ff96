"""How long the stages take: ticks of the processor's own clock, when a measurement wants them."""

from glimt.kernel import inline
from glimt.lanes import ticks
from glimt.layout import FIRST_STAGE, TIMES_STAGES


@inline
def tick(scene):
    """Return the time in ticks, 0 when stages are not timed: reading the clock costs as much as creating a few rays."""
    if scene.counters[TIMES_STAGES] == 0:
        return 0
    return ticks()


@inline
def lap(scene, stage, start):
    """Add the time since `start` to a stage; return the time now."""
    now = tick(scene)
    if now:
        scene.counters[FIRST_STAGE + stage] += now - start
    return now
