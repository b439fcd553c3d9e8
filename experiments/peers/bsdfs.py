#!/usr/bin/env python3
"""Samples Mitsuba 3's BSDFs and asks `judge --own-pdf` whether their directions follow the pdf that they report.

Needs the Python package `mitsuba`, and LLVM: DRJIT_LIBLLVM_PATH names it where it is not found. From the root of the
repository:

    experiments/peers/bsdfs.py --record experiments/src/experiments/peers/bsdfs.json

Beside the verdict it measures how far weights are from f cos/pdf, and the reported pdf of a sample from the function
`pdf`. Models with one direction in place of a density (a mirror, smooth glass) are compared with the laws of
reflection and refraction, and their share of reflected light with Fresnel's equations. Two wrong pdfs must be noticed.
"""

import argparse
import json
import math
import pathlib
import subprocess

import drjit as dr
import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")

GLASS = 1.5


def cases():
    """Name, model, angles of the outgoing direction in degrees (above 90: from inside)."""
    yield "diffuse", {"type": "diffuse", "reflectance": 0.5}, [30, 80]
    for law in ["ggx", "beckmann"]:
        for alpha in [0.05, 0.2, 0.5]:
            for visible in [True, False]:
                model = {"type": "roughconductor", "distribution": law, "alpha": alpha, "sample_visible": visible,
                         "material": "none"}
                name = f"rough conductor, {law}, {alpha}" + ("" if visible else ", all normals")
                yield name, model, [30, 80]
        for alpha in [0.1, 0.4]:
            model = {"type": "roughdielectric", "distribution": law, "alpha": alpha, "int_ior": GLASS, "ext_ior": 1.0}
            yield f"rough dielectric, {law}, {alpha}", model, [30, 80, 140]
            model = {"type": "roughplastic", "distribution": law, "alpha": alpha, "diffuse_reflectance": 0.5}
            yield f"rough plastic, {law}, {alpha}", model, [30, 80]
    for name, parameters in {
            "roughness 0.5": {}, "metallic": {"metallic": 1.0, "roughness": 0.3},
            "anisotropic metal": {"metallic": 1.0, "roughness": 0.4, "anisotropic": 0.8},
            "clearcoat": {"clearcoat": 1.0, "clearcoat_gloss": 0.6}, "sheen": {"sheen": 1.0, "flatness": 0.5},
            "specular transmission": {"spec_trans": 0.8, "roughness": 0.4, "eta": GLASS}}.items():
        model = {"type": "principled", "base_color": {"type": "rgb", "value": 0.5}, "roughness": 0.5} | parameters
        yield f"principled, {name}", model, [30, 80, *([140] if "spec_trans" in parameters else [])]


def outgoing(degrees):
    """A surface that is seen at this angle from its normal, above or below."""
    interaction = dr.zeros(mi.SurfaceInteraction3f)
    angle = math.radians(degrees)
    interaction.wi = mi.Vector3f(math.sin(angle), 0, math.cos(angle))
    interaction.sh_frame = mi.Frame3f(mi.Normal3f(0, 0, 1))
    interaction.n = mi.Normal3f(0, 0, 1)
    return interaction


def draw(model, degrees, count, generator):
    """Directions, weights, pdfs by `pdf`, and the largest relative differences of weight and reported pdf."""
    bsdf, interaction, context = mi.load_dict(model), outgoing(degrees), mi.BSDFContext()
    random = [mi.Float(generator.random(count, dtype=np.float32)) for _ in range(3)]
    sample, weight = bsdf.sample(context, interaction, random[0], mi.Point2f(*random[1:]))
    value = bsdf.eval(context, interaction, sample.wo)
    pdf = bsdf.pdf(context, interaction, sample.wo)
    array = lambda x: np.array(x, dtype=np.float64)
    directions, weight, value = (array(x).T for x in (sample.wo, weight, value))
    pdf, reported = array(pdf), array(sample.pdf)
    kept = (reported > 0) & (weight.max(1) > 0)
    # Median beside largest: single precision alone makes a few large.
    ratio = np.abs(weight[kept, 0] * pdf[kept] / np.maximum(value[kept, 0], 1e-300) - 1)
    reports = np.abs(reported[kept] / np.maximum(pdf[kept], 1e-300) - 1)
    directions[~kept] = 0
    pdf[~kept] = 0
    errors = {"weight": quantiles(ratio), "reported": quantiles(reports)}
    return directions, pdf, {"lost": float(1 - kept.mean()), "albedo": float(np.where(kept, weight[:, 0], 0).mean()), **errors}


def quantiles(values):
    """Median, 99.9 % and largest."""
    return [float(x) for x in np.quantile(values, [0.5, 0.999, 1])] if len(values) else [0.0] * 3


def judge(directions, pdf, options):
    path = options.out / "samples.npy"
    np.save(path, np.column_stack([directions, pdf]).astype(np.float32))
    command = [options.programs / "judge", "--samples", path, "--own-pdf", "--columns", "x,y,z,pdf", "--out", options.out]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode not in (0, 1, 2):
        raise SystemExit(done.stderr)
    return ["agree", "differ", "undecided"][done.returncode], done.stdout.splitlines()[0]


def smooth(generator, count):
    """Mirror and glass: largest error of the directions, and the share of reflected light against Fresnel's."""
    for degrees, relative in [(30, GLASS), (80, GLASS), (150, 1 / GLASS)]:
        bsdf = mi.load_dict({"type": "dielectric", "int_ior": GLASS, "ext_ior": 1.0})
        interaction = outgoing(degrees)
        random = [mi.Float(generator.random(count, dtype=np.float32)) for _ in range(3)]
        sample, _ = bsdf.sample(mi.BSDFContext(), interaction, random[0], mi.Point2f(*random[1:]))
        found = np.array(sample.wo, dtype=np.float64).T
        wo = np.array(interaction.wi, dtype=np.float64).reshape(3)
        side = math.copysign(1, wo[2])
        cos = abs(wo[2])
        sin = wo[0] / relative
        cos_t = math.sqrt(1 - sin * sin)
        reflected = np.array([-wo[0], 0, wo[2]])
        refracted = np.array([-sin, 0, -side * cos_t])
        is_reflected = found[:, 2] * side > 0
        error = np.abs(np.where(is_reflected[:, None], found - reflected, found - refracted)).max()
        s, p = (cos - relative * cos_t) / (cos + relative * cos_t), (relative * cos - cos_t) / (relative * cos + cos_t)
        share = 0.5 * (s * s + p * p)
        deviation = (is_reflected.mean() - share) / math.sqrt(share * (1 - share) / count)
        yield {"model": "dielectric", "degrees": degrees, "direction": float(error), "share": float(is_reflected.mean()),
               "fresnel": share, "sigmas": float(deviation)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=8_000_000)
    parser.add_argument("--only", default="", help="models whose name contains this")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/peers/bsdfs"))
    parser.add_argument("--programs", type=pathlib.Path, help="folder of ours [they are built in target/release]")
    parser.add_argument("--record", type=pathlib.Path, help="a JSON file for what was found")
    options = parser.parse_args()
    if options.programs is None:
        options.programs = pathlib.Path("target/release")
        subprocess.run(["cargo", "build", "--release", "-p", "experiments", "-p", "programs", "--bins"], check=True)
    options.out.mkdir(parents=True, exist_ok=True)
    generator = np.random.default_rng(1)
    found = []
    for name, model, angles in cases():
        if options.only not in name:
            continue
        for degrees in angles:
            directions, pdf, measured = draw(model, degrees, options.samples, generator)
            verdict, why = judge(directions, pdf, options)
            found.append({"model": name, "degrees": degrees, "verdict": verdict, "why": why, **measured})
            print(json.dumps(found[-1]), flush=True)
    wrong = []
    for name, model, factor in [("diffuse, pdf 8 % too high", {"type": "diffuse"}, 1.08),
                                ("rough conductor, pdf 8 % too low", {"type": "roughconductor", "alpha": 0.2}, 0.92)]:
        directions, pdf, _ = draw(model, 30, options.samples, generator)
        verdict, why = judge(directions, factor * pdf, options)
        wrong.append({"model": name, "degrees": 30, "verdict": verdict, "why": why})
        print(json.dumps(wrong[-1]), flush=True)
    (options.out / "samples.npy").unlink()
    of_smooth = list(smooth(generator, options.samples))
    print(json.dumps(of_smooth, indent=1))
    if options.record:
        record = {"renderer": f"Mitsuba {mi.__version__}", "samples": options.samples, "found": found, "wrong": wrong,
                  "smooth": of_smooth}
        options.record.write_text(json.dumps(record, indent=1) + "\n")


main()
