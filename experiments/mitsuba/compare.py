#!/usr/bin/env python3
"""Renders scenes by Mitsuba 3 and by `render`, and asks `compare` whether the images agree.

Needs the Python package `mitsuba` (pip install mitsuba). From the root of the repository:

    experiments/mitsuba/compare.py cornell diffuse-room path/to/scene.toml 'cornell*0.99'

In a scene NAME*0.99 Mitsuba's diffuse albedos are 1 % lower, which `compare` must notice. What it finds is printed for
each scene, and goes with --record FILE into a JSON file: the experiment `mitsuba` takes its numbers from
experiments/src/experiments/mitsuba.json.
"""

import argparse
import json
import pathlib
import re
import shutil
import subprocess

import mitsuba as mi


def run(*command, codes=(0,)):
    done = subprocess.run(command)
    if done.returncode not in codes:
        raise SystemExit(done.returncode)


def program(name, *options, codes=(0,)):
    run(f"target/release/{name}", *options, codes=codes)


def darker(xml, factor):
    """The scene with each diffuse albedo multiplied by a factor."""
    scaled = lambda found: found[1] + ", ".join(str(factor * float(x)) for x in found[2].split(", "))
    return re.sub(r'(name="reflectance" value=")([^"]*)', scaled, xml)


def compare(scene, options):
    name, _, factor = scene.partition("*")
    folder = options.out / re.sub(r"\W+", "-", f"{pathlib.Path(name).stem} {factor}").strip("-")
    shutil.rmtree(folder, ignore_errors=True)
    common = ["--scene", name, "--size", options.size, "--spp", str(options.spp)]
    if options.bounces is not None:
        common += ["--bounces", str(options.bounces)]
    program("export", *common, "--to", "mitsuba", "--out", str(folder))
    xml = folder / "scene.xml"
    if factor:
        xml.write_text(darker(xml.read_text(), float(factor)))
    loaded = mi.load_file(str(xml))
    for seed in range(options.seeds):
        mi.Bitmap(mi.render(loaded, seed=seed)).write(str(folder / f"mitsuba-{seed}.exr"))
        # Independent numbers and no help at outlines: the plainest path tracer that there is.
        program("render", *common, "--convention", "physical", "--sampler", "independent", "--silhouettes", "no",
                "--seed", str(seed + 1), "--out", str(folder / f"ours-{seed}.exr"))
    program("compare", "--a", str(folder / "ours-*.exr"), "--b", str(folder / "mitsuba-*.exr"),
            "--out", str(folder), codes=(0, 1, 2))
    found = json.loads((folder / "compare.json").read_text())
    # The image means by channel: the difference as a share of Mitsuba's, and the interval in which it lies.
    means = {mean["channel"]: [mean["difference"], *mean["interval"]] for mean in found["kinds"][0]["found"]}
    return {"scene": pathlib.Path(name).stem, "albedos": float(factor or 1), "size": options.size, "spp": options.spp,
            "images": options.seeds, "verdict": found["verdict"], "means": means}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--variant", default="scalar_rgb", help="of Mitsuba, with RGB colours [scalar_rgb]")
    parser.add_argument("--size", default="128x96")
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--bounces", type=int, help="of paths at most, of both [no limit]")
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/mitsuba"))
    parser.add_argument("--record", type=pathlib.Path, help="a JSON file for what was found; keeps other scenes")
    options = parser.parse_args()
    if options.record and options.bounces is not None:
        parser.error("--record is of paths without a limit: leave out --bounces")
    run("cargo", "build", "--release", "-p", "experiments", "--bins")
    mi.set_variant(options.variant)
    results = [compare(scene, options) for scene in options.scenes]
    if options.record:
        known = json.loads(options.record.read_text())["scenes"] if options.record.exists() else []
        again = [(result["scene"], result["albedos"]) for result in results]
        kept = [result for result in known if (result["scene"], result["albedos"]) not in again]
        record = {"renderer": f"Mitsuba {mi.__version__}, {options.variant}", "scenes": kept + results}
        options.record.write_text(json.dumps(record, indent=1) + "\n")


main()
