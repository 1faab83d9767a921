# Rscript read_by_r.R > read_by_r.csv: every column as R reads it, to hold `driftwise data import` against.
# rows put in order of time for series A; rank-weighted sums notice a row in the wrong place.
options(digits = 17)
cat("series,column,rows,sum,sum_of_squares,weighted_sum,first,last\n")
for (series in c("series_a_grid", "series_d_iso_cubes")) {
  d <- read.csv2(gzfile(paste0(series, ".csv.gz")), check.names = FALSE,
                 colClasses = c(Timestamp = "character"))
  if (series == "series_a_grid") d <- d[order(d$Timestamp), ]
  for (name in names(d)[-1]) {
    v <- d[[name]]
    cat(series, name, length(v), format(sum(v), digits = 17), format(sum(v^2), digits = 17),
        format(sum(v * seq_along(v)), digits = 17), format(v[1], digits = 17),
        format(v[length(v)], digits = 17), sep = ",")
    cat("\n")
  }
  if (series == "series_a_grid") {
    t <- as.numeric(as.POSIXct(d$Timestamp, format = "%Y%m%d%H%M%S", tz = "UTC"))
    t <- t - t[1]
    cat(series, "Timestamp", length(t), format(sum(t), digits = 17), format(sum(t^2), digits = 17),
        format(sum(t * seq_along(t)), digits = 17), t[1], t[length(t)], sep = ",")
    cat("\n")
  }
}
