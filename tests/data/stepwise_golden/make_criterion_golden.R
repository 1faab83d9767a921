# Golden results for selection by AIC and BIC, and for hierarchy: R's step(), add1() and drop1(), which let a product in
# only with its parents.
#   Rscript make_criterion_golden.R [seed] [problems] > criterion_golden.txt      R >= 4.0, base packages only
#
# aic, bic: step(direction = "both", k = 2 or log n) from the constant alone. p: add1/drop1 as in make_golden.R.
# Problems with two changes within 1e-6 of each other, or a p near a threshold, are drawn again.
# Output, one problem after the other:
#   problem <n> <criterion> <hierarchy> <rows> <weighted>
#   terms <notation> ...                      the candidates in order
#   <rows lines: y x1 .. x4 [w]>
#   path <+x1 | -x1:x2 ...>
#   end <rmse> <dof> <extractAIC with k = 2> <with k = log n>
suppressWarnings(RNGkind("Mersenne-Twister", "Inversion", "Rejection"))
args <- commandArgs(TRUE)
set.seed(if (length(args) > 0) as.integer(args[1]) else 19740601)
problems <- if (length(args) > 1) as.integer(args[2]) else 120
fmt <- function(v) formatC(v, digits = 17, format = "g")
snap <- function(v, bits = 20) round(v * 2^bits) / 2^bits
mains <- paste0("x", 1:4)
crossed <- c(mains, "x1:x2", "x1:x3", "x2:x3", "x1:x2:x3")
formula_of <- function(terms) as.formula(paste("y ~", if (length(terms)) paste(terms, collapse = "+") else "1"))
label <- function(f) vapply(strsplit(trimws(f), ":"), function(p) paste(sort(p), collapse = ":"), "")

fit_of <- function(terms, d, w) { f <- formula_of(terms); environment(f) <- environment(); lm(f, d, weights = w) }

by_information <- function(d, w, scope, k) {
  inside <- character(0); path <- character(0); close <- FALSE
  repeat {
    fit <- fit_of(inside, d, w)
    now <- extractAIC(fit, k = k)[2]
    change <- list()
    add <- add.scope(fit, formula_of(scope))
    for (t in add) change[[paste0("+", label(t))]] <- extractAIC(fit_of(c(inside, t), d, w), k = k)[2]
    for (t in drop.scope(fit)) {
      change[[paste0("-", label(t))]] <- extractAIC(fit_of(setdiff(inside, label(t)), d, w), k = k)[2]
    }
    v <- sort(unlist(change))
    if (length(v) > 1 && v[2] - v[1] < 1e-6) close <- TRUE
    if (abs(v[1] - now) < 1e-6) close <- TRUE
    if (!(v[1] < now - 1e-7)) break
    path <- c(path, names(v)[1]); t <- substring(names(v)[1], 2)
    inside <- if (startsWith(names(v)[1], "+")) c(inside, t) else setdiff(inside, t)
  }
  # The walk above is step()'s, written out for the ties; step() itself must agree.
  d$w_ <- w
  from <- lm(y ~ 1, d, weights = w_)
  s <- step(from, scope = list(lower = ~1, upper = formula_of(scope)), direction = "both", k = k, trace = 0)
  steps <- gsub(" ", "", s$anova$Step[-1])
  steps <- paste0(substr(steps, 1, 1), label(substring(steps, 2)))
  stopifnot(close || identical(as.character(steps[nchar(steps) > 1]), path))
  list(inside = inside, path = path, close = close)
}

by_p <- function(d, w, scope, enter = .05, remove = .10) {
  inside <- character(0); path <- character(0); close <- FALSE
  repeat {
    fit <- fit_of(inside, d, w); changed <- FALSE
    if (length(add.scope(fit, formula_of(scope)))) {
      a <- add1(fit, formula_of(scope), test = "F")[-1, , drop = FALSE]
      f <- a[["F value"]]; i <- which.max(f); pv <- a[["Pr(>F)"]][i]
      if (sum(f > f[i] * (1 - 1e-6)) > 1 || abs(pv - enter) < 1e-6) close <- TRUE
      if (pv < enter) { t <- label(rownames(a)[i]); inside <- c(inside, t); path <- c(path, paste0("+", t)); changed <- TRUE }
    }
    if (changed) next
    if (!length(inside)) break
    o <- drop1(fit, test = "F")[-1, , drop = FALSE]
    f <- o[["F value"]]; i <- which.min(f); pv <- o[["Pr(>F)"]][i]
    if (abs(pv - remove) < 1e-6) close <- TRUE
    if (!(pv > remove)) break
    t <- label(rownames(o)[i]); path <- c(path, paste0("-", t)); inside <- setdiff(inside, t)
  }
  list(inside = inside, path = path, close = close)
}

count <- 0
while (count < problems) {
  criterion <- c("aic", "bic", "p")[count %% 3 + 1]
  hierarchy <- count %% 2 == 0 || criterion == "p"     # p without hierarchy: make_golden.R
  weighted <- runif(1) < .3
  n <- sample(18:60, 1)
  x <- matrix(snap(rnorm(n * 4)), n, 4)
  if (runif(1) < .3) for (j in 2:4) x[, j] <- snap(.9 * x[, 1] + .45 * x[, j])
  proxy <- runif(1) < .4                       # x4 stands for x1 + x2: it enters first and leaves again
  if (proxy) x[, 4] <- snap(.7 * (x[, 1] + x[, 2]) + .6 * x[, 4])
  colnames(x) <- mains
  all <- cbind(x, x[, 1] * x[, 2], x[, 1] * x[, 3], x[, 2] * x[, 3], x[, 1] * x[, 2] * x[, 3])
  b <- rnorm(8) * (runif(8) < .45)
  if (proxy) b[1:4] <- c(1, 1, 0, 0)
  y <- snap(drop(all %*% b) + (if (proxy) runif(1, .1, .4) else runif(1, .1, 2)) * rnorm(n), 30)
  d <- data.frame(x, y = y)
  w <- if (weighted) snap(exp(rnorm(n)), 16) + 2^-16 else rep(1, n)
  scope <- if (hierarchy) crossed else mains
  r <- if (criterion == "p") by_p(d, w, scope) else by_information(d, w, scope, if (criterion == "aic") 2 else log(n))
  if (r$close) next
  count <- count + 1
  fit <- fit_of(r$inside, d, w)
  cat("problem", count, criterion, as.integer(hierarchy), n, as.integer(weighted), "\n")
  cat("terms", scope, "\n")
  for (i in 1:n) cat(fmt(c(y[i], x[i, ], if (weighted) w[i])), "\n")
  cat("path", r$path, "\n")
  cat("end", fmt(c(summary(fit)$sigma, fit$df.residual, extractAIC(fit, k = 2)[2], extractAIC(fit, k = log(n))[2])), "\n")
}
