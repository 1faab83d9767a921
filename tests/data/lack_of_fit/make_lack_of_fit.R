# Pure error and lack of fit by R: the model against one mean per distinct setting (Draper and Smith, section 2.1).
#   Rscript make_lack_of_fit.R > golden.csv
# Lines: set,<rows>,<degree>,<pure error sd>,<F>,<p>; then y,x,z per row. Model: y ~ poly of x up to the degree + z.
suppressWarnings(RNGkind("Mersenne-Twister", "Inversion", "Rejection"))
set.seed(1981)
fmt <- function(v) formatC(v, digits = 15, format = "g")
for (case in 1:12) {
  degree <- 1 + case %% 2
  x <- rep(seq(-2, 2, length.out = 5 + case %% 3), each = sample(3:5, 1)); z <- rep_len(0:1, length(x))
  o <- sample(length(x)); x <- x[o]; z <- z[o]
  y <- round(1 + 2 * x + (case > 6) * .4 * x^3 + .5 * z + rnorm(length(x)), 6)
  full <- lm(y ~ factor(paste(x, z)))
  fit <- lm(if (degree == 1) y ~ x + z else y ~ x + I(x^2) + z)
  a <- anova(fit, full)
  cat(paste(c("set", length(x), degree, fmt(c(summary(full)$sigma, a$F[2], a[["Pr(>F)"]][2]))), collapse = ","), "\n", sep = "")
  for (i in seq_along(x)) cat(paste(fmt(c(y[i], x[i], z[i])), collapse = ","), "\n", sep = "")
}
