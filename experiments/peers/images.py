#!/usr/bin/env python3
"""Renders scenes by Mitsuba 3, by Blender's Cycles and by `render`, and asks `compare` whether the images agree.

Needs the Python packages `mitsuba` and `bpy` (for the Python that it names), and LLVM for Mitsuba's fast variant:
DRJIT_LIBLLVM_PATH names it where it is not found. From the root of the repository:

    experiments/peers/images.py cornell path/to/scene.toml --peers path,path-darker,cycles

Without scenes and peers all are compared. In `path-darker` Mitsuba's diffuse albedos are 1 % lower, which `compare`
must notice. What is found is printed for each scene, and goes with --record FILE into a JSON file, in which other
scenes and peers are kept: the experiment `peers` takes its numbers from experiments/src/experiments/peers/images.json.
"""

import argparse
import dataclasses
import json
import pathlib
import re
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).parent
DATA = "tests/library/data/scenes"
SCENES = ["cornell", "report", "diffuse-room", "furnace-box", "environment", "glass-cube", f"{DATA}/knot.toml",
          f"{DATA}/hollow.toml", f"{DATA}/glass-ball.toml", *sorted(str(path) for path in HERE.glob("scenes/*.toml"))]
# Scenes in which Mitsuba's samplers, few samples and darker albedos are tried.
DIFFUSE = ["cornell", "diffuse-room", "hollow"]
# The room with what all renderers have.
OPTIONS = {"report": ["--diffuse", "lambert"]}


@dataclasses.dataclass
class Peer:
    """A renderer with its options."""
    renderer: str
    # Of Mitsuba: the integrator and the sampler; of Cycles: the settings.
    integrator: str = "path"
    sampler: str = "independent"
    settings: str = "unbiased"
    filter: str = "box"
    # Factor of the diffuse albedos: 1, or another one that must be noticed.
    albedos: float = 1.0
    # Samples of an image, if not those of all, and how many times as many images.
    spp: int | None = None
    times: int = 1
    # Scenes, if not all.
    scenes: list | None = None


PEERS = {
    "path": Peer("mitsuba"),
    "path-darker": Peer("mitsuba", albedos=0.99, scenes=DIFFUSE),
    "path-gaussian": Peer("mitsuba", filter="gaussian", scenes=DIFFUSE),
    "ptracer": Peer("mitsuba", integrator="ptracer"),
    "cycles": Peer("cycles"),
    "cycles-default": Peer("cycles", settings="default"),
}
# Blender's limits of bounces alone, and its clamps alone.
for settings in ["bounces", "clamp"]:
    PEERS[f"cycles-{settings}"] = Peer("cycles", settings=settings, scenes=["report", "furnace-box", "bulbs", "corridor"])
for sampler in ["stratified", "multijitter", "orthogonal", "ldsampler"]:
    PEERS[sampler] = Peer("mitsuba", sampler=sampler, scenes=DIFFUSE)
for sampler in ["independent", "stratified", "multijitter", "orthogonal", "ldsampler"]:
    PEERS[f"{sampler}-4"] = Peer("mitsuba", sampler=sampler, spp=4, times=8, scenes=DIFFUSE)


def run(*command, codes=(0,), **more):
    done = subprocess.run([str(word) for word in command], **more)
    if done.returncode not in codes:
        raise SystemExit(done.returncode)
    return done


def name_of(scene):
    return pathlib.Path(scene).stem


def edited(xml, peer):
    """The exported scene with what the peer has otherwise."""
    xml = xml.replace('<integrator type="path">', f'<integrator type="{peer.integrator}">')
    xml = xml.replace('<sampler type="independent">', f'<sampler type="{peer.sampler}">')
    xml = xml.replace('<rfilter type="box"/>', f'<rfilter type="{peer.filter}"/>')
    scaled = lambda found: found[1] + ", ".join(str(peer.albedos * float(x)) for x in found[2].split(", "))
    return re.sub(r'(name="reflectance" value=")([^"]*)', scaled, xml)


def render_by_mitsuba(scene, out, peer, spp, images):
    import mitsuba as mi
    mi.set_variant("llvm_ad_rgb")
    mi.set_log_level(mi.LogLevel.Error)
    path = scene.with_name(f"{out.name}.xml")
    path.write_text(edited(scene.read_text(), peer))
    loaded = mi.load_file(str(path))
    for seed in range(images):
        mi.Bitmap(mi.render(loaded, spp=spp, seed=seed)).write(f"{out}-{seed}.exr")
    return f"Mitsuba {mi.__version__}"


def render_by_cycles(scene, out, peer, spp, images):
    done = run(sys.executable, HERE / "blender.py", scene, out, "--spp", spp, "--seeds", 1, images, "--settings",
               peer.settings, stdout=subprocess.PIPE, text=True)
    return done.stdout.splitlines()[-1]


def compare(scene, key, options):
    """Renders by a peer and compares with our images, which stand already."""
    peer, folder = PEERS[key], options.out / name_of(scene)
    spp, images = peer.spp or options.spp, peer.times * options.images
    by = {"mitsuba": render_by_mitsuba, "cycles": render_by_cycles}[peer.renderer]
    renderer = by(folder / "scene.xml", folder / key, peer, spp, images)
    run(options.programs / "compare", "--a", folder / "ours-*.exr", "--b", folder / f"{key}-[0-9]*.exr", "--out", folder / key,
        codes=(0, 1, 2))
    found = json.loads((folder / key / "compare.json").read_text())
    kinds = {kind["name"]: kind for kind in found["kinds"]}
    # Of each channel: our difference as a share of the peer's mean, and the interval in which it lies.
    means = {mean["channel"]: [mean["difference"], *mean["interval"]] for mean in kinds["image mean"]["found"]}
    numbers = {kind: [kinds[kind][count] for count in ("places", "judged", "differ")] for kind in ("region", "tile", "pixel")}
    return {"scene": name_of(scene), "peer": key, "renderer": renderer, "spp": spp, "images": images,
            "verdict": found["verdict"], "why": found["why"], "means": means, "smallest_bias": found["smallest_bias"], **numbers}


def render_ours(scene, options):
    folder = options.out / name_of(scene)
    shutil.rmtree(folder, ignore_errors=True)
    common = ["--scene", scene, "--size", options.size, *OPTIONS.get(scene, [])]
    run(options.programs / "export", *common, "--spp", options.spp, "--to", "mitsuba", "--out", folder)
    for seed in range(1, options.images + 1):
        run(options.programs / "render", *common, "--spp", options.spp, "--convention", "physical", "--seed", seed,
            "--out", folder / f"ours-{seed}.exr", capture_output=True)


def write(path, results, options):
    """Adds results to a record."""
    known = json.loads(path.read_text())["images"] if path.exists() else []
    again = [(result["scene"], result["peer"]) for result in results]
    kept = [result for result in known if (result["scene"], result["peer"]) not in again]
    path.write_text(json.dumps({"size": options.size, "images": kept + results}, indent=1) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--peers", default=",".join(PEERS), help="separated by commas [all]")
    parser.add_argument("--size", default="96x72")
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--images", type=int, default=8)
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/peers"))
    parser.add_argument("--programs", type=pathlib.Path, help="folder of ours [they are built in target/release]")
    parser.add_argument("--record", type=pathlib.Path, help="a JSON file for what was found")
    options = parser.parse_args()
    if options.programs is None:
        options.programs = pathlib.Path("target/release")
        run("cargo", "build", "--release", "-p", "experiments", "-p", "programs", "--bins")
    for scene in options.scenes or SCENES:
        render_ours(scene, options)
        for key in options.peers.split(","):
            if PEERS[key].scenes is not None and name_of(scene) not in PEERS[key].scenes:
                continue
            result = compare(scene, key, options)
            print(f"{result['scene']} {key}: {result['verdict']}, {result['means']}", flush=True)
            if options.record:
                write(options.record, [result], options)


main()
