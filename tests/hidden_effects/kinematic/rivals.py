"""Catalogue of rivals of a hidden cause, and how much of an effect each one explains."""
import numpy as np

from baseline import motor, posecol, proj, white
from motion import axis_dirs, moves, pose_dirs
from room import decay_sum, dn, lowpass

TAUS = [120, 300, 700, 1500, 3000, 6000, 14000]


def rivals(S):
    """Rivals (cause, subject, list of pose columns (n,d,K)) that the file can tell of."""
    r = S.robot
    d = r.d
    span = S.t[-1] - S.t[0]
    R = []
    tt = (S.t - S.t[0]) / span

    def allout(cause, sub, g):
        R.append((cause, sub, [motor(S, g[:, None], i) for i in range(d)]))

    temps = [(S.Tname[k], S.T[:, k]) for k in range(S.nparts)]
    at = temps + ([("air", S.Tair)] if S.hasair else [])
    for nm, y in at:
        y = y - y[0]
        if not (nm[0] == "t" and int(nm[1:]) - 1 in S.bs):
            allout("thermal_offset", nm, y)
        for tau in TAUS:
            if tau < 2 * span:
                allout("thermal_lag", nm, lowpass(S.t, y, tau))
        allout("thermal_rate", nm, np.gradient(y, S.t))
        if nm != "air":
            R.append(
                (
                    "thermal_expansion",
                    nm,
                    [motor(S, (S.p0 / r.half) * y[:, None], i) for i in range(d)],
                )
            )
    for j in range(d):
        nm = r.pose[j]
        R.append(("instrument_drift", nm, [posecol(S, tt[:, None], j)]))
        for tc in np.linspace(0.04, 0.96, 33):
            R.append(("step_change", nm, [posecol(S, (tt > tc).astype(float)[:, None], j)]))
        for per in np.exp(
            np.linspace(
                np.log(max(2.2 * np.median(np.diff(S.t)), span / 120)), np.log(span * 0.9), 50
            )
        ):
            R.append(
                (
                    "periodic_disturbance",
                    nm,
                    [
                        posecol(
                            S,
                            np.stack(
                                [np.sin(2 * np.pi * S.t / per), np.cos(2 * np.pi * S.t / per)], 1
                            ),
                            j,
                        )
                    ],
                )
            )
        pd = pose_dirs(S)
        R.append(("probe_hysteresis", nm, [posecol(S, pd[:, [j]], j)]))
        if S.hasair:
            R.append(("refractive_index", nm, [posecol(S, dn(S.P, S.Tair, S.H)[:, None] * 1e6, j)]))
        L = r.half[j] * 2
        for per in L / np.exp(np.linspace(np.log(1.2), np.log(25), 40)):
            ph = 2 * np.pi * S.p0[:, j] / per
            R.append(("cyclic_error", nm, [posecol(S, np.stack([np.sin(ph), np.cos(ph)], 1), j)]))
        u = S.p0[:, j] / r.half[j]
        R.append(
            (
                "geometry_order",
                nm,
                [motor(S, np.stack([u ** (S.deg + 1), u ** (S.deg + 2)], 1), i) for i in range(d)],
            )
        )
    if S.tilt is not None:
        pairs = {0: [1, 2], 1: [0, 2], 2: [0, 1]}
        for j in range(d):
            R.append(("abbe_offset", r.pose[j], [posecol(S, S.tilt[:, pairs[j]], j)]))
    dirs = axis_dirs(S)
    mv = moves(S)
    for i in range(d):
        nm = "q%d" % (i + 1)
        R.append(("backlash", nm, [motor(S, dirs[:, [i]], i)]))
        L = np.ptp(S.qc[:, i])
        for per in L / np.exp(np.linspace(np.log(1.2), np.log(25), 40)):
            ph = 2 * np.pi * S.q[:, i] / per
            R.append(("cyclic_error", nm, [motor(S, np.stack([np.sin(ph), np.cos(ph)], 1), i)]))
        for tau in [15, 60, 240, 900, 3000]:
            R.append(("creep", nm, [motor(S, decay_sum(S.tm, mv[:, i] / L, S.t, tau)[:, None], i)]))
        for tau in [300, 900, 2500, 6000]:
            g = decay_sum(S.tm, np.abs(mv[:, i]) / L, S.t, tau)
            R.append(("self_heating", nm, [motor(S, g[:, None], k) for k in range(d)]))
    if S.duty is not None:
        for tau in [60, 300, 900, 2500, 6000]:
            allout("activity_heating", "duty", lowpass(S.t, S.duty, tau) / 100)
    if S.force is not None:
        f = S.force / 4
        if not S.Fbase:
            allout("force_compliance", "F", f)
        R.append(
            (
                "force_nonlinearity",
                "F",
                [motor(S, np.stack([f**2, f**3], 1), i) for i in range(d)],
            )
        )
        R.append(
            (
                "force_position_coupling",
                "F",
                [motor(S, (S.p0 / r.half) * f[:, None], i) for i in range(d)],
            )
        )
    return R


def whiten_rivals(S, R):
    """Whitened columns of each rival, without the baseline's part."""
    blocks = [np.concatenate([white(S, c) for c in cols], 1) for _, _, cols in R]
    W = np.concatenate(blocks, 1)
    nr0 = np.linalg.norm(W, axis=0)
    W = proj(S, W)
    out = []
    k = 0
    for b in blocks:
        w = W[:, k : k + b.shape[1]]
        q0 = nr0[k : k + b.shape[1]]
        k += b.shape[1]
        keep = np.linalg.norm(w, axis=0) > 1e-4 * q0
        out.append(w[:, keep])
    return out


def explained(w, v):
    """chi2 of v that columns w explain."""
    if w.shape[1] == 0:
        return 0.0
    w = w / np.linalg.norm(w, axis=0)
    u, s, _ = np.linalg.svd(w, full_matrices=False)
    u = u[:, s > 1e-4]
    return float(((u.T @ v) ** 2).sum())


def alias(S, c1, s1, c2, s2):
    """The same thing in another word; on stages a motor and its pose axis are one."""
    if c1 == c2 and s1 == s2:
        return True

    def ax(s):
        return (
            int(s[1:]) - 1
            if s and s[0] == "q" and s[1:].isdigit()
            else (S.robot.pose.index(s) if s in S.robot.pose else None)
        )

    st = S.robot.kind in ("stage", "flexure")
    fam = {
        "backlash": "hyst",
        "probe_hysteresis": "hyst",
        "cyclic_error": "cyc",
        "gear_error": "cyc",
    }
    f1, f2 = fam.get(c1, c1), fam.get(c2, c2)
    if f1 == f2 and (s1 == s2):
        return True
    if (
        f1 == f2
        and f1 in ("hyst", "cyc", "step_change", "instrument_drift", "periodic_disturbance")
        and st
        and ax(s1) is not None
        and ax(s1) == ax(s2)
    ):
        return True
    return False
