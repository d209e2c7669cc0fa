#!/usr/bin/env python3
"""Compare the image's numbers with the host's, print its figures, and hold them to their budgets."""
import struct
import sys

out = sys.argv[1]
CODE, RAM, STACK = 48 * 1024, 24 * 1024, 4 * 1024  # budgets, bytes


def read(path):
    rows = []
    for line in open(path):
        label, *words = line.split()
        rows.append((label, [struct.unpack(">d", bytes.fromhex(word))[0] for word in words]))
    return rows


board, host = read(out + "/m7.out"), read(out + "/host.out")
compared = [row for row in host if row[0] in ("position", "rotation", "translation", "jacobian")]
figures = {label: values for label, values in board if label not in ("position", "rotation", "translation", "jacobian")}
largest, same = 0.0, len(board) == len(host) and len(compared) == 4000
for (label, mine), (wanted, theirs) in zip(board, host):
    if wanted in ("position", "rotation", "translation", "jacobian"):
        same = same and label == wanted and len(mine) == len(theirs)
        for a, b in zip(mine, theirs):
            largest = max(largest, abs(a - b)) if a == a and b == b else float("nan")
sizes = {}
for line in open(out + "/size.txt"):
    words = line.split()
    if len(words) == 3 and words[1].isdigit():
        sizes[words[0]] = int(words[1])
code = sizes[".vectors"] + sizes[".text"] + sizes.get(".ARM.exidx", 0) + sizes[".data"]
ram = sizes[".data"] + sizes[".bss"]
stacks = [(int(line.split()[0]), line.split()[1], line.split(" ", 2)[2].strip()) for line in open(out + "/stack.txt")]
stack = max(size for size, name, _ in stacks if name != "main")
whole = max(size for size, _, _ in stacks)
painted = int(figures["stack"][0])

print(f"1000 configurations, {int(figures['effects'][0])} effects: largest difference from the host {largest:.1e} (m, rad, m/rad)")
print(f"code and constants {code} bytes, the C library's part and the test included (budget {CODE})")
print(f"static RAM {ram} bytes, of it the arm {int(figures['model'][0])}; with {STACK} of stack {ram + STACK} (budget {RAM})")
print(f"deepest stack {stack} bytes by the call graph (budget {STACK}); with the test {whole}, overwritten {painted}")
for size, name, way in stacks:
    print(f"    {size:5d} {name.split('_10_7')[0]}: {way}")
print(f"instructions: reading the table {figures['parse'][0]:.0f}")
for i, name in enumerate(("position", "pose", "jacobian")):
    print(f"    {name}: mean {figures['mean'][i]:.0f}, most {figures['most'][i]:.0f}")
checks = [
    ("equal to the host to 1e-12", same and largest < 1e-12),
    ("code within its budget", code <= CODE),
    ("memory within its budget", ram + STACK <= RAM),
    ("stack within its budget", stack <= STACK and painted <= whole),
]
for name, good in checks:
    print("ok" if good else "not ok", name)
failed = sum(not good for _, good in checks)
print(f"{len(checks) - failed} passed, {failed} failed")
sys.exit(failed > 0)
