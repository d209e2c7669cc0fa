#!/usr/bin/env python3
"""make figures: write the figures of README and docs/comparison.md by the commands that measure them.

A block of a document, from `<!-- figures NAME ...` to `<!-- end NAME -->`, is the output of one
function below; its first line says command, date and machine. Blocks of a fenced text are written
without marks: README's screen of data/panda and diagnosis.md's of data/demo. --check writes nothing and fails where
a deterministic figure differs (what needs the published data is left out, with a line, where they
are not); --times PART... (make figures TIMES="fit growth") writes these parts of make bench instead, which CI cannot compare.
"""
import datetime
import json
import os
import re
import subprocess
import sys

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "bench")]
import verify_real as real  # noqa: E402
import verify_real_diagnosis as diagnosis  # noqa: E402

CHECK = "--check" in sys.argv
wrong = 0


def processor():
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        names = re.findall(r"^model name\s*: (.*)$", file.read(), re.M)
    return f"{len(names)} cores of {names[0] if names else 'an unknown processor'}"


def differs(path, what):
    global wrong
    wrong += 1
    print(f"not ok figures: {path}: {what} differs from its source; run make figures", file=sys.stderr)


def write(path, name, command, content):
    """Replace the block, with date and machine where its content changed."""
    with open(path, encoding="utf-8") as file:
        text = file.read()
    found = re.search(rf"<!-- figures {name}\b[^\n]*-->\n(.*?)<!-- end {name} -->", text, re.S)
    if not found:
        sys.exit(f"figures: {path} has no block {name}")
    if found[1] == content:
        print(f"ok figures: {path}: {name}")
    elif CHECK:
        differs(path, name)
    else:
        stamp = f"<!-- figures {name}: {command}; {datetime.date.today()}, {processor()} -->\n"
        with open(path, "w", encoding="utf-8") as file:
            file.write(text[:found.start()] + stamp + content + f"<!-- end {name} -->" + text[found.end():])


def printed_by(command, data):
    return subprocess.run([real.MUKCA, command, "--urdf", f"{data}/arm.urdf", f"{data}/train.tsv", "--test",
                           f"{data}/test.tsv"], capture_output=True, text=True, check=True).stdout


def screen(path, data):
    """A screen of a diagnosis, or successive lines of it, as the command prints them."""
    printed = printed_by("diagnose", data).splitlines()
    with open(path, encoding="utf-8") as file:
        text = file.read()
    for block in re.findall(r"```text\n(.*?)```", text, re.S):
        if "held out (" not in block:
            continue
        keys = [re.sub(r"[\d.]+.*", "#", line) for line in printed]
        ends = [re.sub(r"[\d.]+.*", "#", line) for line in (block.splitlines()[0], block.splitlines()[-1])]
        first = keys.index(ends[0]) if ends[0] in keys else -1
        last = len(keys) - 1 - keys[::-1].index(ends[1]) if ends[1] in keys else -1  # the last of these lines
        lines = "\n".join(printed[first:last + 1]) + "\n"
        if lines == block:
            print(f"ok figures: {path}: screen")
        elif CHECK or first < 0 or last < first:
            differs(path, "screen")
        else:
            with open(path, "w", encoding="utf-8") as file:
                file.write(text.replace(block, lines))


def table_one():
    rows, results = [], {}
    for name, urdf, robot, place, _, _ in real.TABLE_I:
        train = [f"{robot}/{place}"]
        test = [p for p in real.placements(robot) if p not in train]
        r = real.calibrate(urdf, train, test, "slsqp", "fd")
        mm = [1e3 * real.mean(r[part], key) for part in ("train", "test") for key in ("mae_nominal_m", "mae_m")]
        results[name] = mm
        rows.append(f"| {name} | {mm[0]:.3f} | {mm[1]:.3f} | {mm[2]:.3f} | {mm[3]:.3f} |\n")
    write("docs/comparison.md", "table-1", "make figures", "| robot | training: nominal | calibrated | test: nominal | "
          "calibrated |\n| --- | ---: | ---: | ---: | ---: |\n" + "".join(rows))
    franka = [mm for name, mm in results.items() if not name.startswith("KUKA")]
    spans = [(min(m[i] for m in franka), max(m[i] for m in franka)) for i in (2, 3)]
    write("README.md", "first", "make figures",
          "mukca calibrates robot arms with a printed tool: on new data of three published Franka arms, "
          f"{spans[0][0]:.1f} to {spans[0][1]:.1f} mm of error become {spans[1][0]:.2f} to {spans[1][1]:.2f} mm.\n")


def gain():
    rows = []
    for robot, urdf, masses, _, _ in diagnosis.ROBOTS:
        places = [os.path.join(real.DATA, p) for p in real.placements(robot)]
        more = ["--inertials", os.path.join(real.DATA, masses)] if masses else []
        d, _ = diagnosis.diagnose(os.path.join(real.DATA, urdf + ".urdf"), *more, *places)
        gap, found = d["gap"], d["findings"]
        words = [f"{f['sentence']} ({1e3 * f['size_m']:.3f} mm)" for f in found[:3]]
        counts = f"; {len(found) - 3} more" if len(found) > 3 else ""
        with_causes = f"{1e3 * gap['explained_m']:.3f}" if d["causes"] else "–"
        rows.append(f"| {robot} | {d['verdict']} | {1e3 * gap['nominal_m']:.3f} | {1e3 * gap['geometry_m']:.3f} | "
                    f"{1e3 * gap['faults_excused_m']:.3f} | {with_causes} | {1e3 * gap['noise_floor_m']:.3f} | "
                    f"{'; '.join(words) or 'none'}{counts} |\n")
    write("docs/comparison.md", "gain", "make figures", "| robot | verdict | nominal | geometry | faulty samples excluded | "
          "with causes | noise floor | largest findings (rms at the tip) |\n"
          "| --- | --- | ---: | ---: | ---: | ---: | ---: | --- |\n" + "".join(rows))


def times(parts):
    for part in parts:
        done = subprocess.run([sys.executable, os.path.join(HERE, "bench/run.py"), part], capture_output=True, text=True, check=True)
        lines = [line for line in done.stdout.splitlines()[1:] if " plot: " not in line and "SKIPPED" not in line]
        write("docs/comparison.md", f"times-{part}", f"make figures TIMES={part}; load {os.getloadavg()[2]:.0f}",
              "```text\n" + "\n".join(lines).strip("\n") + "\n```\n")


if "--times" in sys.argv:
    sys.exit(times(sys.argv[sys.argv.index("--times") + 1:]))
screen("README.md", "data/panda")
screen("docs/diagnosis.md", "data/demo")
if os.path.isdir(real.DATA):
    table_one()
    if not CHECK or os.environ.get("MUKCA_LONG"):
        gain()
else:
    print(f"SKIPPED figures of the published arms: no data in {real.DATA}; set MUKCA_REAL_DATA")
sys.exit(wrong > 0)
