"""Rays a second of the GPU engine's traversal, as a share of those of a plain kernel on the same rays, in turns.

    GLIMT_GPU=software python tests/engines/gpu/plain_kernel.py ../shared/prototypes/gpu stanford-bunny.obj

The plain kernel is an experiment of ours: a binary tree with nodes of 64 bytes, one level, Möller and Trumbore's test.
Wants a C compiler for its tree builder. What counts is processor time, which on a software driver is the GPU's.
"""

import atexit
import importlib
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import glimt
from glimt.engines.gpu import shader, stages
from glimt.engines.gpu.commands import Commands
from glimt.engines.gpu.engine import GpuEngine
from glimt.engines.gpu.pace import Area
from glimt.layout import COUNTER, MISS, PATH, VIEW, dtype
from glimt.renderer import Renderer

SIDE = 512
CLOSEST = "let hit = closest_hit(path.origin, path.direction, path.t, &counts);"
ANY = """var hit = no_hit(path.t);
    if occluded(path.origin, path.direction, path.t, &counts) { hit.inst = 0u; }"""
"""What `intersect` asks of each path, and what it is to ask instead."""


def experiment(folder, bunny):
    """Return the modules (common, wg_bench) of the plain kernel, from a copy that has its tree builder and model."""
    copy = Path(tempfile.mkdtemp())
    atexit.register(shutil.rmtree, copy, ignore_errors=True)
    for name in ("common.py", "wg_bench.py", "bvh.c"):
        shutil.copy(folder / name, copy)
    (copy / "data").mkdir()
    shutil.copy(bunny, copy / "data" / "stanford-bunny.obj")
    subprocess.run(["cc", "-O3", "-shared", "-fPIC", "-o", copy / "libbvh.so", copy / "bvh.c", "-lm"], check=True)
    os.environ["RES"] = str(SIDE)
    sys.path.insert(0, str(copy))
    return importlib.import_module("common"), importlib.import_module("wg_bench")


def plain(engine, source, origins, directions, t_max, any_hit):
    """Return what runs the plain kernel once, in seconds of processor time, and what brings its hits."""
    count = len(origins)
    rays = np.zeros((count, 8), np.float32)
    rays[:, :3], rays[:, 4:7], rays[:, 7] = origins, directions, t_max
    given, taken = engine.buf(0, rays), engine.buf(16 * count)
    pipeline, group = engine.pipe(source, 64, 1, given, taken, ANY=any_hit)

    def run():
        engine.uni(count)
        start = time.process_time()
        engine.submit([(pipeline, group, -(-count // 64), 1)])
        engine.wait()
        return time.process_time() - start

    return run, lambda: engine.read(taken, np.dtype([("t", "f4"), ("u", "f4"), ("v", "f4"), ("id", "i4")]))


def ours(engine, stage, origins, directions, t_max):
    """Return the same of a stage of the engine."""
    count, device, buffers = len(origins), engine._device, engine._buffers
    paths = np.zeros(count, dtype(PATH))
    paths["origin"], paths["direction"], paths["t"] = origins, directions, min(t_max, 3e38)
    counters = np.zeros(stages.counter_words(0), np.uint32)
    counters[COUNTER.paths] = count

    def run():
        engine._tell(np.zeros(int(VIEW.words), np.float32), (count, 1), Area(0, 0, count, 1), 1, 0, capacity=count)
        buffers["paths"].upload(paths)
        buffers["counters"].upload(counters)
        engine._download.read(buffers["counters"], counters.copy())  # all is there
        engine._stages.bind(buffers)
        commands = Commands(device, engine._download)
        engine._stages.record(commands, stage, buffers, 0, count)
        start = time.process_time()
        commands.submit()
        device.gpu._poll_wait()
        return time.process_time() - start

    run()
    return run, lambda: engine._download.read(buffers["paths"], paths.copy())


def race(kind, theirs, own, count, rounds):
    """Print the share, by least times; return both."""
    times = np.array([(theirs[0](), own[0]()) for _ in range(rounds + 1)])[1:].min(0)
    found, wanted = own[1]()["inst"] != MISS, theirs[1]()["id"] >= 0
    print(f"{kind}: {count / times[1] / 1e6:.2f} Mrays/s, plain {count / times[0] / 1e6:.2f}: "
          f"{times[0] / times[1]:.2f} ({(found != wanted).sum()} of {count:,} rays differ)", flush=True)
    return times


def main(folder, bunny, rounds=21):
    """Print the shares of primary, shadow and mirror rays."""
    common, bench = experiment(Path(folder), Path(bunny))
    read = shader.kernel
    closest = read("intersect").text
    assert CLOSEST in closest
    occlusion = shader.Part("occlusion.wgsl", closest.replace(CLOSEST, ANY).replace("fn intersect(", "fn occlusion("))
    shader.kernel = lambda stem: occlusion if stem == "occlusion" else read(stem)
    stages.STEMS += ("occlusion",)
    stages.STAGES += ("occlusion",)
    stages._USES["occlusion"] = stages._USES["intersect"]

    triangles = common.scene("bunny")
    positions = triangles.reshape(-1, 3)
    scene = glimt.Scene().add(glimt.Mesh(positions, np.arange(len(positions)).reshape(-1, 3)))
    renderer, other = Renderer(scene, engine="gpu"), bench.Eng("bunny")
    renderer._upload(0.0)
    engine = renderer._engine
    assert isinstance(engine, GpuEngine)

    rays = [common.tiled(part.reshape(SIDE, SIDE, 3)).reshape(-1, 3) for part in common.primary("bunny")]
    primary = ours(engine, "intersect", *rays, 1e20)
    first = race("primary", plain(other, bench.GEN, *rays, 1e20, "false"), primary, len(rays[0]), rounds)
    hits = primary[1]()
    corners = triangles[hits["prim"].clip(0)]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    t = np.where(hits["inst"] != MISS, hits["t"], np.inf).astype(np.float32)
    _, points, to_light, mirrored = common.secondary(*rays, t, normals.astype(np.float32))
    second = race("shadow", plain(other, bench.GEN, points, to_light, 1.0, "true"),
                  ours(engine, "occlusion", points, to_light, 1.0), len(points), rounds)
    both = first + second
    print(f"primary and shadow: {both[0] / both[1]:.2f}")
    race("mirror", plain(other, bench.GEN, points, mirrored, 1e20, "false"),
         ours(engine, "intersect", points, mirrored, 1e20), len(points), rounds)


if __name__ == "__main__":
    main(*sys.argv[1:3], *map(int, sys.argv[3:]))
