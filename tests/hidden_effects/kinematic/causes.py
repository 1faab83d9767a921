"""Causes of the catalogue as they act: each with its subject, its shape and its parameters."""
import math

import numpy as np

from baseline import Bad
from motion import axis_dirs, moves, pose_dirs
from robots import ARC, NM
from room import decay_sum, dn, lowpass

CAUSES = [
    "thermal_offset",
    "thermal_lag",
    "thermal_rate",
    "thermal_expansion",
    "self_heating",
    "force_compliance",
    "force_nonlinearity",
    "force_position_coupling",
    "backlash",
    "creep",
    "cyclic_error",
    "abbe_offset",
    "refractive_index",
    "instrument_drift",
    "step_change",
    "periodic_disturbance",
    "sensor_fault",
    "outliers",
    "noise_change",
    "probe_hysteresis",
    "activity_heating",
    "geometry_order",
    "gear_error",
]
# What a data set must have for a cause.
WANT = {
    "thermal_offset": {"spare": 1, "long": 1},
    "thermal_lag": {"long": 1},
    "thermal_rate": {"long": 1},
    "thermal_expansion": {"long": 1},
    "self_heating": {"long": 1},
    "force_compliance": {"force": 1},
    "force_nonlinearity": {"force": 1},
    "force_position_coupling": {"force": 1},
    "creep": {"dwell": 1},
    "abbe_offset": {"tilt": 1},
    "refractive_index": {"air": 1, "long": 1},
    "activity_heating": {"duty": 1, "long": 1},
    "sensor_fault": {"long": 1},
}
# Robots on which a cause is drawn; the others are drawn on all.
ONLY = {
    "abbe_offset": ["linear", "xy", "xyz"],
    "gear_error": ["scara", "rotary_delta"],
    "probe_hysteresis": ["linear_delta", "scara", "hexapod", "rotary_delta", "linear"],
}
HARMONICS = (18, 20, 24, 30, 36, 40, 50, 60, 72, 80, 90, 100, 120, 160, 200)
# Periods of scales, interferometers and screws in mm.
PERIODS = [316.4e-6, 632.8e-6, 0.004, 0.02, 0.04, 0.1, 0.2, 0.5, 1, 2, 4, 5, 10, 20.0]


class Place:
    """Where a cause acts: motor i, pose axis j (a length), share of each motor `mix`."""

    def __init__(self, rng, S):
        d = S.robot.d
        self.span = S.t[-1] - S.t[0]
        self.qs = np.einsum("nij,j->i", np.abs(S.J), S.sigma) / S.n
        self.i = int(rng.integers(d))
        rng.integers(d)  # keeps the stream of random numbers of the seeds that are used up
        self.j = int(rng.choice([k for k in range(d) if S.robot.punit[k] == "mm"]))
        self.mix = rng.choice([-1, 1], d) * rng.uniform(0.3, 1, d) * self.qs
        self.motor = "q%d" % (self.i + 1)
        self.pose = S.robot.pose[self.j]


def effect(v, side, subject, par, limit=(0, 1e9)):
    """v (n,d): effect of size 1; side q (motors) or p (poses); par(size) -> parameters."""
    return {"v": v, "side": side, "subject": subject, "par": par, "limit": limit}


def at_motor(S, L, y):
    V = np.zeros((S.n, S.robot.d))
    V[:, L.i] = y
    return V


def at_pose(S, L, y):
    V = np.zeros((S.n, S.robot.d))
    V[:, L.j] = y
    return V


def log_uniform(rng, low, high):
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def thermal_offset(rng, S, L):
    spare = [a for a in range(S.nparts) if a not in S.bs]
    if not spare:
        raise Bad("no spare")
    k = int(rng.choice(spare))
    V = (S.T[:, [k]] - S.T[0, k]) * L.mix
    return effect(V, "q", S.Tname[k], lambda a: {"per_K": (a * L.mix).tolist()})


def thermal_lag(rng, S, L):
    k = int(rng.choice(S.bs))
    tau = log_uniform(rng, max(4 * L.span / S.n, 200), min(L.span / 2, 9000))
    late = lowpass(S.rt, S.X[:, k + 1] - S.X[0, k + 1], tau)
    V = np.interp(S.t, S.rt, late)[:, None] * L.mix
    par = lambda a: {"tau_s": tau, "per_K": (a * L.mix).tolist()}
    return effect(V, "q", S.Tname[k], par)


def thermal_rate(rng, S, L):
    k = int(rng.choice(S.bs))
    rate = np.gradient(S.X[:, k + 1], S.rt)
    V = np.interp(S.t, S.rt, rate)[:, None] * 3600 * L.mix
    return effect(V, "q", S.Tname[k], lambda a: {"per_K_per_h": (a * L.mix).tolist()})


def thermal_expansion(rng, S, L):
    r = S.robot
    k = int(rng.integers(S.nparts))
    y = S.T[:, k] - S.T[0, k]
    if r.kind in ("stage", "flexure"):
        V = at_motor(S, L, 1e-6 * y * S.qc[:, L.i])
        of = L.motor
    else:
        lengths = {"scara": lambda: [r.l1, r.l2], "delta": lambda: r.L, "hexapod": lambda: r.L0}
        length = np.asarray(lengths[r.kind](), float)
        e = np.zeros(len(length))
        one = rng.integers(len(length))
        e[one] = 1
        if rng.random() < 0.5:
            e[:] = 1
        e = e * length * 1e-6
        V = (r.ik(S.p0, e * 100) - r.ik(S.p0, -e * 100)) / 200 * y[:, None]
        of = "length %s" % ("all" if (e > 0).all() else one)
    return effect(V, "q", S.Tname[k], lambda a: {"ppm_per_K": a, "of": of}, (0.005, 40))


def self_heating(rng, S, L):
    tau = log_uniform(rng, max(300, 5 * L.span / S.n), min(6000, L.span / 2.5))
    way = np.abs(moves(S)[:, L.i]) / np.ptp(S.qc[:, L.i])
    share = np.eye(S.robot.d)[L.i] * L.qs if rng.random() < 0.6 else L.mix
    V = decay_sum(S.tm, way, S.t, tau)[:, None] * share
    return effect(V, "q", L.motor, lambda a: {"tau_s": tau})


def activity_heating(rng, S, L):
    tau = log_uniform(rng, max(120, 4 * L.span / S.n), min(5000, L.span / 4))
    # the level acts from the beginning of its row's interval; before the file there is none
    s = 0.0
    out = []
    for k in range(S.n):
        dt = S.t[k] - (S.t[k - 1] if k else S.t[0] - 30)
        s = S.duty[k] + (s - S.duty[k]) * math.exp(-dt / tau)
        out.append(s)
    V = np.array(out)[:, None] * L.mix / 100
    return effect(V, "q", "duty", lambda a: {"tau_s": tau})


def force_compliance(rng, S, L):
    return effect(S.force[:, None] * L.mix, "q", "F", lambda a: {"per_N": (a * L.mix).tolist()})


def force_nonlinearity(rng, S, L):
    e = rng.choice([2, 3, 2 / 3])
    V = (S.force[:, None] / 4) ** e * L.mix
    return effect(V, "q", "F", lambda a: {"exponent": float(e)})


def force_position_coupling(rng, S, L):
    V = at_motor(S, L, S.force * S.p0[:, L.j] / S.robot.half[L.j] * L.qs[L.i])
    return effect(V, "q", "F", lambda a: {"with": L.pose, "on": L.motor})


def backlash(rng, S, L):
    V = at_motor(S, L, axis_dirs(S)[:, L.i] / 2)
    return effect(V, "q", L.motor, lambda a: {"width": abs(a)})


def probe_hysteresis(rng, S, L):
    V = at_pose(S, L, pose_dirs(S)[:, L.j] / 2)
    return effect(V, "p", L.pose, lambda a: {"width_nm": a / NM})


def creep(rng, S, L):
    high = max(60, min(3000, 6 * np.median(np.diff(S.t))))
    tau = log_uniform(rng, max(8, 0.5 * np.median(S.dwell)), high)
    way = moves(S)[:, L.i] / np.ptp(S.qc[:, L.i])
    V = at_motor(S, L, decay_sum(S.tm, way, S.t, tau))
    return effect(V, "q", L.motor, lambda a: {"tau_s": tau})


def gear_error(rng, S, L):
    phase = rng.uniform(0, 2 * np.pi)
    fit = [h for h in HARMONICS if 2.5 < np.ptp(S.q[:, L.i]) * h / 360 < 40]
    if not fit:
        raise Bad("harmonic")
    h = int(rng.choice(fit))
    V = at_motor(S, L, np.sin(np.radians(S.q[:, L.i] * h) + phase))
    par = lambda a: {"harmonic": h, "amplitude_arcsec": a * 3600, "period": 360.0 / h}
    return effect(V, "q", L.motor, par)


def cyclic_error(rng, S, L):
    phase = rng.uniform(0, 2 * np.pi)
    periods = np.array(PERIODS)
    at_q = S.robot.qunit[L.i] == "mm" and rng.random() < 0.6
    y = S.q[:, L.i] if at_q else S.p0[:, L.j]
    most = 5000 if S.plan in ("lhs", "random", "hand", "lattice") else 200
    ok = periods[(np.ptp(y) / periods > 2.5) & (np.ptp(y) / periods < most)]
    if not len(ok):
        raise Bad("period")
    per = float(rng.choice(ok)) * (1 if rng.random() < 0.7 else rng.uniform(0.9, 1.1))
    wave = np.sin(2 * np.pi * y / per + phase)
    par = lambda a: {"period_nm": per / NM, "amplitude_nm": a / NM}
    if at_q:
        return effect(at_motor(S, L, wave), "q", L.motor, par)
    return effect(at_pose(S, L, wave), "p", L.pose, par)


def abbe_offset(rng, S, L):
    pairs = {0: [(1, 1), (2, -1)], 1: [(2, 1), (0, -1)], 2: [(0, 1), (1, -1)]}
    axis, sign = pairs[L.j][int(rng.integers(2))]
    V = at_pose(S, L, sign * S.tilt[:, axis] * ARC)
    par = lambda a: {"offset_mm": a, "with": "r" + "xyz"[axis]}
    return effect(V, "p", L.pose, par, (0.05, 80))


def refractive_index(rng, S, L):
    V = at_pose(S, L, dn(S.P, S.Tair, S.H))
    return effect(V, "p", L.pose, lambda a: {"dead_path_mm": a}, (1, 600))


def instrument_drift(rng, S, L):
    V = at_pose(S, L, (S.t - S.t[0]) / 3600 * NM)
    return effect(V, "p", L.pose, lambda a: {"nm_per_h": a})


def step_change(rng, S, L):
    k = int(rng.integers(int(0.12 * S.n), int(0.88 * S.n)))
    V = at_pose(S, L, np.where(np.arange(S.n) >= k, NM, 0.0))
    return effect(V, "p", L.pose, lambda a: {"time_s": float(S.t[k]), "size_nm": a})


def periodic_disturbance(rng, S, L):
    low = max(3 * np.median(np.diff(S.t)), 20)
    high = L.span / 4
    if high < 2 * low:
        raise Bad("short")
    per = log_uniform(rng, low, high)
    V = at_pose(S, L, np.sin(2 * np.pi * S.t / per + rng.uniform(0, 6.28)) * NM)
    return effect(V, "p", L.pose, lambda a: {"period_s": per, "amplitude_nm": a})


def geometry_order(rng, S, L):
    u = S.p0[:, L.j] / S.robot.half[L.j]
    g = S.deg + 1
    V = at_motor(S, L, np.polynomial.legendre.Legendre.basis(g)(np.clip(u, -1.2, 1.2)))
    return effect(V, "q", L.pose, lambda a: {"degree": g, "on": L.motor})


def outliers(rng, S, L):
    k = int(rng.integers(1, 6))
    rows = rng.choice(np.where(S.cal)[0], k, replace=False)
    V = np.zeros((S.n, S.robot.d))
    V[rows, L.j] = rng.choice([-1, 1], k) * rng.uniform(0.8, 1.3, k) * S.sigma[L.j]
    par = lambda a: {"rows": sorted((rows + 1).tolist()), "axis": L.pose}
    return effect(V, "p", "rows", par)


EFFECTS = {
    "thermal_offset": thermal_offset,
    "thermal_lag": thermal_lag,
    "thermal_rate": thermal_rate,
    "thermal_expansion": thermal_expansion,
    "self_heating": self_heating,
    "activity_heating": activity_heating,
    "force_compliance": force_compliance,
    "force_nonlinearity": force_nonlinearity,
    "force_position_coupling": force_position_coupling,
    "backlash": backlash,
    "probe_hysteresis": probe_hysteresis,
    "creep": creep,
    "gear_error": gear_error,
    "cyclic_error": cyclic_error,
    "abbe_offset": abbe_offset,
    "refractive_index": refractive_index,
    "instrument_drift": instrument_drift,
    "step_change": step_change,
    "periodic_disturbance": periodic_disturbance,
    "geometry_order": geometry_order,
    "outliers": outliers,
}


def hide(rng, S, cause):
    """Effect of a cause of CAUSES; sensor_fault and noise_change are in faults.py."""
    return EFFECTS[cause](rng, S, Place(rng, S))
