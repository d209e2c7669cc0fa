"""Every command with one failing call: the outputs are the usual ones, or the exit code says that they are not.

After SQLite's tests of failing allocations and writes.  MUKCA_LONG=1: every call, else some of each kind.
FAULT_COMMANDS: only these commands."""
import collections
import concurrent.futures
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading

MUKCA, ROOT, SHIM = os.environ["MUKCA"], os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), \
    os.environ["FAULT_SHIM"]
DEMO = os.path.join(ROOT, "data", "demo")
ARM = ["--urdf", os.path.join(DEMO, "arm.urdf")]
LONG = os.environ.get("MUKCA_LONG")
SOME = {"malloc": 16}  # of each kind in the short run
MOST = {"report": 40}  # slow: in full, so many of each kind
KINDS = ("malloc", "open", "write", "fsync", "rename", "truncate")
LOG = ["--lcm-url", "file://" + os.path.join(DEMO, "guided.lcmlog")]
OLD = b"an earlier result\n"


def commands(inputs):
    """{name: (arguments, files that grow while they are written)}"""
    data, offsets = os.path.join(inputs, "data.tsv"), os.path.join(inputs, "offsets.tsv")
    poses = os.path.join(inputs, "poses.tsv")
    few = os.path.join(inputs, "few.tsv")
    return {
        "calibrate": (["calibrate", *ARM, data, "-o", "o.tsv", "--json", "o.json"], ()),
        "evaluate": (["evaluate", *ARM, data, "-o", "o.tsv", "--json", "o.json"], ()),
        "diagnose": (["diagnose", *ARM, data, "-o", "o.tsv", "--json", "o.json"], ()),
        "recalibrate": (["recalibrate", *ARM, poses, "-o", "o.tsv", "--json", "o.json"], ()),
        "compensate": (["compensate", *ARM, "--offsets", offsets, few, "-o", "o.tsv", "--json", "o.json"], ()),
        "fk": (["fk", *ARM, "--offsets", offsets, "--pose", few], ()),
        "export urdf": (["export", *ARM, "--offsets", offsets, "-o", "o.urdf"], ()),
        "export mjcf": (["export", *ARM, "--offsets", offsets, "--format", "mjcf"], ()),
        "export c": (["export", *ARM, "--offsets", offsets, "--format", "c", "-o", "o.h"], ()),
        "plan": (["plan", *ARM, data, "--rows", "2", "-o", "o.tsv", "--json", "o.json"], ()),
        "simulate": (["simulate", *ARM, "--rows", "2", "--placements", "2", "--held-out", "1", "--test", "test.tsv",
                      "--truth", "t.tsv", "-o", "o.csv"], ()),
        "report": (["report", *ARM, data, "-o", "o.html"], ()),
        "capture": (["capture", *ARM, *LOG, "--trigger", "-o", "o.tsv", "--json", "o.json"],
                    ("o.tsv",)),
        "serve": (["serve", *ARM, *LOG, "--state", "state"],
                  ("state/sessions/guided.tsv", "state/lock", "state/state.tsv")),
        "help": (["help", "diagnose"], ()),
        "options": (["help", "options"], ()),
    }


def prepare(inputs):
    """Small data."""
    def run(*arguments):
        subprocess.run([MUKCA, *arguments], cwd=inputs, check=True, capture_output=True)
    run("simulate", *ARM, "--placements", "2", "--rows", "9", "--perturb", "1,2", "--noise", "1e-4", "-o", "data.tsv")
    run("simulate", *ARM, "--poses", "60", "--perturb", "1,2", "--noise", "1e-4", "-o", "poses.tsv")
    run("simulate", *ARM, "--placements", "1", "--rows", "2", "-o", "few.tsv")
    run("calibrate", *ARM, "data.tsv", "-o", "offsets.tsv")


def normal(data):
    """Without what differs from run to run: times, processes."""
    data = re.sub(rb'"(elapsed_s|rows_to_name)": [0-9.e+-]+', rb'"\1": 0', data)
    return data.replace(b" --force", b"")  # the page's own command


def run(arguments, folder, old, **faults):
    """Exit code, {path: content}, standard error; `old` are files that are there before."""
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    for path in old:
        os.makedirs(os.path.dirname(os.path.join(folder, path)), exist_ok=True)
        with open(os.path.join(folder, path), "wb") as f:
            f.write(OLD)
    environment = dict(os.environ, SOURCE_DATE_EPOCH="0", LD_PRELOAD=SHIM, TMPDIR=folder + ".tmp", **faults)
    with open(folder + ".out", "wb") as out:
        p = subprocess.run([MUKCA, *arguments, *(["--force"] if old else [])], cwd=folder, env=environment,
                           stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.PIPE, timeout=120)
    found = {}
    for top, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(top, name)
            with open(path, "rb") as f:
                found[os.path.relpath(path, folder)] = normal(f.read())
    with open(folder + ".out", "rb") as f:
        found["standard output"] = normal(f.read())
    return p.returncode, found, p.stderr


def whole(path, content):
    try:
        return content.endswith(b"\n") if path.endswith(".tsv") else bool(json.loads(content))
    except ValueError:
        return False


def wrong(outcome, usual, grows, old):
    """What is wrong with the outcome of a run with a fault; None: nothing."""
    (code, found, said), (usual_code, wanted, _) = outcome, usual
    if code < 0:
        return "ended by signal %d" % -code
    if code == usual_code:
        for path in sorted(set(found) | set(wanted)):
            if found.get(path) != wanted.get(path) and path != "state/lock":
                return "exit code %d, but %s differs (%s bytes instead of %s)" % (
                    code, path, len(found.get(path, b"")), len(wanted.get(path, b"")))
        return None
    if code != 6:
        return "exit code %d: %s" % (code, said.strip().splitlines()[-1:])
    if not said.strip():
        return "exit code %d without a message" % code
    for path, content in found.items():
        if path == "standard output" or path in grows or content == wanted.get(path):
            continue
        if path in old and content == OLD:
            continue
        if grows and (path == "o.json" or path.startswith("state/results")) and whole(path, content):
            continue  # of the samples that were recorded
        if path not in wanted:
            return "exit code %d, and %s is left" % (code, path)
        return "exit code %d, and %s is cut off (%d bytes)" % (code, path, len(content))
    for path in grows:
        if path in found and path.endswith(".tsv") and path != "state/state.tsv":
            usual_lines = iter(wanted[path].splitlines())  # a line may be missing, as was reported
            if not all(line in usual_lines for line in found[path][:found[path].rfind(b"\n") + 1].splitlines()):
                return "exit code %d, and %s has other lines" % (code, path)
    return None


def check(name, arguments, grows, folder, pool):
    """Run one command with its faults; the findings."""
    counts_file = folder + ".counts"
    usual = run(arguments, folder, (), FAULT_COUNT=counts_file)
    if usual[0] not in (0, 1):
        print("not ok %s: exit code %d without a fault: %s" % (name, usual[0], usual[2]))
        return ["usage"]
    with open(counts_file) as f:
        counts = {k: int(n) for k, n in (line.split() for line in f)}
    old = [path for path in usual[1] if "/" not in path and path not in grows and path != "standard output"]
    work, local = [], threading.local()
    for kind in KINDS:
        most = counts[kind] if LONG else SOME.get(kind, 4)
        if LONG:
            most = min(most, MOST.get(name, most))
        for i in range(min(counts[kind], most)):
            n = 1 + i * counts[kind] // min(counts[kind], most)
            variants = [(lasting, kept) for lasting in ("", "+") for kept in ((), old)]
            if not LONG or kind == "malloc":  # in turn
                variants = variants[i % 4:i % 4 + 1]
            work += [("%s:%d%s" % (kind, n, lasting), kept) for lasting, kept in variants]
    codes, findings = collections.Counter(), []

    def one(job):
        fault, kept = job
        if not hasattr(local, "folder"):
            local.folder = tempfile.mkdtemp(dir=os.path.dirname(folder))
            os.makedirs(os.path.join(local.folder, "run.tmp"))
        try:
            outcome = run(arguments, os.path.join(local.folder, "run"), kept, FAULT=fault)
        except subprocess.TimeoutExpired:
            return -99, "%s: hangs" % fault
        problem = wrong(outcome, usual, grows, kept)
        return outcome[0], problem and "%s%s: %s" % (fault, " over old files" if kept else "", problem)
    for code, problem in pool.map(one, work):
        codes[code] += 1
        if problem:
            findings.append(problem)
    print("%s %s: %d faults of %s calls, exit codes %s" % (
        "not ok" if findings else "ok", name, len(work), "/".join(str(counts[k]) for k in KINDS), dict(codes)))
    for problem in findings[:12]:
        print("    " + problem)
    sys.stdout.flush()
    return findings


def main():
    with tempfile.TemporaryDirectory() as work, concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        inputs = os.path.join(work, "inputs")
        os.makedirs(inputs)
        os.makedirs(os.path.join(work, "run.tmp"))
        prepare(inputs)
        only = os.environ.get("FAULT_COMMANDS")
        bad = [name for name, (arguments, grows) in commands(inputs).items()
               if (not only or name in only.split(",")) and
               check(name, arguments, grows, os.path.join(work, "run"), pool)]
    sys.exit(1 if bad else 0)


main()
