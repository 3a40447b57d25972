#!/usr/bin/env python3
"""Reference vertex normals with 80 digits, for tests/it/vertex_normal.rs.

    python3 vertex_normals.py > vertex_normals.txt

Each line: kind, slope, three edge directions (exact doubles, cyclic; face i lies between edges i and i + 1),
three signs (-1 where the interior angle of the face is larger than 180 degrees), and the vector x with
x . N_i = 1 for the unit normals N_i = sign_i (e_i x e_(i+1)) / |e_i x e_(i+1)|.
Needs nothing but the standard library; `decimal` takes doubles exactly.
"""

import math
import random
from decimal import Decimal, getcontext

getcontext().prec = 80
REPEATS = 6
SLOPES = [10.0 ** -k for k in range(1, 13)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return sum((x * y for x, y in zip(a, b)), Decimal(0))


def reference(edges, signs):
    """Cramer's rule; 80 digits leave more than 40 at a slope of 1e-12."""
    exact = [[Decimal(x) for x in e] for e in edges]
    normals = []
    for i in range(3):
        n = cross(exact[i], exact[(i + 1) % 3])
        length = dot(n, n).sqrt() * signs[i]
        normals.append([x / length for x in n])
    volume = dot(normals[0], cross(normals[1], normals[2]))
    pairs = [cross(normals[1], normals[2]), cross(normals[2], normals[0]), cross(normals[0], normals[1])]
    return [sum((p[k] for p in pairs), Decimal(0)) / volume for k in range(3)]


def direction(degrees, rise, slope, rng):
    length = rng.uniform(0.5, 2.0)
    a = math.radians(degrees)
    return [length * math.cos(a), length * math.sin(a), length * slope * rise]


def spread(rng, width):
    return width * (2.0 * rng.random() - 1.0)


def vertex(kind, slope, rng):
    """Edges and signs of one vertex."""
    rise = [1.0 + spread(rng, 0.3) for _ in range(3)]
    signs = [1, 1, 1]
    if kind == "convex":
        at = [a + spread(rng, 20) for a in (0, 120, 240)]
        rise = [-r for r in rise]
    elif kind == "reflex":
        at = [a + spread(rng, 8) for a in (0, 60, 120)]
        rise = [-rise[0], 1.6 * rise[1], -rise[2]]
        signs = [1, 1, -1]
    elif kind == "right_angle":
        at = [0, 90, 225]
        rise = [-r for r in rise]
    elif kind in ("t", "t_saddle", "t_sharp"):
        # Two faces almost coplanar, as where bricks of a row meet along a parabolic curve.
        width = 0.05 if kind == "t_sharp" else 1.0
        at = [spread(rng, width), 90, 180 + spread(rng, width)]
        rise = [rise[0], -rise[1], rise[2]] if kind == "t_saddle" else [-r for r in rise]
        # The third face takes the rest of the circle.
        signs[2] = 1 if at[2] - at[0] > 180 else -1
    else:  # folded: the second and the third face lie under the first
        at = [a + spread(rng, 5) for a in (0, 70, 30)]
    return [direction(a, r, slope, rng) for a, r in zip(at, rise)], signs


def main():
    rng = random.Random(20)
    print("# kind slope e0 e1 e2 signs x; made by vertex_normals.py")
    for kind in ("convex", "reflex", "right_angle", "t", "t_sharp", "t_saddle", "folded"):
        for slope in SLOPES:
            for _ in range(REPEATS):
                edges, signs = vertex(kind, slope, rng)
                x = reference(edges, signs)
                numbers = [repr(c) for e in edges for c in e]
                print(kind, repr(slope), *numbers, *signs, *(format(c, ".25e") for c in x))


if __name__ == "__main__":
    main()
