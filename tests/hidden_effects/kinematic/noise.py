"""Noise of the instruments: readings' errors and the covariance that whitens them."""
import math

import numpy as np

NOISES = ["white", "correlated", "heavy", "quantised"]


def draw_noise(rng, S, noise):
    """Sets eps (n,d), quant (d), cov and Li: a covariance and a whitening matrix per pose axis."""
    n, d = S.n, S.robot.d
    S.cov = []
    S.eps = np.empty((n, d))
    S.quant = np.zeros(d)
    tc = rng.uniform(60, 600)
    fr = rng.uniform(0.3, 0.8)
    nu = rng.uniform(3.5, 6)
    D = np.abs(S.t[:, None] - S.t[None, :])
    S.npar = {}
    for j in range(d):
        s = S.sigma[j]
        if noise == "correlated":
            C = s * s * ((1 - fr) * np.eye(n) + fr * np.exp(-D / tc))
            S.npar = {"tau_s": tc, "share": fr}
            S.eps[:, j] = np.linalg.cholesky(C) @ rng.normal(0, 1, n)
        elif noise == "heavy":
            C = s * s * np.eye(n)
            S.eps[:, j] = s * rng.standard_t(nu, n) / math.sqrt(nu / (nu - 2))
            S.npar = {"nu": nu}
        elif noise == "quantised":
            g = s * rng.uniform(1, 2.5)
            S.quant[j] = g
            C = (s * s + g * g / 12) * np.eye(n)
            S.eps[:, j] = s * rng.normal(0, 1, n)
        else:
            C = s * s * np.eye(n)
            S.eps[:, j] = s * rng.normal(0, 1, n)
        S.cov.append(C)
    S.Li = [np.linalg.inv(np.linalg.cholesky(C[np.ix_(S.cal, S.cal)])) for C in S.cov]


def motor_sigma(S, i):
    """Standard deviation of the noise as motor i has it, per calibration row."""
    mean = np.array([np.mean(np.diag(C)) for C in S.cov])
    return np.einsum("nj,j->n", S.J[S.cal][:, i, :] ** 2, mean) ** 0.5


def quantise(S, pm):
    for j in range(S.robot.d):
        if S.quant[j] > 0:
            pm[:, j] = np.round(pm[:, j] / S.quant[j]) * S.quant[j]
