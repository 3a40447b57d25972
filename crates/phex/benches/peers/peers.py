#!/usr/bin/env python3
"""Peers beside phex on the same meshes, in one run: processor seconds to each planarity, invalid faces, shortest edge.

    cargo build --release --example planarize
    pip install numpy scipy casadi mpfp          # what is missing is skipped
    python3 crates/phex/benches/peers/peers.py t500 t5k e500 e5k   # or any of t500 t5k t20k t100k e500 e5k e20k e100k

The meshes are walls of bricks: `t` on a torus (radii 3 and 1), rows along the long way; `e` on the egg-crate
z = 0.3 sin x + 0.2 sin y, where curvature across the rows changes sign. All start from the same bricks, whose faces are
bent. `scipy` minimises squared volumes of tetrahedra with a rising weight by least squares; `ceres` does the same with a plane
for each face (needs libceres-dev, libeigen3-dev and g++); `ipopt` takes planarity as an equation (casadi); `mpfp` is the package of
that name. All stay near surface and start with the same weights. Each runs alone, on one thread; phex does all of its work,
set-up included, within the seconds given.
"""
import argparse
import importlib
import json
import os
import re
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS"):
    os.environ[variable] = "1"
import numpy as np  # noqa: E402  (threads are read when it is loaded)

ROOT = Path(__file__).resolve().parents[4]
GOALS = (1e-3, 1e-6, 1e-9)
TORUS = {"t500": (32, 16), "t5k": (100, 50), "t20k": (200, 100), "t100k": (448, 224)}
CRATE = {"e500": 22, "e5k": 70, "e20k": 142, "e100k": 316}
HOLD = 0.1  # weight of the start over that of the surface


# --- meshes ---------------------------------------------------------------------------------------------------------
def torus_wall(columns, rows):
    u = np.arange(2 * columns) * np.pi / columns
    v = np.arange(rows) * 2 * np.pi / rows
    v, u = np.meshgrid(v, u, indexing="ij")
    ring = 3 + np.cos(v)
    points = np.stack([ring * np.cos(u), ring * np.sin(u), np.sin(v)], -1).reshape(-1, 3)
    line = 2 * columns
    at = lambda j, i: (j % rows) * line + i % line
    faces = [
        [at(j, i), at(j, i + 1), at(j, i + 2), at(j + 1, i + 2), at(j + 1, i + 1), at(j + 1, i)]
        for j in range(rows)
        for i in range(j % 2, line, 2)
    ]
    return points, np.array(faces)


def crate_wall(n):
    step = 2 * np.pi / n
    grid = [(i, j) for j in range(n + 1) for i in range(2 * n + 2)]
    at = lambda j, i: j * (2 * n + 2) + i
    faces = np.array([
        [at(j, i), at(j, i + 1), at(j, i + 2), at(j + 1, i + 2), at(j + 1, i + 1), at(j + 1, i)]
        for j in range(n)
        for i in range(j % 2, j % 2 + 2 * n, 2)
    ])
    used, faces = np.unique(faces, return_inverse=True)
    x, y = (np.array(grid)[used] * [step / 2, step]).T
    return np.stack([x, y, 0.3 * np.sin(x) + 0.2 * np.sin(y)], -1), faces.reshape(-1, 6)


def make(name):
    return torus_wall(*TORUS[name]) if name in TORUS else crate_wall(CRATE[name])


def write(path, points, faces):
    with open(path, "w") as out:
        out.writelines("v %.17g %.17g %.17g\n" % tuple(p) for p in points)
        out.writelines("f " + " ".join(str(v + 1) for v in f) + "\n" for f in faces)


def read(path):
    lines = [line.split() for line in open(path)]
    return np.array([l[1:4] for l in lines if l and l[0] == "v"], float)


# --- figures --------------------------------------------------------------------------------------------------------
def edges(points, faces):
    pairs = np.sort(np.stack([faces, np.roll(faces, -1, 1)], -1).reshape(-1, 2), 1)
    pairs = np.unique(pairs, axis=0)
    return np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)


def planarity(points, faces):
    """Largest distance of a corner to the least-squares plane of its face, in mean edges, and the faces drawn flat."""
    centred = points[faces] - points[faces].mean(1, keepdims=True)
    axes = np.linalg.eigh(np.einsum("fia,fib->fab", centred, centred))[1]
    flat = np.einsum("fia,fab->fib", centred, axes)
    return np.abs(flat[:, :, 0]).max() / edges(points, faces).mean(), flat[:, :, 1:]


def invalid(flat):
    """Number of hexagons of which two edges cross."""
    area = lambda a, b: a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    turn = lambda a, b, c: area(b - a, c - a)
    crossed = np.zeros(len(flat), bool)
    for i in range(6):
        for j in range(i + 2, 6 if i else 5):
            a, b, c, d = (flat[:, k % 6] for k in (i, i + 1, j, j + 1))
            crossed |= (turn(a, b, c) * turn(a, b, d) < 0) & (turn(c, d, a) * turn(c, d, b) < 0)
    return int(crossed.sum())


class Surface:
    def __init__(self, name):
        self.torus = name in TORUS

    def distance(self, p):
        if self.torus:
            return np.hypot(np.hypot(p[:, 0], p[:, 1]) - 3, p[:, 2]) - 1
        slope = np.sqrt(1 + 0.09 * np.cos(p[:, 0]) ** 2 + 0.04 * np.cos(p[:, 1]) ** 2)
        return (p[:, 2] - 0.3 * np.sin(p[:, 0]) - 0.2 * np.sin(p[:, 1])) / slope

    def normal(self, p):
        if self.torus:
            ring = np.hypot(p[:, 0], p[:, 1])
            n = np.stack([(1 - 3 / ring) * p[:, 0], (1 - 3 / ring) * p[:, 1], p[:, 2]], 1)
        else:
            n = np.stack([-0.3 * np.cos(p[:, 0]), -0.2 * np.cos(p[:, 1]), np.ones(len(p))], 1)
        return n / np.linalg.norm(n, axis=1, keepdims=True)


class Clock:
    """Processor seconds at which each planarity was first reached; measuring it does not count."""

    def __init__(self, faces):
        self.faces, self.reached, self.spent = faces, {}, 0.0
        self.started = self.now()

    @staticmethod
    def now():
        return resource.getrusage(resource.RUSAGE_SELF).ru_utime

    def look(self, points):
        here = self.now()
        size = planarity(points, self.faces)[0]
        for goal in GOALS:
            if size <= goal:
                self.reached.setdefault(goal, here - self.started - self.spent)
        self.spent += self.now() - here
        return size


# --- peers, each in a process of its own ----------------------------------------------------------------------------
def scipy_peer(points, faces, surface, clock):
    import scipy.optimize
    import scipy.sparse as sparse

    n, unit = len(points), edges(points, faces).mean()
    four = faces[:, [[0, 2, 4, 1], [0, 2, 4, 3], [0, 2, 4, 5]]].reshape(-1, 4)
    columns = (3 * four[:, :, None] + np.arange(3)).ravel()
    rows = np.repeat(np.arange(len(four)), 12)

    def sides(p):
        return p[four[:, 1]] - p[four[:, 0]], p[four[:, 2]] - p[four[:, 0]], p[four[:, 3]] - p[four[:, 0]]

    def volumes(p):
        a, b, c = sides(p)
        return np.einsum("ij,ij->i", np.cross(a, b), c) / unit**2

    def volume_rows(p):
        a, b, c = sides(p)
        ga, gb, gc = np.cross(b, c), np.cross(c, a), np.cross(a, b)
        entries = np.concatenate([-ga - gb - gc, ga, gb, gc], 1) / unit**2
        return sparse.csr_matrix((entries.ravel(), (rows, columns)), (len(four), 3 * n))

    def distance_rows(p):
        place = (np.repeat(np.arange(n), 3), np.arange(3 * n))
        return sparse.csr_matrix((surface.normal(p).ravel(), place), (n, 3 * n))

    x, weight = points.ravel(), 1.0
    for _ in range(6):
        def residual(x):
            p = x.reshape(-1, 3)
            return np.concatenate([surface.distance(p), HOLD * (x - points.ravel()), weight * volumes(p)])

        def jacobian(x):
            p = x.reshape(-1, 3)
            return sparse.vstack([distance_rows(p), HOLD * sparse.eye(3 * n), weight * volume_rows(p)]).tocsr()

        found = scipy.optimize.least_squares(
            residual, x, jac=jacobian, method="trf", tr_solver="lsmr", max_nfev=20, ftol=1e-9, xtol=1e-12, gtol=1e-12
        )
        x, weight = found.x, 10 * weight
        if clock.look(x.reshape(-1, 3)) < 1e-9:
            break
    return x.reshape(-1, 3)


def ipopt_peer(points, faces, surface, clock):
    import casadi as ca

    n = len(points)
    x = ca.MX.sym("x", 3, n)
    p, start = ca.SX.sym("p", 3), ca.SX.sym("s", 3)
    if surface.torus:
        ring = ca.sqrt(p[0] ** 2 + p[1] ** 2)
        distance = ca.sqrt((ring - 3) ** 2 + p[2] ** 2) - 1
    else:
        slope = ca.sqrt(1 + 0.09 * ca.cos(p[0]) ** 2 + 0.04 * ca.cos(p[1]) ** 2)
        distance = (p[2] - 0.3 * ca.sin(p[0]) - 0.2 * ca.sin(p[1])) / slope
    term = ca.Function("term", [p, start], [distance**2 + HOLD**2 * ca.sumsqr(p - start)]).map(n)
    corners = ca.SX.sym("c", 3, 6)
    side = lambda k: corners[:, k] - corners[:, 0]
    volume = lambda k: ca.dot(ca.cross(side(2), side(4)), side(k))
    unit = edges(points, faces).mean()
    bent = ca.vertcat(*[volume(k) for k in (1, 3, 5)]) / unit**3
    equations = ca.Function("bent", [corners], [bent]).map(len(faces))
    problem = {
        "x": ca.vec(x),
        "f": ca.sum2(term(x, points.T)),
        "g": ca.vec(equations(x[:, faces.reshape(-1).tolist()])),
    }
    quiet = {"ipopt.print_level": 0, "print_time": 0, "ipopt.tol": 1e-8, "ipopt.max_iter": 200}
    solution = ca.nlpsol("s", "ipopt", problem, quiet)(x0=points.ravel(), lbg=0, ubg=0)
    result = np.array(solution["x"]).reshape(-1, 3)
    clock.look(result)
    return result


def mpfp_peer(points, faces, _surface, clock):
    import mpfp

    settings = mpfp.MakePlanarSettings()
    settings.verbose = False
    result = mpfp.make_planar_faces(points.tolist(), [list(map(int, f)) for f in faces], [], settings)
    clock.look(np.array(result))
    return np.array(result)


INSIDE = {"scipy": scipy_peer, "ipopt": ipopt_peer, "mpfp": mpfp_peer}
NEEDS = {"scipy": "scipy.optimize", "ipopt": "casadi", "mpfp": "mpfp"}


def run_inside(peer, name, out):
    points, faces = make(name)
    importlib.import_module(NEEDS[peer])  # loading it does not count
    clock = Clock(faces)
    result = INSIDE[peer](points, faces, Surface(name), clock)
    write(out, result, faces)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(json.dumps({"reached": clock.reached, "rss_mb": memory}))


def run_phex(source, out, _name):
    binary = ROOT / "target" / "release" / "examples" / "planarize"
    line = json.loads(subprocess.check_output([binary, source, out], text=True))
    reached = {goal: line["user_s"] for goal in GOALS if line["planarity"] <= goal}
    return {"reached": reached, "rss_mb": line["rss_mb"], "note": f"{line['path']}, {line['factorisations']} factorisations"}


def run_ceres(source, out, name):
    binary = compiled_ceres()
    text = subprocess.check_output([binary, source, out, name[0]], text=True, stderr=subprocess.DEVNULL)
    line = json.loads(text)
    reached = {float(goal): seconds for goal, seconds in line["reached"].items()}
    return {"reached": reached, "rss_mb": line["rss_mb"]}


def compiled_ceres():
    binary, source = Path(tempfile.gettempdir()) / "phex-ceres-peer", Path(__file__).with_name("ceres_peer.cpp")
    if not binary.exists() or binary.stat().st_mtime < source.stat().st_mtime:
        flags = "-O3 -march=native -DNDEBUG -std=c++17 -I/usr/include/eigen3 -lceres -lglog".split()
        subprocess.run(["g++", source, "-o", binary, *flags], check=True, capture_output=True)
    return binary


def run(peer, name, folder, limit):
    source, out = folder / f"{name}.obj", folder / f"{name}-{peer}.obj"
    if peer == "phex":
        result = run_phex(source, out, name)
    elif peer == "ceres":
        result = run_ceres(source, out, name)
    else:
        command = [sys.executable, __file__, "--inside", peer, name, out]
        text = subprocess.run(command, text=True, capture_output=True, timeout=limit, check=True).stdout
        result = json.loads(text.strip().splitlines()[-1])
        result["reached"] = {float(goal): seconds for goal, seconds in result["reached"].items()}
    points, faces = read(out), make(name)[1]
    size, flat = planarity(points, faces)
    lengths = edges(points, faces)
    return result | {"planarity": size, "invalid": invalid(flat), "shortest": lengths.min() / lengths.mean()}


def row(peer, result, base):
    def cell(goal):
        seconds = result["reached"].get(goal)
        if seconds is None:
            return "not reached"
        ratio = "" if base.get(goal) is None or peer == "phex" else f" ({seconds / base[goal]:.1f})"
        return f"{seconds:.2f}{ratio}"

    cells = "".join(f"{cell(goal):>16}" for goal in GOALS)
    figures = f"{result['planarity']:>12.1e}{result['invalid']:>9}{result['shortest']:>10.3f}{result['rss_mb']:>8.0f}"
    return f"  {peer:<8}{cells}{figures}  {result.get('note', '')}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meshes", nargs="*", default=["t500", "t5k", "e500", "e5k"])
    parser.add_argument("--peers", default="scipy,ceres,ipopt,mpfp", help="which peers, by commas")
    parser.add_argument("--limit", type=float, default=600, help="seconds that a peer may take")
    parser.add_argument("--inside", nargs=3, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.inside:
        return run_inside(*options.inside)
    folder = Path(tempfile.mkdtemp())
    heads = "".join(f"{f'CPU s to {goal:g}':>16}" for goal in GOALS)
    print(f"  {'':<8}{heads}{'planarity':>12}{'invalid':>9}{'shortest':>10}{'MB':>8}   (ratio to phex)")
    for name in options.meshes:
        write(folder / f"{name}.obj", *make(name))
        print(f"{name}: {len(make(name)[1])} faces")
        base = {}
        for peer in ["phex", *filter(None, options.peers.split(","))]:
            try:
                result = run(peer, name, folder, options.limit)
            except (subprocess.SubprocessError, OSError) as error:
                reason = re.sub(r"\s+", " ", str(getattr(error, "stderr", "") or error))[-90:]
                print(f"  {peer:<8}  not run: {reason}")
                continue
            base = result["reached"] if peer == "phex" else base
            print(row(peer, result, base), flush=True)
    shutil.rmtree(folder)


if __name__ == "__main__":
    main()
