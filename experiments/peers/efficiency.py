#!/usr/bin/env python3
"""Measures `render` beside Mitsuba 3, in turns on one machine: samples per second, and efficiency.

Needs the Python package `mitsuba` (pip install mitsuba), and LLVM for its fast variant: where it does not find one that
it can use, DRJIT_LIBLLVM_PATH names it (tried: Debian's libllvm19). From the root of the repository:

    experiments/peers/efficiency.py report diffuse-room cornell path/to/scene.toml

Scenes with large meshes are written by experiments/peers/meshes.py.

Every method renders each scene several times, with other random numbers, in as much CPU time as Mitsuba takes for its
samples. Efficiency is one over the variance of a pixel of such images, as a share of their squared mean, times the CPU
microseconds per pixel. Mitsuba's time is that of a call that renders, after one that has loaded and compiled; from the
time of `render` that of a tiny image is subtracted, which is the program's start, the scene's files and its hierarchy.
With --record FILE the numbers go into a JSON file: the experiment `mitsuba` takes them from
experiments/src/experiments/efficiency.json.
"""

import argparse
import json
import os
import pathlib
import resource
import statistics
import subprocess
import time

import drjit as dr
import mitsuba as mi
import numpy as np

WIDTH, HEIGHT = 256, 192
# Those of Mitsuba's samplers that are efficient: points that belong together, and independent numbers.
SAMPLERS = ["multijitter", "independent"]
# Options of `render`: its defaults, independent numbers, all points of a pixel in one scramble, which leaves no
# error bars, and Mitsuba's method with no more than it has; all of them in double and in single precision.
OURS = {"default": [], "independent": ["--sampler", "independent"], "one-scramble": ["--scrambles", "1"],
        "plain": ["--sampler", "independent", "--specular-nee", "no", "--silhouettes", "no"]}
OURS |= {f"single-{name}": [*options, "--precision", "single"] for name, options in OURS.items()}
# The room with what both renderers have.
OPTIONS = {"report": ["--diffuse", "lambert"]}


def of_exr(path):
    for name, part in mi.Bitmap(str(path)).split():
        if name.lower() in ("<root>", "mean", "radiance") and part.channel_count() >= 3:
            return np.array(part, dtype=np.float64)[:, :, :3]
    raise SystemExit(f"{path}: no layer of radiance")


class Mitsuba:
    """A sampler of Mitsuba's in a scene."""

    def __init__(self, folder, sampler, samples):
        exported = 'sampler type="independent"'
        text = (folder / "scene.xml").read_text()
        if exported not in text:
            raise SystemExit(f"{folder}/scene.xml has no {exported}")
        text = text.replace(exported, f'sampler type="{sampler}"')
        path = folder / f"scene-{sampler}.xml"
        path.write_text(text)
        self.scene, self.samples = mi.load_file(str(path)), samples
        self.image(0)

    def image(self, seed):
        wall, cpu = time.perf_counter(), time.process_time()
        image = mi.render(self.scene, spp=self.samples, seed=seed)
        dr.eval(image)
        dr.sync_thread()
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        return np.array(image, dtype=np.float64)[:, :, :3], wall, cpu


class Refused(Exception):
    """The scene is none for single precision, and why."""


class Ours:
    """`render` with options."""

    def __init__(self, folder, scene, options):
        self.folder, self.options, self.samples = folder, ["--scene", scene, "--convention", "physical", *options], 64
        starts = [self.render(0, (8, 6), 4)[1:] for _ in range(3)]
        self.start = [statistics.median(start[k] for start in starts) for k in (0, 1)]

    def image(self, seed):
        image, *times = self.render(seed, (WIDTH, HEIGHT), self.samples)
        return image, *(time - start for time, start in zip(times, self.start))

    def render(self, seed, size, samples):
        path = self.folder / "ours.exr"
        command = ["target/release/render", *self.options, "--size", f"{size[0]}x{size[1]}", "--spp", str(samples),
                   "--seed", str(seed + 1), "--out", str(path)]
        before, wall = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        done = subprocess.run(command, capture_output=True, text=True)
        message = done.stderr.strip()
        if done.returncode == 2 and "single precision" in message:
            raise Refused(message)
        if done.returncode != 0:
            raise SystemExit(f"{' '.join(command)}: {message}")
        wall, after = time.perf_counter() - wall, resource.getrusage(resource.RUSAGE_CHILDREN)
        return of_exr(path), wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    def take(self, cpu):
        """Sets the samples that take this CPU time, a multiple of 16."""
        self.samples = max(1, round(self.samples * cpu / self.image(0)[2] / 16)) * 16


def measured(images):
    """What is recorded of a method's images, each with its times and its number of samples."""
    values = np.stack([image for image, *_ in images])
    wall, cpu = (statistics.median(image[k] for image in images) for k in (1, 2))
    samples = images[0][3]
    variance = values.var(0, ddof=1).mean() / values.mean() ** 2
    return {"samples": samples, "rate": WIDTH * HEIGHT * samples / wall / 1e6, "cpu": cpu, "mean": values.mean(),
            "efficiency": WIDTH * HEIGHT / (variance * cpu * 1e6)}


def compare(scene, options):
    name = pathlib.Path(scene).stem
    folder = options.out / name
    added = OPTIONS.get(scene, []) + ([] if options.bounces is None else ["--bounces", str(options.bounces)])
    subprocess.run(["target/release/export", "--scene", scene, *added, "--to", "mitsuba", "--size",
                    f"{WIDTH}x{HEIGHT}", "--out", str(folder)], check=True)
    methods = {f"mitsuba-{sampler}": Mitsuba(folder, sampler, options.spp) for sampler in SAMPLERS}
    cpu = methods["mitsuba-" + SAMPLERS[0]].image(1)[2]
    for key, more in OURS.items():
        method = Ours(folder, scene, [*added, *more])
        try:
            method.take(cpu)
        except Refused as refused:
            print(f"{name} {key} is left out: {refused}", flush=True)
            continue
        methods[key] = method
    images = {key: [] for key in methods}
    for seed in range(2, 2 + options.images):
        for key, method in methods.items():
            images[key].append((*method.image(seed), method.samples))
    found = {key: measured(of_method) for key, of_method in images.items()}
    for key, of_method in found.items():
        print(name, key, ", ".join(f"{what} {value:.4g}" for what, value in of_method.items()), flush=True)
    return {"scene": name, "images": options.images, "methods": found}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--variant", default="llvm_ad_rgb", help="of Mitsuba, with RGB colours [llvm_ad_rgb]")
    parser.add_argument("--spp", type=int, default=256, help="samples per pixel of Mitsuba, a square [256]")
    parser.add_argument("--bounces", type=int, help="of paths at most, of both [no limit]")
    parser.add_argument("--images", type=int, default=8, help="of each method [8]")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/efficiency"))
    parser.add_argument("--record", type=pathlib.Path, help="a JSON file for what was measured")
    options = parser.parse_args()
    if options.record and options.bounces is not None:
        parser.error("--record is of paths without a limit: leave out --bounces")
    subprocess.run(["cargo", "build", "--release", "-p", "experiments", "--bins"], check=True)
    mi.set_variant(options.variant)
    scenes = [compare(scene, options) for scene in options.scenes]
    if options.record:
        record = {"renderer": f"Mitsuba {mi.__version__}, {options.variant}", "threads": os.cpu_count(),
                  "scenes": scenes}
        options.record.write_text(json.dumps(record, indent=1) + "\n")


main()
