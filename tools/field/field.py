#!/usr/bin/env python3
"""Methods of the field beside the findings, on the same columns of the same sealed cases.

usage: field.py PROGRAM COLUMNS CASES KEEP.json [--limit N] [--withheld N] [--rows N] [--table]

CASES are generate.py's.  Per case, `columns` writes the whitened columns of the program's own
search, with the geometry projected out; these methods select among them:
  stepwise BIC        both directions, by items; select.R has stats::step of R, for comparison
  SuSiE               susieR, ten single effects, credible sets of 95 % (select.R)
  LASSO               scikit-learn's LassoCV, 5 folds by posture, at the least cross-validated
                      error; and at the largest penalty within one standard error of it
A selected cause is a finding of its effect (or of what it varies with) at its place.  A credible set
is one of the finest label that all of its members share: an effect, what they vary with, or a
place, over their stretch.  All are judged like the program's findings (../blind/findings.py).
--rows leaves out cases with more rows than N, on which R takes most of the time.  --withheld repeats
the first N detectable single effects without their effect in the catalogue.  KEEP.json holds the
answers and is continued.  --table: figures from it only.
"""
import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
import warnings

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "blind"))
import findings  # noqa: E402
from cases import call  # noqa: E402
from exam import OTHER_ANSWERS  # noqa: E402

METHODS = {"mukca": "findings of mukca", "bic": "stepwise BIC", "bic of R": "stats::step of R",
           "lasso": "LASSO, least error", "lasso 1se": "LASSO, one standard error", "susie": "SuSiE"}
BATCH = 10      # cases for one start of R: their columns take some 10 MB each


def read_labels(path):
    """Item, is it a column of the effect itself, what it says, and its product with the response."""
    with open(path + ".tsv") as f:
        next(f)
        rows = [line.rstrip("\n").split("\t") for line in f]
    return [(int(r[0]), int(r[1]) < int(r[2]), r[3:7], float(r[7])) for r in rows]


def as_findings(groups, label, n):
    """Groups of items as findings; a group of outliers alone is none, equal ones are one."""
    out = {}
    for items in groups:
        said = [label[i] for i in items if label[i][1] != "outlier"]
        if not said:
            continue
        effects, families = {s[0] for s in said}, {s[1] for s in said}
        at = [findings.position(p, n) for s in said for p in s[2:]]
        ends = [next(p for s in said for p in s[2:] if findings.position(p, n) == x)
                for x in (min(at), max(at))]
        named = len(effects) == 1 and effects != {""}
        kind = "effect" if named else "family" if len(families) == 1 else "place"
        f = {"kind": kind, "effect": said[0][0] if named else None,
             "varies_with": said[0][1] if len(families) == 1 else None,
             "from": ends[0], "to": ends[1]}
        out[tuple(f.values())] = f
    return list(out.values())


def read_rows(path, columns):
    """Items, columns of equal squares, response and postures, without the columns for errors of the
    masses: these methods cannot express their prior."""
    import numpy as np
    table = np.fromfile(path + ".f64").reshape(-1, len(columns) + 2)
    X, y = table[:, 2:], table[:, 1]
    product = np.array([p for *_, p in columns])
    if not np.allclose(X.T @ y, product, rtol=1e-6, atol=1e-6 * np.abs(product).max()):
        sys.exit(f"{path}: the columns are not those of the search")
    size = np.sqrt((X ** 2).sum(axis=0))
    keep = np.array([own for _, own, *_ in columns]) & (size > 1e-6 * size.max())
    item = np.array([i for i, *_ in columns])[keep]
    return item, X[:, keep] / size[keep] * np.sqrt(len(y)), y, table[:, 0]


def lasso(path, columns):
    """Selected items and seconds, at the least error and within one standard error of it."""
    import numpy as np
    from sklearn.linear_model import Lasso, LassoCV
    from sklearn.model_selection import GroupKFold
    warnings.simplefilter("ignore")     # the densest models of the path need not converge
    item, X, y, posture = read_rows(path, columns)
    seen, rest = np.flatnonzero(posture >= 0), np.flatnonzero(posture < 0)
    folds = [(np.concatenate([seen[a], rest]), seen[b]) for a, b in
             GroupKFold(5, shuffle=True, random_state=1).split(seen, groups=posture[seen])]
    start = time.process_time()
    most = np.abs(X.T @ y).max() / len(y)
    # in units of the noise: a fifth of the penalty that no column of noise exceeds
    least = max(1e-3 * most, 0.2 * np.sqrt(2 * np.log(X.shape[1]) / len(y)))
    fit = LassoCV(cv=folds, fit_intercept=False, tol=1e-3,
                  alphas=np.geomspace(most, min(least, most / 2), 40)).fit(X, y)
    error = fit.mse_path_.mean(axis=1)
    spread = fit.mse_path_.std(axis=1, ddof=1) / len(folds) ** 0.5
    best = int(error.argmin())
    sparse = fit.alphas_[np.flatnonzero(error <= error[best] + spread[best])[0]]
    took = time.process_time() - start
    other = Lasso(alpha=sparse, fit_intercept=False).fit(X, y).coef_
    return {name: {"groups": [[int(i)] for i in np.unique(item[c != 0])], "seconds": took}
            for name, c in (("lasso", fit.coef_), ("lasso 1se", other))}


def residuals_left(X, y, columns):
    """Squares that columns leave of y, and their rank."""
    if not len(columns):
        return y @ y, 0
    import numpy as np
    found = np.linalg.lstsq(X[:, columns], y, rcond=1e-7)
    rest = y - X[:, columns] @ found[0]
    return rest @ rest, found[2]


def stepwise(path, columns, most=12):
    """Selected items and seconds of stepwise BIC: as stats::step of R, whose time it does not take.
    From nothing, the item that lowers the BIC most is added or dropped, `most` times at most."""
    import numpy as np
    item, X, y, posture = read_rows(path, columns)
    start, price, n = time.process_time(), np.log((posture >= 0).sum()), len(y)
    blocks = {i: np.flatnonzero(item == i) for i in np.unique(item)}
    chosen, left = [], X.copy()      # left: of the columns by those chosen
    rest, rank = y.copy(), 0
    best = n * np.log(y @ y / n)
    for _ in range(most):
        tried = []
        for i, at in blocks.items():
            if i in chosen:
                continue
            w, v = np.linalg.eigh(left[:, at].T @ left[:, at])
            good = w > 1e-7 * (X[:, at] ** 2).sum() / len(at)
            along = (v.T @ (left[:, at].T @ rest))[good]
            squares = max(rest @ rest - (along ** 2 / w[good]).sum(), 1e-9)
            tried.append((n * np.log(squares / n) + price * (rank + good.sum()), chosen + [i]))
        for i in chosen:
            less = [k for k in chosen if k != i]
            squares, r = residuals_left(X, y, np.concatenate([blocks[k] for k in less] or [[]])
                                        .astype(int))
            tried.append((n * np.log(squares / n) + price * r, less))
        value, group = min(tried, key=lambda t: t[0])
        if value > best - 1e-7:
            break
        best, chosen = value, group
        q, s, _ = np.linalg.svd(X[:, np.concatenate([blocks[k] for k in chosen] or [[]])
                                  .astype(int)], full_matrices=False)
        q = q[:, s > 1e-7 * s[0]] if len(s) else q
        left, rest, rank = X - q @ (q.T @ X), y - q @ (q.T @ y), q.shape[1]
    return {"bic": {"groups": [[int(i)] for i in chosen], "seconds": time.process_time() - start}}


def from_r(path):
    out = {}
    with open(path + ".r") as f:
        for name, key, value in (line.rstrip("\n").split("\t") for line in f):
            one = out.setdefault(name, {"groups": [], "seconds": 0})
            if key == "seconds":
                one["seconds"] = float(value)
            else:
                one["groups"].append([int(i) for i in value.split(",")])
    return out


def children_seconds():
    use = resource.getrusage(resource.RUSAGE_CHILDREN)
    return use.ru_utime + use.ru_stime


def answer_all(a, tasks, kept):
    """Answers of all methods to tasks: key -> (case, effects left out)."""
    keys = [k for k in tasks if k not in kept]
    for start in range(0, len(keys), BATCH):
        with tempfile.TemporaryDirectory() as tmp:
            batch, made = keys[start:start + BATCH], []
            for key in batch:
                case, without = tasks[key]
                files = [os.path.join(a.cases, case, x) for x in ("robot.urdf", "session.tsv")]
                begin = children_seconds()
                answer, why = call(a.program, files, (["--without", without] if without else [])
                                      + ["--threads", "1", "session.tsv"])
                took = children_seconds() - begin
                p = subprocess.run([a.columns, *files, os.path.join(tmp, key)]
                                   + ([without] if without else []), capture_output=True, text=True)
                if answer is None or p.returncode:
                    print(key, why, p.stderr.strip(), file=sys.stderr)
                    continue
                kept[key] = {"mukca": {"findings": answer["findings"], "seconds": took}}
                made.append(key)
            if not made:
                continue
            subprocess.run(["Rscript", os.path.join(HERE, "select.R")]
                           + [os.path.join(tmp, k) for k in made], check=True,
                           stderr=subprocess.DEVNULL)
            for key in made:
                path = os.path.join(tmp, key)
                columns = read_labels(path)
                label = {i: said for i, _, said, _ in columns}
                n = findings.joints_of(os.path.join(a.cases, tasks[key][0], "session.tsv"))
                for name, found in {**from_r(path), **lasso(path, columns),
                                    **stepwise(path, columns)}.items():
                    kept[key][name] = {"findings": as_findings(found["groups"], label, n),
                                       "seconds": found["seconds"]}
        with open(a.keep, "w") as f:
            json.dump(kept, f)
        print(f"{start + len(batch)} of {len(keys)}", flush=True)


def figures(a, labels, kept, tasks, name, withheld):
    """[title, hits, trials] of a method."""
    n = {}

    def count(title, hits, trials=1):
        one = n.setdefault(title, [0, 0])
        one[0] += int(hits)
        one[1] += trials
    for key in sorted(set(tasks) & set(kept)):
        case, without = tasks[key]
        if bool(without) != withheld or name not in kept[key]:
            continue
        joints = findings.joints_of(os.path.join(a.cases, case, "session.tsv"))
        true, said = findings.truths(labels[case], joints), kept[key][name]["findings"]
        good = [findings.right(f, true, joints, said) for f in said]
        beyond = findings.outside(true)
        count("findings right", sum(good), len(said))
        count("right in the catalogue", 0 if beyond else sum(good), 0 if beyond else len(said))
        if labels[case]["detectable"]:
            count("with a finding", bool(said))
            count("with a right one", any(good))
            if not beyond:
                count("exact", any(g and findings.exact(f) for g, f in zip(good, said)))
        elif not true:
            count("accused", bool(said))
        exact_wrong = any(not g and f["kind"] == "effect" for g, f in zip(good, said))
        count("another effect named", exact_wrong)
        count("findings a case", len(said))
    return n


def percent(pair):
    return f"{100 * pair[0] / pair[1]:.1f} ({pair[0]}/{pair[1]})" if pair and pair[1] else "–"


def table(a, labels, kept, tasks):
    """Markdown lines: every method."""
    out = ["| method | right, % of findings | in the catalogue | detectable: a right one, % | exact, % "
           "| no effect: accused, % | withheld: right, % | another effect named, % | findings a case "
           "| s |",
           "| --- |" + " ---: |" * 9]
    for name, title in METHODS.items():
        mine = [k[name]["seconds"] for k in kept.values() if name in k]
        if not mine:
            continue
        plain, held = (figures(a, labels, kept, tasks, name, w) for w in (False, True))
        per = plain["findings a case"]
        out.append("| " + " | ".join(
            [title] + [percent(plain.get(k)) for k in ("findings right", "right in the catalogue",
                                                       "with a right one", "exact", "accused")]
            + [percent(held.get(k)) for k in ("findings right", "another effect named")]
            + [f"{per[0] / per[1]:.1f}", f"{sorted(mine)[len(mine) // 2]:.2f}"]) + " |")
    return "\n".join(out) + "\n"


def main():
    ap = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    for name in ("program", "columns", "cases", "keep"):
        ap.add_argument(name)
    ap.add_argument("--limit", type=int, default=200)
    ap.add_argument("--withheld", type=int, default=60)
    ap.add_argument("--rows", type=int, default=400)
    ap.add_argument("--table", action="store_true")
    a = ap.parse_args()
    a.program, a.columns = os.path.abspath(a.program), os.path.abspath(a.columns)
    with open(os.path.join(a.cases, "labels.json")) as f:
        labels = json.load(f)
    names = [x for x in sorted(labels)
             if labels[x]["rows"] <= a.rows and labels[x]["kind"] not in OTHER_ANSWERS][:a.limit]
    tasks, held = {}, 0
    for name in names:
        tasks[name] = (name, None)
        x = labels[name]
        k = x["effects"][0]["effect"] if x["effects"] else None
        if (x["detectable"] and len(x["effects"]) == 1 and k in findings.FAMILY
                and k not in ("tool_motion", "local_fault") and held < a.withheld):
            one_thing = ("base_compliance", "link_bending")
            tasks[name + "_withheld"] = (name, ",".join(one_thing) if k in one_thing else k)
            held += 1
    kept = {}
    if os.path.exists(a.keep):
        with open(a.keep) as f:
            kept = json.load(f)
    if not a.table:
        answer_all(a, tasks, kept)
    print(table(a, labels, kept, tasks), end="")


if __name__ == "__main__":
    main()
