#!/usr/bin/env python3
"""Traces the rays of the benchmark `rays` by Embree and by our hierarchy, in one run on one thread.

Needs the Python package `embreex` (pip install embreex numpy). From the root of the repository:

    experiments/peers/rays.py

Both trace the same rays, one at a time: Embree in single precision, our hierarchy with hits in double precision. The time
that the package's own loop takes, measured in a scene without a hit, is taken off Embree's. With --record FILE the
numbers go into a JSON file: the experiment `mitsuba` takes them from experiments/src/experiments/embree.json.
"""

import argparse
import importlib.metadata
import json
import pathlib
import subprocess
import tempfile
import time

import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh

PASSES = 5


def numbers(path, *shape):
    return np.fromfile(path, "<f4").reshape(-1, *shape)


def built(triangles):
    """Returns a scene of triangles and the seconds that it took to build."""
    vertices = np.ascontiguousarray(triangles.reshape(-1, 3))
    faces = np.arange(len(vertices), dtype=np.int32).reshape(-1, 3)
    best = float("inf")
    for _ in range(3):
        scene = rtcore_scene.EmbreeScene()
        TriangleMesh(scene, vertices, faces)
        # A scene is built with its first ray; what the package copies before is not counted.
        start = time.perf_counter()
        scene.run(np.zeros((1, 3), "f4"), np.ones((1, 3), "f4"))
        best = min(best, time.perf_counter() - start)
    return scene, best


def traced(scene, rays, is_shadow):
    """Returns the hits of rays in a scene, and the seconds that they took."""
    origins, directions = (np.ascontiguousarray(rays[:, k]) for k in (0, 1))
    best, hits = float("inf"), 0
    for _ in range(PASSES):
        start = time.perf_counter()
        if is_shadow:
            found = scene.run(origins, directions, dists=np.ones(len(rays), "f4"), query="OCCLUDED")
        else:
            found = scene.run(origins, directions)
        best = min(best, time.perf_counter() - start)
        hits = int((np.asarray(found) >= 0).sum())
    return hits, best


def measured(folder, empty):
    """Returns a row for each mesh, of one run of each ray tracer."""
    bench = ["cargo", "bench", "-p", "experiments", "--bench", "rays", "--", "--out", folder]
    lines = subprocess.run(bench, check=True, capture_output=True, text=True).stdout.splitlines()
    rows = []
    for ours in map(json.loads, filter(None, lines)):
        path = folder / ours["mesh"]
        scene, seconds = built(numbers(path / "triangles.f32", 3, 3))
        row = {"mesh": ours["mesh"], "triangles": ours["triangles"],
               "build": {"ours": ours["build_seconds"], "theirs": seconds}, "kinds": []}
        for kind in ours["kinds"]:
            rays, is_shadow = numbers(path / f"{kind['name']}.f32", 2, 3), kind["name"] == "shadow"
            hits, theirs = traced(scene, rays, is_shadow)
            if abs(hits - kind["hits"]) > 1e-3 * len(rays):
                raise SystemExit(f"{ours['mesh']}, {kind['name']}: {kind['hits']} hits, Embree has {hits}")
            theirs -= traced(empty, rays, is_shadow)[1]
            row["kinds"].append({"name": kind["name"], "ours": kind["rate"], "theirs": len(rays) / theirs / 1e6})
        rows.append(row)
    return rows


def best(rounds):
    """Returns the least time of each measurement: other load on the machine only adds to it."""
    row = dict(rounds[0])
    row["build"] = {who: min(of["build"][who] for of in rounds) for who in ("ours", "theirs")}
    row["kinds"] = [{"name": kinds[0]["name"]} | {who: max(kind[who] for kind in kinds) for who in ("ours", "theirs")}
                    for kinds in zip(*(of["kinds"] for of in rounds))]
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--record", type=pathlib.Path, metavar="FILE", help="write the numbers as JSON")
    parser.add_argument("--rounds", type=int, default=3, metavar="N", help="runs of both in turn, the best of which count")
    options = parser.parse_args()
    empty, _ = built(np.array([[[1e6, 1e6, 1e6], [1e6 + 1, 1e6, 1e6], [1e6, 1e6 + 1, 1e6]]], "f4"))
    with tempfile.TemporaryDirectory() as folder:
        rounds = [measured(pathlib.Path(folder), empty) for _ in range(options.rounds)]
    rows = [best(row) for row in zip(*rounds)]
    for row in rows:
        ratios = "  ".join(f"{kind['name']} {kind['ours']:.2f}/{kind['theirs']:.2f}"
                           f" = {kind['ours'] / kind['theirs']:.2f}" for kind in row["kinds"])
        build = row["build"]
        print(f"{row['mesh']:16} {ratios}  build {build['ours'] / build['theirs']:.2f}")
    if options.record:
        version = importlib.metadata.version("embreex")
        text = json.dumps({"tracer": f"Embree by embreex {version}", "meshes": rows}, indent=1)
        options.record.write_text(text + "\n")


if __name__ == "__main__":
    main()
