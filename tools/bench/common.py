"""What the benches share: commands, times of processes, and Python with packages from PyPI."""
import os
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
BUILD = os.environ.get("BUILD", "build")
MUKCA = os.environ.get("MUKCA", os.path.join(BUILD, "mukca"))
DATA = os.environ.get("MUKCA_REAL_DATA", "../shared/real")
REPEATS = int(os.environ.get("BENCH_REPEATS", "31"))


def goal(value, limit, at_least=False):
    """How a figure compares with its goal, for the end of a line; nothing where there is none."""
    if limit is None:
        return ""
    good = value >= limit if at_least else value <= limit
    return f"   goal {'at least' if at_least else 'at most'} {limit}: {'reached' if good else 'FALLS SHORT'}"


def output(*command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"bench: {command[0]} {command[1]}: {done.stderr.strip()}")
    return done.stdout


def python_with(*modules, packages=None):
    """A Python that has the modules and packages, from build/venv where need be; None where that fails."""
    test = ["-c", f"import {', '.join(modules)}, importlib.metadata as m; [m.version(p) for p in {packages or []}]"]
    venv = os.path.join(BUILD, "venv")
    for python in (sys.executable, os.path.join(venv, "bin", "python3")):
        if os.path.exists(python) and subprocess.run([python, *test], capture_output=True).returncode == 0:
            return python
    if not os.path.exists(python) and subprocess.run([sys.executable, "-m", "venv", venv],
                                                     capture_output=True).returncode != 0:
        return None
    subprocess.run([python, "-m", "pip", "install", "-q", *(packages or modules)], capture_output=True)
    return python if subprocess.run([python, *test], capture_output=True).returncode == 0 else None


def process(repeats, *command):
    """Median wall time and processor time of a command, s, and its peak memory, MiB."""
    seconds, kib, busy = output(os.path.join(BUILD, "bench/bench_process"), repeats, *command).split()
    return float(seconds), float(busy), int(kib) / 1024
