"""Robots with exact kinematics: stages, flexures, deltas, hexapod and scara."""
import math

import numpy as np

ARC = math.pi / 180 / 3600  # one arcsec in rad
NM = 1e-6  # one nm in mm


class Robot:
    """Pose p (n,d) in mm and arcsec; ik(p): motors (n,d) in mm or deg. half (d): half strokes."""

    def jac(self, p):
        """Motors by poses (n,d,d), from central differences."""
        n, d = p.shape
        J = np.empty((n, d, d))
        for j in range(d):
            h = self.half[j] * 1e-4
            a = p.copy()
            a[:, j] += h
            b = p.copy()
            b[:, j] -= h
            J[:, :, j] = (self.ik(a) - self.ik(b)) / (2 * h)
        return J

    def fk(self, q, p0):
        """Poses (n,d) of motors q by Newton steps from p0."""
        p = p0.copy()
        for _ in range(12):
            e = self.ik(p) - q
            dp = np.linalg.solve(self.jac(p), e[..., None])[..., 0]
            p = p - dp
            if np.max(np.abs(dp) / self.half) < 1e-13:
                break
        return p


class Stage(Robot):
    kind = "stage"

    def __init__(self, rng, d):
        self.d = d
        self.name = {1: "linear", 2: "xy", 3: "xyz"}[d]
        top = {1: [1, 10, 50, 200, 1000], 2: [5, 50, 200], 3: [2, 25, 150, 500]}[d]
        stroke = float(rng.choice(top)) * rng.uniform(0.8, 1.2)
        self.half = np.array(
            [stroke / 2 * (1 if i == 0 else rng.uniform(0.6, 1.0)) for i in range(d)]
        )
        self.pose = ["x", "y", "z"][:d]
        self.punit = ["mm"] * d
        self.qunit = ["mm"] * d
        self.sq = rng.normal(0, 15 * ARC, (d, d))
        self.lin = rng.normal(0, 3e-6, d)
        self.rail = 2 * self.half * rng.uniform(2.2, 4.0, d)
        self.ph = rng.uniform(0, 2 * np.pi, (d, d, 2))
        # guide: bow and second harmonic of a rail two to four strokes long
        self.amp = (
            rng.normal(0, 1, (d, d, 2)) * (2e-6 * self.half)[None, :, None] * np.array([1, 0.3])
        )

    def ik(self, p):
        q = p * (1 + self.lin)
        for i in range(self.d):
            for j in range(self.d):
                if i != j and j > i:
                    q[:, i] = q[:, i] + self.sq[i, j] * p[:, j]
                for k in range(2):
                    q[:, i] = q[:, i] + self.amp[i, j, k] * np.sin(
                        2 * np.pi * (k + 1) * p[:, j] / self.rail[j] / 2 + self.ph[i, j, k]
                    )
        return q


class Flexure(Robot):
    kind = "flexure"

    def __init__(self, rng, d=2):
        self.d = d
        self.name = "flexure%d" % d
        stroke = float(rng.choice([1, 2, 5])) * rng.uniform(0.8, 1.2)
        self.half = np.full(d, stroke / 2)
        self.pose = ["x", "y", "z"][:d]
        self.punit = ["mm"] * d
        self.qunit = ["mm"] * d
        self.L = rng.uniform(25, 80, (d, d))
        self.lev = rng.uniform(0.7, 1.4, d)
        self.rot = rng.normal(0, 2e-3, (d, d))

    def ik(self, p):
        q = p @ (np.eye(self.d) + self.rot)
        q = q * self.lev
        for i in range(self.d):
            for j in range(self.d):
                if i != j:  # a parallelogram of length L shortens when it swings
                    q[:, i] = q[:, i] + self.L[i, j] - np.sqrt(self.L[i, j] ** 2 - p[:, j] ** 2)
        return q


class LinearDelta(Robot):
    kind = "delta"

    def __init__(self, rng):
        self.d = 3
        self.name = "linear_delta"
        stroke = float(rng.choice([2, 10, 40])) * rng.uniform(0.8, 1.2)
        self.half = np.full(3, stroke / 2)
        self.pose = ["x", "y", "z"]
        self.punit = ["mm"] * 3
        self.qunit = ["mm"] * 3
        L = rng.uniform(6, 12) * stroke + 60
        R = L * rng.uniform(0.4, 0.65)
        ang = np.array([0, 2, 4]) * np.pi / 3 + rng.normal(0, 2e-3, 3) + rng.uniform(0, 2 * np.pi)
        self.L = L + rng.normal(0, 0.05, 3)
        self.a = np.stack([R * np.cos(ang), R * np.sin(ang)], 1) + rng.normal(0, 0.05, (3, 2))
        self.h = np.sqrt(L * L - R * R)

    def ik(self, p, dL=None):
        L = self.L if dL is None else self.L + dL
        return np.stack(
            [
                p[:, 2]
                + np.sqrt(L[i] ** 2 - (p[:, 0] - self.a[i, 0]) ** 2 - (p[:, 1] - self.a[i, 1]) ** 2)
                - self.h
                for i in range(3)
            ],
            1,
        )


class RotaryDelta(Robot):
    kind = "delta"

    def __init__(self, rng):
        self.d = 3
        self.name = "rotary_delta"
        stroke = float(rng.choice([3, 15, 50])) * rng.uniform(0.8, 1.2)
        self.half = np.full(3, stroke / 2)
        self.pose = ["x", "y", "z"]
        self.punit = ["mm"] * 3
        self.qunit = ["deg"] * 3
        u = rng.uniform(4, 7) * stroke + 60
        self.L1 = u * rng.uniform(0.45, 0.6) + rng.normal(0, 0.05, 3)
        self.L = u * 1.1 + rng.normal(0, 0.05, 3)
        self.R = u * rng.uniform(0.35, 0.5) + rng.normal(0, 0.05, 3)
        self.ang = (
            np.array([0, 2, 4]) * np.pi / 3 + rng.normal(0, 1e-3, 3) + rng.uniform(0, 2 * np.pi)
        )
        self.z0 = -u * rng.uniform(0.95, 1.1)

    def ik(self, p, dL=None):
        L = self.L if dL is None else self.L + dL
        out = []
        for i in range(3):
            c, w = np.cos(self.ang[i]), np.sin(self.ang[i])
            X = c * p[:, 0] + w * p[:, 1] - self.R[i]
            Y = -w * p[:, 0] + c * p[:, 1]
            Z = p[:, 2] + self.z0
            # radial coordinate seen from the shoulder, outward positive; elbow out
            K = X * X + Y * Y + Z * Z + self.L1[i] ** 2 - L[i] ** 2
            A = 2 * self.L1[i] * X
            B = -2 * self.L1[i] * Z
            out.append(np.degrees(np.arctan2(B, A) - np.arccos(K / np.hypot(A, B))))
        return np.stack(out, 1)


class Hexapod(Robot):
    kind = "hexapod"

    def __init__(self, rng):
        self.d = 6
        self.name = "hexapod"
        stroke = float(rng.choice([0.5, 1, 2])) * rng.uniform(0.8, 1.2)
        self.half = np.array([stroke / 2] * 3 + [rng.uniform(100, 300)] * 3)
        self.pose = ["x", "y", "z", "rx", "ry", "rz"]
        self.punit = ["mm"] * 3 + ["arcsec"] * 3
        self.qunit = ["mm"] * 6
        Rb, Rp, H = rng.uniform(120, 200), rng.uniform(60, 100), rng.uniform(150, 250)
        ab = np.radians(np.array([-15, 15, 105, 135, 225, 255]) + rng.normal(0, 0.3, 6))
        ap = np.radians(np.array([-45, 45, 75, 165, 195, 285]) + rng.normal(0, 0.3, 6))
        self.a = np.stack([Rb * np.cos(ab), Rb * np.sin(ab), np.zeros(6)], 1) + rng.normal(
            0, 0.05, (6, 3)
        )
        self.b = np.stack([Rp * np.cos(ap), Rp * np.sin(ap), np.zeros(6)], 1) + rng.normal(
            0, 0.05, (6, 3)
        )
        self.H = H
        self.L0 = np.sqrt(np.sum((self.b + [0, 0, H] - self.a) ** 2, 1))

    def ik(self, p, dL=None):
        r = p[:, 3:] * ARC
        cx, sx, cy, sy, cz, sz = (
            np.cos(r[:, 0]),
            np.sin(r[:, 0]),
            np.cos(r[:, 1]),
            np.sin(r[:, 1]),
            np.cos(r[:, 2]),
            np.sin(r[:, 2]),
        )
        R = np.empty((len(p), 3, 3))
        R[:, 0, 0] = cy * cz
        R[:, 0, 1] = sx * sy * cz - cx * sz
        R[:, 0, 2] = cx * sy * cz + sx * sz
        R[:, 1, 0] = cy * sz
        R[:, 1, 1] = sx * sy * sz + cx * cz
        R[:, 1, 2] = cx * sy * sz - sx * cz
        R[:, 2, 0] = -sy
        R[:, 2, 1] = sx * cy
        R[:, 2, 2] = cx * cy
        v = np.einsum("nij,kj->nki", R, self.b) + p[:, None, :3] + np.array([0, 0, self.H]) - self.a
        q = np.sqrt((v**2).sum(2)) - self.L0
        return q if dL is None else q - dL


class Scara(Robot):
    kind = "scara"

    def __init__(self, rng):
        self.d = 2
        self.name = "scara"
        stroke = float(rng.choice([5, 30, 80])) * rng.uniform(0.8, 1.2)
        self.half = np.full(2, stroke / 2)
        self.pose = ["x", "y"]
        self.punit = ["mm"] * 2
        self.qunit = ["deg"] * 2
        self.l1, self.l2 = rng.uniform(180, 300), rng.uniform(150, 250)
        self.c = np.array([rng.uniform(0.62, 0.78) * (self.l1 + self.l2), rng.uniform(-60, 60)])
        self.o = rng.uniform(-3, 3, 2)

    def ik(self, p, dL=None):
        l1, l2 = self.l1, self.l2
        if dL is not None:
            l1, l2 = l1 + dL[0], l2 + dL[1]
        x, y = p[:, 0] + self.c[0], p[:, 1] + self.c[1]
        t2 = np.arccos((x * x + y * y - l1 * l1 - l2 * l2) / (2 * l1 * l2))
        t1 = np.arctan2(y, x) - np.arctan2(l2 * np.sin(t2), l1 + l2 * np.cos(t2))
        return np.degrees(np.stack([t1, t2], 1)) + self.o


ROBOTS = {
    "linear": lambda r: Stage(r, 1),
    "xy": lambda r: Stage(r, 2),
    "xyz": lambda r: Stage(r, 3),
    "flexure": lambda r: Flexure(r, int(r.choice([2, 3]))),
    "linear_delta": LinearDelta,
    "rotary_delta": RotaryDelta,
    "hexapod": Hexapod,
    "scara": Scara,
}
