"""Effects that no entry of the catalogue describes."""
import numpy as np

from motion import axis_dirs, moves

UNLISTED = [
    "cable_chain",
    "telegraph",
    "dirt",
    "beat",
    "chirp",
    "warm_backlash",
    "growing_wave",
    "doors",
    "lift_off",
    "two_parts",
    "wear_track",
    "neighbour_crane",
]


def unlisted(rng, S, kind):
    """Effect of size 1, v (n,d), of a kind of UNLISTED; side q (motors) or p (poses)."""
    r = S.robot
    d = r.d
    n = S.n
    t = S.t
    span = t[-1] - t[0]
    qs = np.einsum("nij,j->i", np.abs(S.J), S.sigma) / n
    j = int(rng.integers(d))
    i = int(rng.integers(d))
    V = np.zeros((n, d))
    side = "p"
    u = S.p0 / r.half
    tt = (t - t[0]) / span
    if kind == "cable_chain":
        # pushes by the way of the last six moves of another axis, saturating
        k = int(rng.integers(d))
        mv = moves(S)[:, k] / np.ptp(S.qc[:, k])
        g = np.convolve(mv * (np.abs(mv) > 0.05), [1, 0.9, 0.8, 0.7, 0.6, 0.5])[:n]
        V[:, i] = np.tanh(2 * g) * (u[:, k]) * qs[i]
        side = "q"
    elif kind == "telegraph":
        # a preload that flips between two seats, often
        s = 1.0
        g = []
        for k in range(n):
            if rng.random() < 14.0 / n:
                s = -s
            g.append(s)
        V[:, j] = np.array(g) * S.sigma[j]
    elif kind == "dirt":
        # speck of dirt on the scale
        c = rng.uniform(-0.6, 0.6)
        V[:, i] = np.exp(-0.5 * ((u[:, i % d] - c) / 0.05) ** 2) * qs[i]
        side = "q"
    elif kind == "beat":
        # vibration seen where the guide is soft: place times time
        V[:, j] = (
            np.sin(2 * np.pi * t / (span / rng.uniform(6, 15)) + 1)
            * np.cos(np.pi * u[:, j] * rng.uniform(1, 2))
            * S.sigma[j]
        )
    elif kind == "chirp":
        # a compressor that runs up
        V[:, j] = np.sin(2 * np.pi * (3 * tt + rng.uniform(8, 16) * tt**2)) * S.sigma[j]
    elif kind == "warm_backlash":
        # play that grows with the warmth of the screw, and closes when cold
        k = int(rng.integers(S.nparts))
        y = S.T[:, k]
        y = (y - y.mean()) / np.std(y)
        V[:, i] = axis_dirs(S)[:, i] * y * qs[i]
        side = "q"
    elif kind == "growing_wave":
        # a ball in the screw that breaks up
        y = S.qc[:, i]
        V[:, i] = (
            np.maximum(0, tt - 0.4)
            * np.sin(2 * np.pi * y / (np.ptp(y) / rng.uniform(3, 6)))
            * qs[i]
        )
        side = "q"
    elif kind == "doors":
        # gusts at unforeseen times, each fades in minutes
        g = np.zeros(n)
        for _ in range(int(rng.integers(8, 16))):
            t0 = rng.uniform(0, t[-1])
            g += (t > t0) * np.exp(-np.clip(t - t0, 0, None) / (span / 40)) * rng.choice([-1, 1])
        V[:, j] = g * S.sigma[j]
    elif kind == "lift_off":
        # a preload lifts off above one temperature
        k = int(rng.integers(S.nparts))
        y = S.T[:, k]
        c = np.quantile(y, rng.uniform(0.4, 0.7))
        V[:, :] = (np.maximum(0, y - c) / np.std(y))[:, None] * qs * rng.choice([-1, 1], d)
        side = "q"
    elif kind == "two_parts":
        # bimetal: product of two temperatures' differences
        k, l = rng.permutation(S.nparts)[:2]
        z = lambda y: (y - y.mean()) / np.std(y)
        V[:, :] = (z(S.T[:, k]) * z(S.T[:, l]))[:, None] * qs * rng.choice([-1, 1], d)
        side = "q"
    elif kind == "wear_track":
        # a rut: depends on the number of earlier visits near the place
        g = np.zeros(n)
        for k in range(1, n):
            g[k] = np.sum(np.exp(-0.5 * ((u[:k, i] - u[k, i]) / 0.12) ** 2))
        V[:, i] = g / g.max() * np.sin(4 * u[:, i]) * qs[i]
        side = "q"
    elif kind == "neighbour_crane":
        # a crane rolls by: the floor tilts along an unknown path
        w = np.interp(tt, np.linspace(0, 1, 13), rng.normal(0, 1, 13))
        V[:, j] = w * u[:, (j + 1) % d] * S.sigma[j] if d > 1 else w * u[:, 0] * S.sigma[j]
    return {
        "cause": "unlisted:" + kind,
        "side": side,
        "v": V,
        "subject": r.pose[j] if side == "p" else "q%d" % (i + 1),
    }
