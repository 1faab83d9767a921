# Golden results for stepwise regression: R's add1/drop1 rule (NUMERICS: the exact rule) on 360 seeded random problems.
#   Rscript make_golden.R [seed] [problems] > golden.txt        R >= 4.0, base packages only; takes about a minute
#
# The first 300 go round ten kinds, the rest round the hard kinds with weights; with another number of problems (live
# tests) the same shares.
#
# Rule: add1(test = "F") ranked by F while p < enter, else drop1 ranked by F while p > remove; a relative difference in F
# below 1e-9 is a tie, which the lowest column wins; columns that lm (tol = 1e-7) finds collinear cannot enter.
# Problems with a p within 1e-6 (relative) of a threshold are drawn again.
#
# "tiny": noise of 1e-8 on data of size 1. Below, the last bit of the data (2e-16) is already 1e-6 of a standard error.
# Numbers of the data are whole multiples of 2^-k so that decimal text is exact in both programs.
# Output, one problem after the other:
#   problem <n> <kind> <rows> <columns> <enter> <remove> <weighted>
#   <rows lines: y x1 .. xp [w]>
#   path <+j | -j ...>
#   rmse <rmse> <dof>
#   <p+1 lines: in(1/0/-1 collinear) coefficient standard_error t p>   the constant first
suppressWarnings(RNGkind("Mersenne-Twister", "Inversion", "Rejection"))
args <- commandArgs(TRUE)
set.seed(if (length(args) > 0) as.integer(args[1]) else 20110722)
problems <- if (length(args) > 1) as.integer(args[2]) else 360
fmt <- function(v) formatC(v, digits = 17, format = "g")
snap <- function(v, bits = 20) round(v * 2^bits) / 2^bits

stepwise <- function(d, p, enter, remove, weighted) {
  w <- if (weighted) d$weight else rep(1, nrow(d))
  full <- as.formula(paste("y ~", paste0("x", 1:p, collapse = "+")))
  inside <- integer(0); path <- character(0); close <- FALSE
  near <- function(pv, at) !is.na(pv) && abs(pv - at) < 1e-6 * at
  fit_of <- function(s) {
    f <- if (length(s)) as.formula(paste("y ~", paste0("x", s, collapse = "+"))) else y ~ 1
    environment(f) <- environment(); lm(f, d, weights = w)
  }
  for (round in 1:200) {
    fit <- fit_of(inside)
    outside <- setdiff(1:p, inside); changed <- FALSE
    if (length(outside) && fit$df.residual > 1) {
      a <- suppressWarnings(add1(fit, full, test = "F"))[-1, , drop = FALSE]
      f <- a[["F value"]]; pv <- a[["Pr(>F)"]]; j <- as.integer(sub("x", "", trimws(rownames(a))))
      ok <- !is.na(f) & a[["Df"]] == 1
      if (any(ok)) {
        best <- max(f[ok]); k <- min(which(ok & f >= best * (1 - 1e-9)))
        if (near(pv[k], enter)) close <- TRUE
        if (pv[k] < enter) { inside <- c(inside, j[k]); path <- c(path, paste0("+", j[k])); changed <- TRUE }
      }
    }
    if (changed) next
    if (!length(inside)) break
    o <- drop1(fit, test = "F")[-1, , drop = FALSE]
    f <- o[["F value"]]; pv <- o[["Pr(>F)"]]; j <- as.integer(sub("x", "", trimws(rownames(o))))
    worst <- min(f); cand <- which(f <= worst * (1 + 1e-9)); k <- cand[which.min(j[cand])]
    if (near(pv[k], remove)) close <- TRUE
    if (pv[k] > remove) { path <- c(path, paste0("-", j[k])); inside <- setdiff(inside, j[k]) } else break
  }
  list(inside = inside, path = path, close = close, fit = fit_of(inside), fit_of = fit_of)
}

make <- function(kind, n, p) {
  x <- matrix(snap(rnorm(n * p)), n, p)
  if (kind == "collinear") {
    x[, p] <- x[, 1] + x[, 2]                        # exact in these multiples
    if (p > 5) x[, p - 1] <- 3                       # constant
  }
  if (kind == "correlated") for (j in 2:p) x[, j] <- snap(0.95 * x[, 1] + 0.31 * x[, j])
  if (kind == "offset") x <- x + rep(snap(runif(p, 20, 400), 4), each = n)
  if (kind == "tied") x[, p] <- x[, 1 + sample(p - 2, 1)]  # a copy: the lower column must win
  if (kind == "grid") x <- matrix(sample(-3:3, n * p, TRUE), n, p)
  b <- rnorm(p) * (runif(p) < 0.4)
  sd <- switch(kind, tiny = 1e-8, nulls = 1, runif(1, 0.1, 3))
  if (kind == "nulls") b <- 0 * b
  y <- drop(x %*% b) + sd * rnorm(n)
  y <- if (kind == "tiny") round(y * 2^50) / 2^50 else snap(y, 30)
  d <- as.data.frame(x); names(d) <- paste0("x", 1:p); d$y <- y
  d$weight <- snap(exp(rnorm(n)), 16) + 2^-16
  d
}

kinds <- c("plain", "collinear", "correlated", "offset", "tied", "grid", "tiny", "nulls", "weighted", "few_rows")
count <- 0
hard <- c("collinear", "tied", "tiny")
while (count < problems) {
  late <- count >= problems * 300 / 360
  kind <- if (late) hard[count %% length(hard) + 1] else kinds[count %% length(kinds) + 1]
  p <- sample(4:9, 1); n <- if (kind == "few_rows") p + sample(2:4, 1) else sample(15:45, 1)
  thresholds <- list(c(.05, .10), c(.06, .10), c(.15, .15), c(.01, .05), c(.25, .40))[[sample(5, 1)]]
  weighted <- late || kind == "weighted" || (kind %in% c("plain", "correlated") && runif(1) < 0.2)
  d <- make(kind, n, p)
  r <- stepwise(d, p, thresholds[1], thresholds[2], weighted)
  s <- suppressWarnings(summary(r$fit))
  if (r$close || any(is.na(coef(r$fit))) || s$sigma < 1e-13) next
  count <- count + 1
  cat("problem", count, kind, n, p, thresholds, as.integer(weighted), "\n")
  for (i in 1:n) cat(fmt(c(d$y[i], unlist(d[i, 1:p]), if (weighted) d$weight[i])), "\n")
  cat("path", r$path, "\n")
  cat("rmse", fmt(s$sigma), r$fit$df.residual, "\n")
  one <- function(fit, name, state) {
    m <- suppressWarnings(summary(fit))$coefficients
    if (name %in% rownames(m)) cat(state, fmt(m[name, ]), "\n") else cat("-1 0 0 0 1\n")
  }
  one(r$fit, "(Intercept)", 1)
  for (j in 1:p) {
    if (j %in% r$inside) one(r$fit, paste0("x", j), 1)
    else if (r$fit$df.residual > 1) one(r$fit_of(c(r$inside, j)), paste0("x", j), 0)
    else cat("-1 0 0 0 1\n")
  }
}
