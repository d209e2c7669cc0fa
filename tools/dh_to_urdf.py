#!/usr/bin/env python3
"""The URDF of an arm of which only a Denavit-Hartenberg table is known.

    tools/dh_to_urdf.py TABLE [--format dh|mdh] [--units deg,mm] >arm.urdf

The table (separated by tabs, commas, spaces, or semicolons with decimal commas) has the columns joint, a,
alpha, d and theta, and may have type (revolute, continuous, prismatic, fixed; default: revolute), lower and
upper. Angles may be multiples of pi. Row by row, the pose of the tip is the product of
    standard  Rz(theta + q) Tz(d) Tx(a) Rx(alpha)
    modified  Rx(alpha) Tx(a) Rz(theta + q) Tz(d)
A fixed row before the first joint places the base, one behind the last joint the tool. It reads
what `mukca export -f dh` and `-f mdh` write, whose comment states the convention.
"""
import argparse
import re
from math import atan2, cos, hypot, pi, sin
from xml.sax.saxutils import quoteattr


def number(text, unit):
    multiple = re.fullmatch(r"([-+]?)([\d.]*)\*?pi(?:/([\d.]+))?", text)
    if not multiple:
        return unit * float(text)
    sign, factor, divisor = multiple.groups()
    return (-pi if sign == "-" else pi) * float(factor or 1) / float(divisor or 1)


def rpy(alpha, theta):
    """Roll, pitch and yaw of Rx(alpha) Rz(theta)."""
    c, s, ca, sa = cos(theta), sin(theta), cos(alpha), sin(alpha)
    flat = hypot(c, ca * s)
    if flat < 1e-12:
        return 0, atan2(-sa * s, flat), atan2(s, ca * c)
    return atan2(sa * c, ca), atan2(-sa * s, flat), atan2(ca * s, c)


def read(path, units):
    """Convention (None: not stated) and rows of the table, m and rad."""
    convention, head, rows = None, None, []
    for line in open(path, encoding="utf-8-sig"):
        if line.startswith("# convention: "):
            convention = line.split()[2]
        if line.startswith("#") or not line.strip():
            continue
        if not head:
            separator = next((s for s in "\t;," if s in line), None)  # ;: of a spreadsheet with decimal commas
        cells = [cell.strip() for cell in line.rstrip("\r\n").split(separator)]
        if separator == ";":
            cells = [cell.replace(",", ".") for cell in cells]
        if not head:
            head = [re.sub("_(m|rad)$", "", name) for name in cells]
            own = [name != cell for name, cell in zip(head, cells)]  # its unit is in its name
            continue
        row = {"type": "revolute"}
        for name, cell, fixed in zip(head, cells, own):
            turns = name in ("alpha", "theta") or name not in ("a", "d") and row["type"] != "prismatic"
            unit = 1 if fixed else units["angle" if turns else "length"]
            if cell:
                row[name] = cell if name in ("joint", "type") else number(cell, unit)
        rows.append(row)
    return convention, rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("table")
    parser.add_argument("--format", choices=("dh", "mdh"), help="mdh: modified")
    parser.add_argument("--units", default="rad,m", help="as in deg,mm")
    o = parser.parse_args()
    units = {"angle": pi / 180 if "deg" in o.units else 1, "length": 1e-3 if "mm" in o.units else 1}
    stated, rows = read(o.table, units)
    modified = (o.format or stated) in ("mdh", "modified")
    if not modified:  # what follows a row's rotation belongs to the next origin
        rows.append({"joint": "flange", "type": "fixed", "a": 0, "alpha": 0, "d": 0, "theta": 0})
    print('<?xml version="1.0"?>\n<robot name="arm">\n  <link name="base_link"/>')
    parent, a, alpha, d = "base_link", 0, 0, 0
    for k, row in enumerate(rows):
        child = "link_%d" % (k + 1) if k + 1 < len(rows) else "tip_link"
        if modified:
            a, alpha, d, along = row["a"], row["alpha"], 0, row["d"]
        else:
            along = 0
        xyz = (a, -sin(alpha) * along, d + cos(alpha) * along)
        limited = "lower" in row and "upper" in row
        kind = "continuous" if row["type"] == "revolute" and not limited else row["type"]
        print(f'  <link name="{child}"/>\n  <joint name={quoteattr(row["joint"])} type="{kind}">\n'
              f'    <parent link="{parent}"/>\n    <child link="{child}"/>\n'
              '    <origin xyz="%r %r %r" rpy="%r %r %r"/>' % (*xyz, *rpy(alpha, row["theta"])))
        if kind != "fixed":
            print('    <axis xyz="0 0 1"/>')
        if kind in ("revolute", "prismatic"):
            print('    <limit lower="%r" upper="%r" effort="0" velocity="0"/>'
                  % (row.get("lower", -1), row.get("upper", 1)))
        print("  </joint>")
        parent, a, alpha, d = child, row["a"], row["alpha"], row["d"]
    print("</robot>")


main()
