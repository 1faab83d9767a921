# Rscript make_standards.R: data sets, and the standards' figures of them by R's own mean, sd, max, lm. Written apart from
# server/standards and from the formulas of docs/standards.md only. Prints with 17 digits.
num <- function(v) sprintf("%.17g", v)
put <- function(file, d) {
  con <- file(file, "wb")
  writeLines(c("# driftwise-dataset: 1", paste("# origin: make_standards.R, seeded"), paste(names(d), collapse = ",")), con)
  writeLines(do.call(paste, c(lapply(d, function(c) if (is.numeric(c)) num(c) else c), sep = ",")), con)
  close(con)
}
expected <- data.frame(file = character(), name = character(), value = character())
say <- function(file, name, value) expected[nrow(expected) + 1, ] <<- list(file, name, num(value))

# --- ISO 230-2: 7 positions, 5 cycles, an axis with backlash, a periodic error and noise
set.seed(2302)
P <- c(-3, -2.1, -0.95, 0.04, 1.1, 1.87, 3)
cmd <- 0
for (cycle in 1:5) cmd <- c(cmd, if (cycle == 1) -3.5, P, 3.5, rev(P), -3.5)
up <- c(TRUE, diff(cmd) > 0)
x <- cmd + 80e-6 * sin(cmd * 2.1) + 25e-6 * cmd + ifelse(up, 1, -1) * (60e-6 + 10e-6 * cmd) + rnorm(length(cmd), sd = 15e-6)
put("iso230_2.csv", data.frame(time_s = 12 * seq_along(cmd), zero = as.integer(cmd == 0), q1_mm = cmd + rnorm(length(cmd), sd = 3e-5),
                               q1_cmd_mm = cmd, x_mm = x, t01_degC = 20 + 0.01 * seq_along(cmd)))
dev <- (x - cmd) * 1e6
U <- sapply(P, function(p) dev[cmd == p & up]); D <- sapply(P, function(p) dev[cmd == p & !up])
stopifnot(dim(U) == c(5, 7), dim(D) == c(5, 7))
mu <- colMeans(U); md <- colMeans(D); su <- apply(U, 2, sd); sd_ <- apply(D, 2, sd)
B <- mu - md
Ri <- pmax(2 * su + 2 * sd_ + abs(B), 4 * su, 4 * sd_)
f <- "iso230_2"
say(f, "A", max(mu + 2 * su, md + 2 * sd_) - min(mu - 2 * su, md - 2 * sd_))
say(f, "A_up", max(mu + 2 * su) - min(mu - 2 * su)); say(f, "A_down", max(md + 2 * sd_) - min(md - 2 * sd_))
say(f, "R", max(Ri)); say(f, "R_up", max(4 * su)); say(f, "R_down", max(4 * sd_))
say(f, "E", diff(range(mu, md))); say(f, "E_up", diff(range(mu))); say(f, "E_down", diff(range(md)))
say(f, "M", diff(range((mu + md) / 2))); say(f, "B", max(abs(B))); say(f, "B_mean", mean(B))
for (i in seq_along(P)) { say(f, paste0("R_", i), Ri[i]); say(f, paste0("B_", i), B[i]) }

# --- ISO 230-3: two positions from below every six minutes for five hours; the room warms and calms down
set.seed(2303)
rounds <- 51
t <- rep(360 * (0:(rounds - 1)), each = 3) + rep(c(0, 20, 40), rounds)
cmd <- rep(c(-4.1, -4, 4), rounds)
room <- 22 + 1.5 * (1 - exp(-t / 4000)) + 0.2 * sin(t / 1300)
x <- cmd + (room - 22) * (120e-6 + 40e-6 * cmd) + rnorm(length(t), sd = 5e-6)
put("iso230_3.csv", data.frame(time_s = t, q1_cmd_mm = cmd, x_mm = x, t01_degC = room))
f <- "iso230_3"
for (p in c(-4, 4)) {
  k <- cmd == p; e <- (x[k] - p) * 1e6; e <- e - e[1]; h <- t[k] / 3600
  n <- paste0(if (p < 0) "low" else "high", "_")
  say(f, paste0(n, "range"), diff(range(e))); say(f, paste0(n, "end"), e[length(e)])
  at <- function(s) approx(h, e, pmin(s, h[rounds]), ties = "ordered")$y # e(t) on straight lines between the visits
  say(f, paste0(n, "hour"), at(h[1] + 1)); say(f, paste0(n, "slope"), unname(coef(lm(e ~ h))[2]))
  for (w in c(15, 60, 240) / 60) { # windows that begin or end on a visit, cut off where the series ends
    begins <- c(h, pmax(h - w, h[1]))
    say(f, paste0(n, "window_", 60 * w),
        max(sapply(begins, function(from) diff(range(at(from), at(from + w), e[h >= from - 1e-9 & h <= from + w + 1e-9])))))
  }
}

# --- ISO 9283: five poses, thirty cycles, three axes and three rotations
set.seed(9283)
C <- rbind(c(1, 1, 1), c(1.8, 1.8, 1.8), c(0.2, 1.8, 1.8), c(0.2, 0.2, 0.2), c(1.8, 0.2, 0.2))
cmd <- C[rep(1:5, 30), ]
n <- nrow(cmd)
p <- cmd + matrix(rnorm(3 * n, sd = 40e-6), n) + cmd * 15e-6 + cbind(rep(1e-4, n), 0, -5e-5)
r <- matrix(rnorm(3 * n, sd = 0.4), n) + cbind(rep(2, n), -1, 0.5)
r[, 1] <- r[, 1] + 648000 # straddles half a turn: recorded within it
r[, 1] <- ((r[, 1] + 648000) %% 1296000) - 648000
put("iso9283.csv", data.frame(time_s = 9 * seq_len(n), x_target_mm = cmd[, 1], y_target_mm = cmd[, 2], z_target_mm = cmd[, 3],
                              x_mm = p[, 1], y_mm = p[, 2], z_mm = p[, 3], rx_target_arcsec = rep(648000, n),
                              rx_arcsec = r[, 1], ry_arcsec = r[, 2], rz_arcsec = r[, 3]))
f <- "iso9283"
for (i in 1:5) {
  k <- rep(1:5, 30) == i
  centre <- colMeans(p[k, ]); a <- (centre - C[i, ]) * 1e6
  l <- sqrt(rowSums(sweep(p[k, ], 2, centre)^2)) * 1e6
  say(f, paste0("AP_", i), sqrt(sum(a^2))); say(f, paste0("APx_", i), a[1]); say(f, paste0("RP_", i), mean(l) + 3 * sd(l))
  turned <- r[k, 1] %% 1296000 # away from the seam
  say(f, paste0("APrx_", i), mean(turned) - 648000); say(f, paste0("RPrx_", i), 3 * sd(turned))
  say(f, paste0("APry_", i), mean(r[k, 2])); say(f, paste0("RPry_", i), 3 * sd(r[k, 2]))
}
write.csv(expected, "expected.csv", row.names = FALSE, quote = FALSE)
