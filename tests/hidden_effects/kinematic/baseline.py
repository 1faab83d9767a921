"""Baseline of a data set: its columns, formula and degree, and what is left beside it."""
import itertools

import numpy as np


class Bad(Exception):
    """A draw that gives no usable data set."""


def monomials(P, deg):
    """Monomials of degree 1 to deg of P (n,d), scaled poses."""
    cols = []
    for k in range(1, deg + 1):
        for c in itertools.combinations_with_replacement(range(P.shape[1]), k):
            cols.append(np.prod(P[:, c], axis=1))
    return cols


def white(S, V):
    """Calibration rows of V (n,d,K), whitened: (calibration rows times d, K)."""
    return np.concatenate([S.Li[j] @ V[S.cal, j, :] for j in range(S.robot.d)], 0)


def motor(S, G, i):
    """Columns G (n,K) that act on motor i, in the poses: (n,d,K)."""
    return S.Ji[:, :, i][:, :, None] * G[:, None, :]


def posecol(S, G, j):
    """Columns G (n,K) that act on pose axis j: (n,d,K)."""
    V = np.zeros((S.n, S.robot.d, G.shape[1]))
    V[:, j, :] = G
    return V


def base_cols(S, deg, T=None):
    """Columns of the baseline (n,K) over the true poses; T: temperatures, by default the true."""
    T = S.T if T is None else T
    P = S.p0 / S.robot.half
    c = [np.ones(S.n)] + monomials(P, deg) + [T[:, k] - T[0, k] for k in S.bs]
    for k in S.cross:
        for i in range(S.robot.d):
            c.append(P[:, i] * (T[:, k] - T[0, k]))
    if S.Fbase:
        c.append(S.force / 4)
    return np.stack(c, 1)


def formula(S, deg):
    """Baseline as `driftwise diagnose --baseline` takes it."""
    r = S.robot
    f = "q ~ poly(%s, %d)" % (", ".join(r.pose), deg)
    if len(S.bs) == S.nparts:
        f += " + T"
    else:
        f += "".join(" + " + S.Tname[k] for k in S.bs)
    for k in S.cross:
        f += "".join(" + %s:%s" % (p, S.Tname[k]) for p in r.pose)
    if S.Fbase:
        f += " + F"
    return f


def set_basis(S):
    """Sets the least degree that leaves a misfit of chi2 below 1.5, and the projector Q."""
    r = S.robot
    d = r.d
    ncal = int(S.cal.sum())
    for deg in range(1 if r.kind == "stage" else 2, 8):
        B = base_cols(S, deg)
        if B.shape[1] * (2.5 if d > 1 else 4) > ncal:
            raise Bad("too few rows")
        Bs = B[S.cal]
        Bs = Bs / np.linalg.norm(Bs, axis=0)
        q0 = r.ik(S.p0)
        # misfit of the polynomial in the motors, everything else exactly linear
        res = np.empty((S.n, d))
        for i in range(d):
            co, *_ = np.linalg.lstsq(B[S.cal], q0[S.cal, i], rcond=None)
            res[:, i] = q0[:, i] - B @ co
        w = white(S, sum(motor(S, res[:, [i]], i) for i in range(d)))
        mis = float((w**2).sum())
        if mis < 1.5:
            break
    else:
        raise Bad("degree")
    sv = np.linalg.svd(Bs, compute_uv=False)
    if sv[-1] < 2e-5:
        raise Bad("rank")
    wv = np.einsum("nij,nj->ni", S.Ji, res) / S.sigma
    if np.sqrt((wv**2).mean(0)).max() > 0.15:
        raise Bad("misfit of validation rows")
    S.deg = deg
    S.misfit = mis
    project(S, deg)


def project(S, deg):
    B = base_cols(S, deg)
    M = np.concatenate([white(S, motor(S, B, i)) for i in range(S.robot.d)], 1)
    M = M / np.linalg.norm(M, axis=0)
    S.Q, _ = np.linalg.qr(M)


def proj(S, W):
    """What the baseline leaves of whitened columns W."""
    return W - S.Q @ (S.Q.T @ W)


def file_cols(S, pm, Tf):
    """Columns of the baseline over measured poses and thermometers."""
    P = pm / S.robot.half
    c = [np.ones(S.n)] + monomials(P, S.deg) + [Tf[:, k] - Tf[0, k] for k in S.bs]
    for k in S.cross:
        c += [P[:, i] * (Tf[:, k] - Tf[0, k]) for i in range(S.robot.d)]
    if S.Fbase:
        c.append(S.force / 4)
    return np.stack(c, 1)
