#!/bin/sh
# The artefact's STL files: closed surfaces; a ball in the two sockets is 50 mm apart.
cd "$(dirname "$0")/../data/artefact" || exit 1
python3 - plate.stl adapter_*.stl <<'PY'
import collections, math, struct, sys

def triangles(path):
    data = open(path, "rb").read()
    for i in range(struct.unpack_from("<I", data, 80)[0]):
        v = struct.unpack_from("<12f", data, 84 + 50 * i)
        yield v[:3], (v[3:6], v[6:9], v[9:12])

def solve(rows):  # Cramer's rule
    det = lambda m: sum(m[0][i] * (m[1][(i + 1) % 3] * m[2][(i + 2) % 3] - m[1][(i + 2) % 3] * m[2][(i + 1) % 3]) for i in range(3))
    a = [r[:3] for r in rows]
    return [det([r[:k] + [rows[i][3]] + r[k + 1:] for i, r in enumerate(a)]) / det(a) for k in range(3)]

def check(name, good):
    print("ok" if good else "not ok", name)
    return good

good = True
for path in sys.argv[1:]:
    edges = collections.Counter(e for _, t in triangles(path) for e in zip(t, t[1:] + t[:1]))
    good &= check(path + " is closed", edges and all(edges[b, a] == n for (a, b), n in edges.items()))
centres = []
for socket in (0, 50):  # planes that touch the ball: n . x = n . corner + 10
    planes = {}
    for n, t in triangles("plate.stl"):
        if abs(n[2] - math.sqrt(0.5)) < 1e-4 and all(math.hypot(c[0] - socket, c[1]) < 12.1 for c in t):
            planes[round(math.atan2(n[1], n[0]), 2)] = [*n, sum(a * b for a, b in zip(n, t[0])) + 10]
    good &= check(f"socket {socket} has three faces at 45 degrees", len(planes) == 3)
    centres.append(solve(list(planes.values())))
good &= check("the balls are 50 mm apart", abs(math.dist(*centres) - 50) < 1e-3)
sys.exit(not good)
PY
