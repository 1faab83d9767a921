"""One data set with nothing hidden: robot, plan, times, room, channels, true poses and noise."""
import numpy as np

from baseline import Bad
from noise import draw_noise
from plans import plan_points
from robots import NM, ROBOTS
from room import room


class Set:
    """One data set. q, qc (n,d): motors read back and commanded; p0 (n,d): true poses.

    t, tm, dwell (n): times of the reading and of the end of the move, in s. T, Tf (n,parts): true
    temperatures and readings. bs: thermometers of the baseline. J, Ji (n,d,d): motors by poses and
    its inverse. cal, val (n): calibration and validation rows.
    """


def base_set(rng, robot, plan, noise, want):
    S = Set()
    r = S.robot = ROBOTS[robot](rng)
    d = r.d
    S.plan = plan
    S.noise = noise
    step = draw_length(rng, S, want)
    Zu, S.line, S.zero = plan_points(rng, plan, d, S.n)
    tgt = Zu * r.half
    draw_times(rng, S, step, want)
    S.qc = r.ik(tgt)
    if not np.all(np.isfinite(S.qc)):
        raise Bad("unreachable")
    qs = draw_motors(rng, S)
    draw_room(rng, S, want)
    draw_thermal_baseline(rng, S, qs, want)
    draw_force(rng, S, qs, want)
    draw_activity(rng, S, want)
    draw_tilt(rng, S, Zu, want)
    draw_split(rng, S)
    S.p0 = r.fk(S.q - S.th, tgt)
    if np.max(np.abs(S.p0 / r.half)) > 1.2 or not np.all(np.isfinite(S.p0)):
        raise Bad("solve")
    S.J = r.jac(S.p0)
    S.Ji = np.linalg.inv(S.J)
    draw_noise(rng, S, noise)
    return S


def draw_length(rng, S, want):
    """Sets the number of rows n; returns the time between rows in s."""
    lo = {1: 80, 2: 100, 3: 150, 6: 400}[S.robot.d]
    n = int(np.exp(rng.uniform(np.log(lo), np.log(1200))))
    step = float(np.exp(rng.uniform(np.log(5), np.log(300))))
    if S.plan == "night":
        step = float(np.exp(rng.uniform(np.log(30), np.log(300))))
        n = max(n, 250)
    step = min(step, 40 * 3600 / n)
    step = max(5.0, step)
    if want.get("long"):
        step = max(step, min(300, 2.5 * 3600 / n))
    S.n = n
    return step


def draw_times(rng, S, step, want):
    n, plan = S.n, S.plan
    dtm = step * rng.uniform(0.8, 1.25, n)
    if plan == "hand":
        dtm = step * rng.lognormal(0, 0.4, n)
    if plan in ("hand", "iso230", "diagonals", "snake_zero", "circles"):
        newl = np.r_[False, S.line[1:] != S.line[:-1]]
        if rng.random() < 0.5:
            dtm = dtm + newl * rng.uniform(0, 3, n) * step
    # breaks of the operator, faults
    for _ in range(rng.integers(0, 3)):
        dtm[rng.integers(n)] += rng.uniform(200, 1500)
    dwell = dtm * rng.uniform(0.3, 0.75, n)
    if plan == "hand" or want.get("dwell"):
        dwell = dtm * rng.uniform(0.15, 0.9, n)
    dwell = np.minimum(dwell, 0.9 * dtm)
    S.t = np.cumsum(dtm)
    S.dwell = dwell
    S.tm = S.t - dwell


def draw_motors(rng, S):
    """Sets sigma of the pose readings and the motors read back; returns sigma in motor units."""
    r = S.robot
    qh = np.abs(r.jac(np.zeros((1, r.d)))[0])
    S.sigma = np.empty(r.d)
    s0 = rng.uniform(4, 25) * NM + rng.uniform(0.3, 2) * 1e-7 * 2 * r.half[0]
    for j in range(r.d):
        S.sigma[j] = s0 * rng.uniform(0.7, 1.4) if r.punit[j] == "mm" else rng.uniform(0.01, 0.06)
    # the motor read back differs from the command by the holding error
    S.q = np.round(S.qc + rng.normal(0, 1, S.qc.shape) * (qh @ S.sigma) * 0.8, 10)
    return qh @ S.sigma


def draw_room(rng, S, want):
    n = S.n
    thermal = "thermal" in str(want.get("cause"))
    S.nparts = int(rng.integers(2, 5)) if thermal else int(rng.integers(2, 7))
    S.rt, S.X, pressure, humidity = room(rng, S.t[-1], S.nparts)
    S.T = np.stack([np.interp(S.t, S.rt, S.X[:, i + 1]) for i in range(S.nparts)], 1)
    S.Tair = np.interp(S.t, S.rt, S.X[:, 0])
    S.P = np.interp(S.t, S.rt, pressure)
    S.H = np.interp(S.t, S.rt, humidity)
    S.sT = rng.uniform(0.3, 2) * 1e-3
    S.Tf = np.round(S.T + rng.normal(0, S.sT, S.T.shape), 4)
    S.Airf = np.round(S.Tair + rng.normal(0, 4e-3, n), 3)
    S.Pf = np.round(S.P + rng.normal(0, 0.015, n), 3)
    S.Hf = np.round(S.H + rng.normal(0, 0.05, n), 2)
    # a part with one time constant: its rate is air less part, so no air with a hidden rate
    S.hasair = want.get("air") or (rng.random() < 0.6 and want.get("cause") != "thermal_rate")
    S.Tname = ["t%02d" % (i + 1) for i in range(S.nparts)]


def draw_thermal_baseline(rng, S, qs, want):
    """Sets the thermometers that the motors follow, all or some, and their share th (n,d)."""
    r, nparts = S.robot, S.nparts
    nb = nparts if rng.random() < 0.35 else int(rng.integers(1, min(nparts, 4) + 1))
    if want.get("spare"):
        nb = min(nb, nparts - 1)
    S.bs = list(range(nb)) if nb == nparts else sorted(rng.permutation(nparts)[:nb].tolist())
    cmax = 0.12 * qs / S.sT
    S.coef = (
        rng.choice([-1, 1], (nb, r.d))
        * rng.uniform(0.15, 1, (nb, r.d))
        * np.minimum(cmax, (qs * 60))[None, :]
    )
    Tref = S.Tf[0].copy()
    S.th = (S.T[:, S.bs] - Tref[S.bs]) @ S.coef
    S.cross = []
    if r.kind == "stage" and r.half[0] > 40 and want.get("cause") != "thermal_expansion":
        k = S.bs[0]
        ppm = rng.uniform(3, 12) * 1e-6
        S.th = S.th + ppm * (S.T[:, [k]] - Tref[k]) * S.qc
        S.cross = [k]


def draw_force(rng, S, qs, want):
    S.force = None
    S.Fbase = False
    if not (want.get("force") or rng.random() < 0.2):
        return
    levels = np.round(np.arange(0, 4.1, 0.4), 2)
    blocks = int(rng.integers(5, 12))
    w = rng.choice(levels, blocks)
    if rng.random() < 0.4:
        S.force = rng.choice(levels, S.n)
    else:
        S.force = np.repeat(w, S.n // blocks + 1)[: S.n]
    S.Fbase = want.get("cause") != "force_compliance"
    compliance = rng.normal(0, 1, S.robot.d) * 40 * qs / 4
    if S.Fbase:
        S.th = S.th + np.outer(S.force, compliance)


def draw_activity(rng, S, want):
    S.duty = None
    if not (want.get("duty") or rng.random() < 0.1):
        return
    S.duty = np.zeros(S.n)
    k = 0
    while k < S.n:
        m = int(rng.integers(5, max(6, S.n // 6)))
        S.duty[k : k + m] = rng.choice([0, 0, 20, 50, 80, 100])
        k += m


def draw_tilt(rng, S, Zu, want):
    S.tilt = None
    if not (S.robot.kind == "stage" and (want.get("tilt") or rng.random() < 0.2)):
        return
    S.tilt = np.zeros((S.n, 3))
    for a in range(3):
        S.tilt[:, a] = (
            rng.uniform(1, 8) * np.sin(Zu[:, 0] * rng.uniform(0.5, 1.2) + rng.uniform(0, 6))
            + rng.uniform(0.1, 0.6) * rng.normal(0, 1, S.n)
            + rng.uniform(0, 0.8) * np.sin(2 * np.pi * S.t / rng.uniform(2000, 9000) + rng.random())
        )
    S.tiltf = np.round(S.tilt + rng.normal(0, 0.015, S.tilt.shape), 4)


def draw_split(rng, S):
    n = S.n
    m = rng.choice(["none", "third", "random", "block", "half"], p=[0.25, 0.2, 0.25, 0.15, 0.15])
    v = np.zeros(n, bool)
    if m == "third":
        v[2::3] = True
    if m == "random":
        v = rng.random(n) < 0.3
    if m == "half":
        v[(np.arange(n) // max(1, n // 12)) % 2 == 1] = True
    if m == "block":
        v[int(n * 0.4) : int(n * 0.6)] = True
    if (n - v.sum()) < 70 * (1 if S.robot.d < 6 else 4):
        v[:] = False
        m = "none"
    S.val = v
    S.split = m
    S.cal = ~v
