# What this project's identification is held against: the same model in R, by another method.
#   Rscript identify.R series_a_subset.csv
# Nominal UR10 by the maker's Denavit-Hartenberg parameters, rigid fit (SVD); then 25 parameters of frame, links
# (Hayati's beta for links 2 and 3, whose next axes are parallel) and tool by Gauss-Newton with a numerical Jacobian and its
# singular value decomposition.
d <- read.csv(commandArgs(TRUE)[1], comment.char = "#")
q <- as.matrix(d[, sprintf("q%d_rad", 1:6)]); m <- as.matrix(d[, c("x_mm", "y_mm", "z_mm")])
rot <- function(axis, t) {
  c <- cos(t); s <- sin(t); r <- diag(4)
  i <- list(x = c(2, 3), y = c(3, 1), z = c(1, 2))[[axis]]
  r[i[1], i[1]] <- c; r[i[2], i[2]] <- c; r[i[1], i[2]] <- -s; r[i[2], i[1]] <- s; r
}
move <- function(x, y, z) { r <- diag(4); r[1:3, 4] <- c(x, y, z); r }
# 6 frame (mm, rad), 6 x (theta, d, a, alpha, beta), 3 tool
point <- function(p, q) {
  t <- move(p[1], p[2], p[3]) %*% rot("z", p[6]) %*% rot("y", p[5]) %*% rot("x", p[4])
  for (i in 1:6) {
    l <- p[6 + 5 * (i - 1) + 1:5]
    t <- t %*% rot("z", l[1] + q[i]) %*% move(0, 0, l[2]) %*% move(l[3], 0, 0) %*% rot("x", l[4]) %*% rot("y", l[5])
  }
  (t %*% c(p[37:39], 1))[1:3]
}
points <- function(p) t(apply(q, 1, function(one) point(p, one)))
links <- rbind(c(0, 127.3, 0, pi / 2, 0), c(0, 0, -612, 0, 0), c(0, 0, -572.3, 0, 0), c(0, 163.941, 0, pi / 2, 0),
               c(0, 115.7, 0, -pi / 2, 0), c(0, 92.2, 0, 0, 0))
p <- c(rep(0, 6), t(links), 0, 0, 109)
rigid <- function(a, b) {
  ca <- colMeans(a); cb <- colMeans(b); s <- svd(t(sweep(a, 2, ca)) %*% sweep(b, 2, cb))
  r <- s$v %*% diag(c(1, 1, sign(det(s$v %*% t(s$u))))) %*% t(s$u); list(r = r, t = cb - r %*% ca)
}
f <- rigid(points(p), m)
p[1:3] <- f$t; p[4] <- atan2(f$r[3, 2], f$r[3, 3]); p[5] <- atan2(-f$r[3, 1], sqrt(f$r[3, 2]^2 + f$r[3, 3]^2)); p[6] <- atan2(f$r[2, 1], f$r[1, 1])
rms <- function(p) sqrt(mean(rowSums((points(p) - m)^2)))
cat(sprintf("nominal_rms_mm %.10f\n", rms(p)))
at <- function(link, what) 6 + 5 * (link - 1) + c(theta = 1, d = 2, a = 3, alpha = 4, beta = 5)[what]
# Held: Hayati's rule; what the frame or the tool says already; what a tool exactly on the last axis hides.
fixed <- c(at(c(1, 4, 5, 6), "beta"), at(c(2, 3), "d"), at(1, "theta"), at(1, "d"), at(6, "theta"), at(6, "d"), at(6, "a"),
           at(6, "alpha"), at(5, "a"), at(5, "alpha"))
free <- setdiff(seq_along(p), fixed)
unit <- ifelse(seq_along(p) %in% c(4:6, 6 + 5 * rep(0:5, each = 3) + c(1, 4, 5)), 1e-4, 0.1)
for (iteration in 1:6) {
  e <- as.vector(points(p) - m)
  j <- sapply(free, function(k) { h <- unit[k] * 0.1; u <- p; l <- p; u[k] <- u[k] + h; l[k] <- l[k] - h
                                  as.vector(points(u) - points(l)) / (2 * h) * unit[k] })
  s <- svd(j); keep <- s$d > 1e-9 * s$d[1]
  step <- -s$v[, keep] %*% ((t(s$u[, keep]) %*% e) / s$d[keep])
  p[free] <- p[free] + unit[free] * step
}
cat(sprintf("a2_mm %.8f\na3_mm %.8f\n", p[at(2, "a")], p[at(3, "a")]))
cat(sprintf("identified_rms_mm %.10f\nrank %d\n", rms(p), sum(keep)))
