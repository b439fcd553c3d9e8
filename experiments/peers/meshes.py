#!/usr/bin/env python3
"""Writes four scene files with large meshes, for `efficiency.py` and `images.py`: boulder, forest, lamps, facets.

    experiments/peers/meshes.py [--out out/meshes]

They need no packages, and each run writes the same files. Triangles: boulder 131 000, forest 1.1 million, lamps 36 000,
facets 20 000.
"""

import argparse
import pathlib
import random
from math import cos, pi, sin, sqrt


def unit(v):
    length = sqrt(sum(x * x for x in v))
    return tuple(x / length for x in v)


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


class Mesh:
    """Vertices and faces, counter-clockwise from outside, indices from 0."""

    def __init__(self):
        self.vertices, self.faces = [], []

    def add(self, vertices, faces):
        first = len(self.vertices)
        self.vertices += vertices
        self.faces += [tuple(first + i for i in face) for face in faces]

    def write(self, path):
        with path.open("w") as obj:
            for x, y, z in self.vertices:
                obj.write(f"v {x:.6f} {y:.6f} {z:.6f}\n")
            for face in self.faces:
                obj.write("f " + " ".join(str(i + 1) for i in face) + "\n")


def sphere(halvings):
    """A unit sphere of 8 * 4**halvings triangles: an octahedron, its edges halved."""
    vertices = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    for _ in range(halvings):
        middles, halved = {}, []

        def middle(a, b):
            edge = (min(a, b), max(a, b))
            if edge not in middles:
                middles[edge] = len(vertices)
                vertices.append(unit([x + y for x, y in zip(vertices[a], vertices[b])]))
            return middles[edge]

        for a, b, c in faces:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            halved += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        faces = halved
    return vertices, faces


def moved(vertices, scale, offset):
    return [tuple(scale * x + o for x, o in zip(v, offset)) for v in vertices]


def torus(major, minor, around, across, bump=0.0):
    """A torus about z, of quadrilaterals, whose tube is `bump` thicker or thinner in places."""
    vertices, faces = [], []
    for i in range(around):
        u = 2 * pi * i / around
        for j in range(across):
            v = 2 * pi * j / across
            r = minor * (1 + bump * sin(11 * u) * sin(7 * v))
            vertices.append(((major + r * cos(v)) * cos(u), (major + r * cos(v)) * sin(u), r * sin(v)))
            i1, j1 = (i + 1) % around, (j + 1) % across
            faces.append((i * across + j, i1 * across + j, i1 * across + j1, i * across + j1))
    return vertices, faces


def boulder():
    """A displaced sphere."""
    draw = random.Random(1)
    waves = [(unit([draw.gauss(0, 1) for _ in range(3)]), 2.2 * 1.35**k, draw.uniform(0, 2 * pi)) for k in range(14)]
    vertices, faces = sphere(7)

    def displaced(v):
        height = sum(sin(f * sum(a * b for a, b in zip(axis, v)) + phase) / f for axis, f, phase in waves)
        return tuple(x * (1 + 0.25 * height) for x in v)

    mesh = Mesh()
    mesh.add([displaced(v) for v in vertices], faces)
    return mesh


def forest():
    """Trees of single needles, 300 of them, above their stems."""
    draw, needles, stems = random.Random(2), Mesh(), Mesh()
    for _ in range(300):
        x, y, height = draw.uniform(-30, 30), draw.uniform(-30, 30), draw.uniform(4, 8)
        ring = [(0.1 * cos(2 * pi * k / 8), 0.1 * sin(2 * pi * k / 8)) for k in range(8)]
        stems.add([(x + a, y + b, 0) for a, b in ring] + [(x, y, 0.45)], [(k, (k + 1) % 8, 8) for k in range(8)])
        for _ in range(3600):
            level = sqrt(draw.uniform(0.04, 1))
            reach = 0.3 * height * level * sqrt(draw.random())
            turn = draw.uniform(0, 2 * pi)
            at = (x + reach * cos(turn), y + reach * sin(turn), height * (1 - 0.8 * level))
            along = unit([cos(turn) + draw.gauss(0, 0.5), sin(turn) + draw.gauss(0, 0.5), draw.gauss(-0.3, 0.4)])
            side = unit(cross(along, (draw.gauss(0, 1), draw.gauss(0, 1), 2)))
            tip = tuple(a + 0.3 * d for a, d in zip(at, along))
            ends = [tuple(a + s * 0.04 * d for a, d in zip(at, side)) for s in (-1, 1)]
            needles.add([*ends, tip], [(0, 1, 2)])
    return needles, stems


def lamps():
    """A floor full of tori, and 400 bulbs of 8 triangles each, in four colours, under the ceiling and among the tori."""
    draw, clutter = random.Random(3), Mesh()
    bulbs = [Mesh() for _ in range(4)]
    for _ in range(26):
        vertices, faces = torus(draw.uniform(0.25, 0.45), draw.uniform(0.06, 0.15), 32, 20)
        axis = unit([draw.gauss(0, 1) for _ in range(3)])
        side = unit(cross(axis, (1, 0, 0) if abs(axis[0]) < 0.8 else (0, 1, 0)))
        frame = side, cross(axis, side), axis
        centre = draw.uniform(-3.2, 3.2), draw.uniform(-3.2, 3.2), draw.uniform(0.65, 1.2)
        clutter.add([tuple(centre[k] + sum(v[i] * frame[i][k] for i in range(3)) for k in range(3)) for v in vertices], faces)
    vertices, faces = sphere(0)
    for k in range(400):
        where = draw.uniform(-3.8, 3.8), draw.uniform(-3.8, 3.8), draw.choice([3.7, draw.uniform(2, 3.5)])
        bulbs[k % 4].add(moved(vertices, 0.04, where), faces)
    return clutter, bulbs


def facets():
    """A glass ring with plane facets, closed."""
    mesh = Mesh()
    mesh.add(*torus(0.75, 0.33, 200, 50, 0.12))
    return mesh


ROOM = """
[[objects]]
shape = "mesh"
vertices = [[-{r}, -{r}, 0], [{r}, -{r}, 0], [{r}, {r}, 0], [-{r}, {r}, 0], [-{r}, -{r}, {h}], [{r}, -{r}, {h}], [{r}, {r}, {h}], [-{r}, {r}, {h}]]
[objects.faces]
floor = [[0, 1, 2, 3]]
wall = [[7, 6, 5, 4], [1, 5, 6, 2], [2, 6, 7, 3]]
red = [[3, 7, 4, 0]]
green = [[0, 4, 5, 1]]
"""
WALLS = """floor = { model = "lambert", albedo = [0.6, 0.55, 0.5] }
wall = { model = "lambert", albedo = [0.65, 0.65, 0.7] }
red = { model = "lambert", albedo = [0.6, 0.15, 0.1] }
green = { model = "lambert", albedo = [0.2, 0.5, 0.2] }
"""


def head(name, eye, target, fov, background=None):
    sky = "" if background is None else f"background = {background}\n"
    return (f'# Written by experiments/peers/meshes.py.\nname = "{name}"\n{sky}\n[camera]\neye = {list(eye)}\n'
            f"target = {list(target)}\nup = [0, 0, 1]\nfov_deg = {fov}\n\n[materials]\n")


def obj(name, material, *more):
    return "\n".join(['\n[[objects]]\nshape = "obj"', f'material = "{material}"', f'file = "{name}.obj"', *more, ""])


def lamp(corner, edges):
    return f'\n[[objects]] # faces down\nshape = "rectangle"\nmaterial = "lamp"\ncorner = {corner}\nedges = {edges}\n'


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/meshes"))
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)

    boulder().write(out / "boulder.obj")
    (out / "boulder.toml").write_text(
        head("boulder", (0, -3.8, 2.4), (0, 0, 1.4), 60) + WALLS
        + 'stone = { model = "lambert", albedo = [0.5, 0.45, 0.4] }\nlamp = { model = "lambert", albedo = 0.4, emission = [14, 13, 11] }\n'
        + ROOM.format(r=4, h=4) + obj("boulder", "stone", "translate = [0, 0.4, 1.4]")
        + lamp([-1, -1, 3.9], [[0, 2, 0], [2, 0, 0]]))

    needles, stems = forest()
    needles.write(out / "needles.obj")
    stems.write(out / "stems.obj")
    (out / "forest.toml").write_text(
        head("forest", (0, -36, 9), (0, 0, 2), 55, [0.5, 0.7, 1.0])
        + 'ground = { model = "lambert", albedo = [0.35, 0.25, 0.15] }\nneedle = { model = "lambert", albedo = [0.15, 0.4, 0.1] }\n'
        + 'stem = { model = "lambert", albedo = [0.3, 0.2, 0.12] }\nlamp = { model = "black", emission = [300, 270, 220] }\n'
        + obj("needles", "needle") + obj("stems", "stem")
        + '\n[[objects]]\nshape = "rectangle"\nmaterial = "ground"\ncorner = [-45, -45, 0]\nedges = [[90, 0, 0], [0, 90, 0]]\n'
        + '\n[[objects]]\nshape = "sphere"\nmaterial = "lamp"\ncentre = [-90, -60, 80]\nradius = 6\n')

    clutter, bulbs = lamps()
    clutter.write(out / "clutter.obj")
    colours = [[120, 90, 50], [110, 100, 90], [50, 80, 120], [120, 60, 40]]
    text = head("lamps", (0, -3.85, 2.3), (0, 0, 1.2), 75) + WALLS + 'plastic = { model = "lambert", albedo = [0.25, 0.35, 0.6] }\n'
    for k, (mesh, colour) in enumerate(zip(bulbs, colours)):
        mesh.write(out / f"bulbs-{k}.obj")
        text += f'bulb-{k} = {{ model = "lambert", albedo = 0.3, emission = {colour} }}\n'
    (out / "lamps.toml").write_text(
        text + ROOM.format(r=4, h=4) + obj("clutter", "plastic") + "".join(obj(f"bulbs-{k}", f"bulb-{k}") for k in range(4)))

    facets().write(out / "ring.obj")
    (out / "facets.toml").write_text(
        head("facets", (0, -3.2, 2.0), (0, 0, 0.8), 55) + WALLS
        + 'glass = { model = "glass", index = 1.5 }\nlamp = { model = "lambert", albedo = 0.4, emission = [9, 9, 10] }\n'
        + ROOM.format(r=3.5, h=4) + obj("ring", "glass", "rotate = { axis = [1, 0.2, 0], degrees = 55 }", "translate = [0, 0, 1.1]")
        + lamp([-1.2, -1.2, 3.9], [[0, 2.4, 0], [2.4, 0, 0]]))


main()
