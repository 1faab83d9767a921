# Restricted maximum likelihood of slow plus white noise under a regression, by nlme (a recommended package of R):
#   Rscript make_serial_golden.R > golden.csv
# Lines: set,<rows>,<sigma>,<share>,<range in rows>,<restricted log likelihood>; then y,x1,x2 per row. share = 1 - nugget.
suppressWarnings(RNGkind("Mersenne-Twister", "Inversion", "Rejection"))
library(nlme)
set.seed(1971)
fmt <- function(v) formatC(v, digits = 15, format = "g")
for (case in list(c(150, .8, 1), c(200, .9, .6), c(300, .95, .5), c(250, .6, 1), c(400, .98, .7), c(300, .9, .9))) {
  n <- case[1]; phi <- case[2]; share <- case[3]
  repeat {
    x1 <- sin((1:n) / 23) + cumsum(rnorm(n)) / 20; x2 <- ((1:n) %% 17) / 8 - 1
    slow <- as.numeric(arima.sim(list(ar = phi), n, n.start = 500)) * sqrt(1 - phi^2)
    y <- 1 + 2 * x1 - x2 + sqrt(share) * slow + sqrt(1 - share) * rnorm(n)
    x1 <- round(x1, 8); y <- round(y, 8)
    fit <- try(gls(y ~ x1 + x2, correlation = corExp(c(-1 / log(phi), .2), form = ~t, nugget = TRUE),
                   data = data.frame(y, x1, x2, t = 1:n), method = "REML"), silent = TRUE)
    if (inherits(fit, "try-error")) next
    p <- coef(fit$modelStruct$corStruct, unconstrained = FALSE)
    if (p["nugget"] > .02 && p["nugget"] < .9 && p["range"] < n / 4) break    # an optimum in the inside
  }
  cat("set", n, fmt(fit$sigma), fmt(1 - p["nugget"]), fmt(p["range"]), fmt(as.numeric(logLik(fit))), sep = ",")
  cat("\n")
  for (i in 1:n) cat(fmt(c(y[i], x1[i], x2[i])), sep = ",", "\n")
}
