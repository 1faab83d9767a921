"""Measurement plans: places in the unit cube, line numbers and zero rows."""
import itertools

import numpy as np

PLANS = [
    "iso230",
    "lattice",
    "lattice_random",
    "diagonals",
    "circles",
    "lhs",
    "night",
    "hand",
    "random",
    "snake_zero",
]


def plan_points(rng, name, d, n):
    """Places (n,d) in -1 to 1, line numbers (n) and flags of zero rows (n)."""
    Z = []
    line = []
    zero = []
    lev = (
        int(max(3, min(9, round((n / rng.uniform(1, 3)) ** (1 / d)))))
        if d > 1
        else int(rng.integers(7, 26))
    )

    def grid():
        ax = np.linspace(-1, 1, lev)
        return np.array(list(itertools.product(*[ax] * d)))

    if name == "iso230":
        k = int(rng.integers(7, 15))
        run = 0
        t = np.linspace(-1, 1, k)
        keep = None
        while len(Z) < n:
            if d == 1:
                a = 0
                off = np.zeros(1)
            else:
                a = run // 2 % d
                off = rng.choice([-1, -0.5, 0, 0.5, 1], d)
                if run % 2 and Z:
                    off = keep
                keep = off
            for u in t if run % 2 == 0 else t[::-1]:
                p = off.copy().astype(float)
                p[a] = u
                Z.append(p)
                line.append(run)
            run += 1
    elif name in ("lattice", "lattice_random", "snake_zero"):
        run = 0
        while len(Z) < n:
            g = grid()
            if d > 1 and len(g) > n:
                g = g[rng.permutation(len(g))[:n]] if name == "lattice_random" else g
            if name == "lattice_random":
                g = g[rng.permutation(len(g))]
            if name == "snake_zero" and d > 1:
                g = g.reshape([lev] * d + [d]).copy()
                g = g.reshape(-1, lev, d)
                for k in range(1, len(g), 2):
                    g[k] = g[k][::-1].copy()
                g = g.reshape(-1, d)
            elif name == "snake_zero" and run % 2:
                g = g[::-1]
            for k, p in enumerate(g):
                if name == "snake_zero" and k % lev == 0:
                    Z.append(np.zeros(d))
                    line.append(run)
                    zero.append(len(Z) - 1)
                    run += 1
                Z.append(p)
                line.append(run)
            run += 1
    elif name == "diagonals":
        corners = [np.array(c) for c in itertools.product(*[[-1, 1]] * d) if c[0] == 1]
        dirs = corners + [np.eye(d)[i] for i in range(d)]
        for i, j in itertools.combinations(range(d), 2):
            for sgn in (1, -1):
                v = np.zeros(d)
                v[i] = 1
                v[j] = sgn
                dirs.append(v)
        run = 0
        k = int(rng.integers(5, 12))
        t = np.linspace(-1, 1, k)
        while len(Z) < n:
            v = dirs[run // 2 % len(dirs)]
            for u in t if run % 2 == 0 else t[::-1]:
                Z.append(v * u)
                line.append(run)
            run += 1
    elif name == "circles":
        run = 0
        while len(Z) < n:
            r = rng.choice([0.3, 0.6, 1.0])
            k = int(rng.integers(12, 37))
            ph = np.linspace(0, 2 * np.pi, k, endpoint=False) * rng.choice([1, -1])
            if d == 1:
                for u in ph:
                    Z.append(np.array([r * np.cos(u)]))
                    line.append(run)
            else:
                i, j = rng.permutation(d)[:2]
                off = rng.choice([-1, -0.5, 0, 0.5, 1.0], d)
                for u in ph:
                    p = off.copy()
                    p[i] = r * np.cos(u)
                    p[j] = r * np.sin(u)
                    Z.append(p)
                    line.append(run)
            run += 1
    elif name == "lhs":
        g = np.stack([(rng.permutation(n) + rng.random(n)) / n * 2 - 1 for _ in range(d)], 1)
        Z = list(g)
        line = [0] * n
    elif name == "night":
        k = int(
            {
                1: rng.integers(5, 12),
                2: rng.integers(14, 28),
                3: rng.integers(26, 60),
                6: rng.integers(60, 100),
            }[d]
        )
        pl = np.clip(rng.uniform(-1.1, 1.1, (k, d)), -1, 1)
        run = 0
        if d == 1:
            pl = np.linspace(-1, 1, k)[:, None]
        while len(Z) < n:
            for p in pl:
                Z.append(p)
                line.append(run)
            run += 1
    elif name == "hand":
        p = np.zeros(d)
        run = 0
        while len(Z) < n:
            c = rng.uniform(-1, 1, d)
            run += 1
            for _ in range(int(rng.integers(3, 15))):
                a = rng.integers(d)
                c = c.copy()
                c[a] = np.clip(np.round((c[a] + rng.normal(0, 0.4)) * 50) / 50, -1, 1)
                Z.append(c)
                line.append(run)
    else:
        Z = list(rng.uniform(-1, 1, (n, d)))
        line = [0] * n
    Z = np.array(Z[:n])
    line = np.array(line[:n])
    z = np.zeros(n, int)
    z[[k for k in zero if k < n]] = 1
    return Z, line, z
