#!/usr/bin/env python3
"""Measures whether the dimensions of Mitsuba 3's samplers are independent of each other.

Needs the Python package `mitsuba`, and LLVM: DRJIT_LIBLLVM_PATH names it where it is not found. From the root of the
repository:

    experiments/peers/samplers.py --record experiments/src/experiments/peers/samplers.json

An integral over two dimensions is biased if their numbers are correlated over pixels and seeds. For each sampler and
number of samples per pixel the pair of the first dimensions is kept whose correlation is largest in standard errors.
"""

import argparse
import itertools
import json
import pathlib

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")
mi.set_log_level(mi.LogLevel.Error)

SAMPLERS = ["independent", "stratified", "multijitter", "orthogonal", "ldsampler"]
# Squares, and squares of primes for `orthogonal`.
SAMPLES = {"orthogonal": [4, 25, 121, 289]}
DIMENSIONS = 12


def largest(kind, samples, numbers):
    """The pair of dimensions whose correlation is largest in standard errors over pixels."""
    sampler = mi.load_dict({"type": kind, "sample_count": samples})
    sampler.set_samples_per_wavefront(samples)
    pixels = numbers // samples
    sampler.seed(1, pixels * samples)
    # Uniform numbers have the variance 1/12.
    values = [12**0.5 * (np.array(sampler.next_1d(), dtype=np.float64) - 0.5) for _ in range(DIMENSIONS)]
    found = []
    for i, j in itertools.combinations(range(DIMENSIONS), 2):
        by_pixel = (values[i] * values[j]).reshape(pixels, samples).mean(1)
        error = by_pixel.std(ddof=1) / pixels**0.5
        found.append({"pair": [i, j], "correlation": float(by_pixel.mean()), "sigmas": float(by_pixel.mean() / error)})
    return {"sampler": kind, "samples": samples, "pixels": pixels, **max(found, key=lambda pair: abs(pair["sigmas"]))}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--numbers", type=int, default=4_000_000, help="of each dimension [4000000]")
    parser.add_argument("--record", type=pathlib.Path, help="a JSON file for what was found")
    options = parser.parse_args()
    found = []
    for kind in SAMPLERS:
        for samples in SAMPLES.get(kind, [4, 16, 64, 256]):
            found.append(largest(kind, samples, options.numbers))
            print(json.dumps(found[-1]), flush=True)
    if options.record:
        record = {"renderer": f"Mitsuba {mi.__version__}", "dimensions": DIMENSIONS, "found": found}
        options.record.write_text(json.dumps(record, indent=1) + "\n")


main()
