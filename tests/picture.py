"""Renders the stone room and checks a scene against the oracle, in a process of its own: ``picture.py out.npz``."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

import oracle
import strategies
import tracing
from glimt import load
from glimt.debug_view import DEBUG_VIEWS
from glimt.lanes import LANES
from glimt.packed import pack
from glimt.renderer import Renderer
from glimt.scene.instance import Instance
from glimt.scene.scene import Scene
from glimt.scene.sphere import Sphere


def nasty_scene():
    """Every kind of mesh in every kind of place, and spheres."""
    random = np.random.default_rng(11)
    scene = Scene().add(Sphere((0, 1, 0), 0.5), Sphere((1, 0, -1), 1))
    for place in strategies.MATRICES.values():
        for make in strategies.MESHES.values():
            scene.add(Instance(strategies.mesh_of(make(random)), place(random)))
    return scene


def main(path):
    scene = nasty_scene()
    origins, directions = strategies.rays_for(scene, list(strategies.RAYS), 12, 600)
    packed, found = pack(scene), oracle.meetings(scene, origins, directions)
    wrong_hits = oracle.wrong_hits(found, tracing.closest(packed, origins, directions)).sum()
    wrong_shadows = oracle.wrong_answers(found, tracing.blocked(packed, origins, directions, 1.0), 1.0).sum()

    room = load(Path(__file__).resolve().parents[1] / "examples" / "stone_room.toml")
    room.settings = replace(room.settings, width=97, height=61, max_bounces=3)
    renderer = Renderer(room)
    debug = np.stack([renderer.render_debug(view).values for view in DEBUG_VIEWS])
    radiance = [Renderer(replace(room, settings=replace(room.settings, samples=samples))).render().radiance
                for samples in (1, 2, 3, 6, "adaptive")]
    np.savez(path, lanes=LANES, radiance=np.stack(radiance), debug=debug, wrong_hits=wrong_hits,
             wrong_shadows=wrong_shadows)


if __name__ == "__main__":
    main(sys.argv[1])
