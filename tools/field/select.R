# SuSiE (susieR) on the columns of sealed cases, and, with STEPWISE=1, stepwise BIC (stats::step).
#
# usage: [STEPWISE=1] Rscript select.R CASE...   CASE.tsv, CASE.f64 of `columns`; CASE.r gets lines
#   METHOD  seconds  SECONDS          (processor time)
#   METHOD  NUMBER   ITEM,ITEM,...    a selected group, items as in CASE.tsv
suppressMessages(library(susieR))

# Columns without those for errors of the masses, whose prior these methods cannot express.
read_case <- function(path) {
  label <- read.delim(paste0(path, ".tsv"), colClasses = c(effect = "character"))
  size <- file.info(paste0(path, ".f64"))$size
  rows <- t(matrix(readBin(paste0(path, ".f64"), "double", size / 8), nrow(label) + 2))
  X <- rows[, -(1:2), drop = FALSE]
  keep <- label$term < label$own & colSums(X^2) > 1e-12 * max(colSums(X^2))
  list(y = rows[, 2], X = X[, keep, drop = FALSE], item = label$item[keep],
       observed = sum(rows[, 1] >= 0))
}

# From the empty model, items are added and dropped while that lowers the BIC, at most 12 times.
stepwise <- function(case) {
  items <- unique(case$item)
  data <- list(y = case$y)
  for (i in items) data[[paste0("i", i)]] <- case$X[, case$item == i, drop = FALSE]
  scope <- reformulate(c("0", paste0("i", items)), "y")
  found <- step(lm(y ~ 0, data), scope = list(lower = y ~ 0, upper = scope), trace = 0,
                direction = "both", k = log(case$observed), steps = 12)
  as.list(sub("i", "", attr(terms(found), "term.labels")))
}

# Credible sets of 95 %.
single_effects <- function(case) {
  fit <- susie(case$X, case$y, L = 10, intercept = FALSE)
  lapply(fit$sets$cs, function(columns) paste(unique(case$item[columns]), collapse = ","))
}

for (path in commandArgs(TRUE)) {
  case <- read_case(path)
  out <- file(paste0(path, ".r"), "w")
  note <- function(method, run) {
    groups <- list()
    took <- system.time(groups <- run(), gcFirst = FALSE)
    cat(method, "seconds", took[["user.self"]] + took[["sys.self"]], sep = "\t", file = out)
    cat("\n", file = out)
    for (g in seq_along(groups)) cat(method, "\t", g, "\t", groups[[g]], "\n", sep = "", file = out)
  }
  note("susie", function() single_effects(case))
  if (nzchar(Sys.getenv("STEPWISE"))) note("bic of R", function() stepwise(case))
  close(out)
}
