#!/usr/bin/env python3
"""Deepest stack from each function given, in bytes: frames by gcc's -fstack-usage files (of the C library's
functions by their pushes), calls by the disassembly; a call through a table of functions reaches what the tables
hold at the offset that was loaded.  Usage: stack.py IMAGE FUNCTION... -- FILE.su..."""
import re
import subprocess
import sys

REGISTER = r"(?:r\d+|sl|fp|ip|lr)"
split = sys.argv.index("--")
image, wanted = sys.argv[1], sys.argv[2:split]
frame, calls, indirect, taken, name, loaded = {}, {}, {}, {}, None, {}
text = subprocess.run(["arm-none-eabi-objdump", "-d", "--no-show-raw-insn", image], check=True,
                      capture_output=True, text=True).stdout
for line in text.splitlines():
    start = re.match(r"([0-9a-f]+) <(.+)>:$", line)
    if start:
        name = start[2]
        frame[name], calls[name], indirect[name], loaded = 0, set(), set(), {}
        continue
    words = line.split("\t")
    if len(words) < 3 or name is None:
        continue
    op, rest = words[1].strip(), words[2]
    if op.startswith(("push", "vpush", "stmdb")) and (op != "stmdb" or rest.startswith("sp!")):
        registers = 0
        for first, last in re.findall(r"([rdsl]\w*?)(?:-([rds]\d+))?(?=[,}])", rest[rest.index("{") + 1:]):
            registers += int(last[1:]) - int(first[1:]) + 1 if last else 1
        frame[name] += registers * (8 if op.startswith("vpush") and "d" in rest else 4)
    elif op.startswith("sub") and re.match(r"sp, (sp, )?#\d+", rest):
        frame[name] += int(re.search(r"#(\d+)", rest)[1])
    if op.startswith(("bl", "b.", "b")) and not op.startswith(("bic", "bfi", "bfc", "bkpt")):
        to = re.search(r"<([^+>]+)>", rest)
        if to and to[1] != name:
            calls[name].add(to[1])
        elif op.startswith("blx") or (op == "bx" and rest.strip() != "lr"):
            indirect[name].add(loaded.get(rest.split()[0]))
    load = re.match(rf"({REGISTER}), \[{REGISTER}(?:, #(\d+))?\]", rest) if op in ("ldr", "ldr.w") else None
    if load:
        loaded[load[1]] = int(load[2] or 0)
    elif op.startswith(("bl", "ldrd", "ldm", "pop")):  # a call spoils r0 to r3; ranges are of others
        spoilt = re.findall(REGISTER, rest + " r0 r1 r2 r3 ip lr" * op.startswith("bl"))
        loaded = {k: v for k, v in loaded.items() if k not in spoilt}
    elif op == "mov":
        to, of = (word.strip() for word in rest.split(",")[:2])
        loaded[to] = loaded.get(of)
    elif not op.startswith(("cmp", "cb", "str", "tst", "b")):
        loaded.pop(rest.split(",")[0].strip(), None)
own = {}
for path in sys.argv[split + 1:]:
    for line in open(path):
        where, size, _ = line.rstrip("\n").split("\t")
        own[where.rsplit(":", 1)[1]] = max(own.get(where.rsplit(":", 1)[1], 0), int(size))
for function in frame:  # gcc's clones: f.part.0, f.constprop.0
    frame[function] = own.get(function, own.get(function.split(".")[0], frame[function]))

# What the table of effects points to can be called wherever a call is indirect.
addresses = {}
for line in subprocess.run(["arm-none-eabi-nm", image], check=True, capture_output=True, text=True).stdout.splitlines():
    parts = line.split()
    if len(parts) == 3 and parts[1] in "tT":
        addresses.setdefault(int(parts[0], 16) | 1, parts[2])
raw = subprocess.run(["arm-none-eabi-objcopy", "-O", "binary", "-j", ".text", image, "/dev/stdout"], check=True,
                     capture_output=True).stdout
objects = [line.split() for line in subprocess.run(["arm-none-eabi-nm", "-S", image], check=True, capture_output=True,
                                                   text=True).stdout.splitlines()]
start = next(int(line.split()[3], 16) for line in subprocess.run(
    ["arm-none-eabi-objdump", "-h", image], check=True, capture_output=True, text=True).stdout.splitlines()
    if line.split()[1:2] == [".text"])
for parts in objects:
    if len(parts) == 4 and (parts[3].endswith("_effect") or parts[2] in "rR"):
        begin, size = int(parts[0], 16), int(parts[1], 16)
        for at in range(begin - start, begin - start + size - 3, 4):
            to = addresses.get(int.from_bytes(raw[at:at + 4], "little")) if at >= 0 else None
            if to and parts[3] != "vectors":
                taken.setdefault(at - begin + start, set()).add(to)


def deepest(function, path=()):
    if function in path:
        sys.exit("stack.py: recursion: " + " ".join(path + (function,)))
    below = [deepest(to, path + (function,)) for to in sorted(calls.get(function, ()))]
    for offset in indirect.get(function, ()):  # of an unknown one: all
        reached = taken.get(offset) or set().union(*taken.values())
        below += [deepest(to, path + (function,)) for to in sorted(reached) if to not in path and to != function]
    size, way = max(below, default=(0, ()))
    return frame.get(function, 0) + size, (function,) + way


for function in wanted:
    size, way = deepest(function)
    print(size, function, " > ".join(f"{f} {frame.get(f, 0)}" for f in way))
