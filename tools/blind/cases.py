"""The program on a case, where the labels are not; shares with Wilson's 95 % intervals."""
import json
import math
import os
import shutil
import subprocess
import tempfile


def call(binary, files, arguments):
    """Run `mukca diagnose` in a folder of its own, for 300 s at most; the answer or None, and what
    went wrong."""
    with tempfile.TemporaryDirectory() as tmp:
        for f in files:
            shutil.copy(f, tmp)
        try:
            p = subprocess.run([binary, "diagnose", "--urdf", "robot.urdf", "--base", "base",
                                "--tip", "ball"] + arguments + ["--json", "-"], cwd=tmp,
                               capture_output=True, text=True, timeout=300)
        except subprocess.TimeoutExpired:
            return None, "time out"
    if p.returncode not in (0, 1):
        return None, f"exit {p.returncode}: {p.stderr.strip()[:200]}"
    try:
        return json.loads(p.stdout), ""
    except ValueError as x:
        return None, f"no JSON: {x} {p.stderr.strip()[-200:]}"


def wilson(hits, n):
    """95 % interval of a share."""
    z, p = 1.959964, hits / n
    mid, half = p + z * z / (2 * n), z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return max(0.0, (mid - half) / (1 + z * z / n)), min(1.0, (mid + half) / (1 + z * z / n))


def share(hits, n):
    if not n:
        return "-"
    low, high = wilson(hits, n)
    return f"{hits}/{n} = {100 * hits / n:.1f} % [{100 * low:.1f}, {100 * high:.1f}]"
