"""Directions and moves of the axes from row to row."""
import numpy as np


def axis_dirs(S):
    """Sign of the last move of each motor (n,d)."""
    q = S.qc
    n, d = q.shape
    out = np.zeros((n, d))
    cur = np.ones(d)
    rng_ = np.ptp(q, axis=0)
    for k in range(n):
        if k:
            dq = q[k] - q[k - 1]
            mv = np.abs(dq) > 1e-6 * rng_
            cur = np.where(mv, np.sign(dq), cur)
        out[k] = cur
    return out


def pose_dirs(S):
    """Sign of the last move of each pose axis (n,d)."""
    p = S.p0
    n, d = p.shape
    out = np.zeros((n, d))
    cur = np.ones(d)
    for k in range(n):
        if k:
            dp = p[k] - p[k - 1]
            mv = np.abs(dp) > 1e-5 * S.robot.half
            cur = np.where(mv, np.sign(dp), cur)
        out[k] = cur
    return out


def moves(S):
    """Commanded moves of the motors (n,d)."""
    return np.vstack([np.zeros(S.robot.d), np.diff(S.qc, axis=0)])
