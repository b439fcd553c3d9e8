#!/usr/bin/env python3
"""Writes the meshes of the scenes beside it: knot.obj, ball.obj, star.obj."""

from math import cos, pi, sin, sqrt


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(v):
    length = sqrt(sum(x * x for x in v))
    return [x / length for x in v]


def write(name, vertices, faces):
    with open(name, "w") as obj:
        for vertex in vertices:
            obj.write("v " + " ".join(f"{x:.6f}" for x in vertex) + "\n")
        for face in faces:
            obj.write("f " + " ".join(str(i + 1) for i in face) + "\n")


def knot(around=72, across=8):
    """A tube along a trefoil knot, of quadrilaterals."""
    vertices, faces = [], []
    for i in range(around):
        t = 2 * pi * i / around
        centre = [(2 + cos(3 * t)) * cos(2 * t), (2 + cos(3 * t)) * sin(2 * t), sin(3 * t)]
        ahead = unit([-3 * sin(3 * t) * cos(2 * t) - 2 * (2 + cos(3 * t)) * sin(2 * t),
                      -3 * sin(3 * t) * sin(2 * t) + 2 * (2 + cos(3 * t)) * cos(2 * t), 3 * cos(3 * t)])
        side = unit(cross(ahead, [0, 0, 1]))
        up = cross(side, ahead)
        for j in range(across):
            u, v = 0.45 * cos(2 * pi * j / across), 0.45 * sin(2 * pi * j / across)
            vertices.append([centre[k] + u * side[k] + v * up[k] for k in range(3)])
            a, b = i * across, (i + 1) % around * across
            k = (j + 1) % across
            faces.append([a + j, a + k, b + k, b + j])
    write("knot.obj", vertices, faces)


def ball(halvings=3):
    """A ball of triangles, from an octahedron by halving its edges."""
    vertices = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
    faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
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
            halved += [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        faces = halved
    write("ball.obj", vertices, faces)


def star(points=7):
    """A flat star to be seen from +z, of one triangle for each point and a polygon in the middle."""
    corners = [[r * cos(pi * i / points), r * sin(pi * i / points), 0] for i in range(2 * points) for r in [1 - 0.6 * (i % 2)]]
    inner = list(range(1, 2 * points, 2))
    tips = [[2 * i, 2 * i + 1, (2 * i - 1) % (2 * points)] for i in range(points)]
    write("star.obj", corners, tips + [inner])


knot()
ball()
star()
