"""Forward kinematics of the demo arm beside CasADi's generated C, Pinocchio and KDL, on the same angles."""
import array
import os
import random
import shutil
import subprocess

from common import BUILD, HERE, MUKCA, REPEATS, goal, output, python_with

URDF, TIP, JOINTS, ROWS = "data/demo/arm.urdf", "ball_link", 7, 1000  # ROWS of a repeat, as in bench_fk.c
CC, CXX = os.environ.get("CC", "gcc").split(), os.environ.get("CXX", "g++").split()
# as its CMake files have them
PINOCCHIO_DEFINES = ["-DBOOST_MPL_LIMIT_LIST_SIZE=30", "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
                     "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS", "-DBOOST_FUSION_INVOKE_MAX_ARITY=12",
                     "-DPINOCCHIO_ENABLE_TEMPLATE_INSTANTIATION"]


def angles(path, repeats):
    numbers = random.Random(1)
    with open(path, "wb") as f:
        array.array("d", [numbers.uniform(-2, 2) for _ in range(repeats * ROWS * JOINTS)]).tofile(f)


def casadi_library(folder):
    """The compiled functions' file in a list, empty where CasADi is not to be had."""
    python = python_with("casadi", "numpy")
    if not python:
        print("  SKIPPED CasADi: it cannot be installed")
        return []
    source, library = (os.path.join(folder, name) for name in ("casadi_fk.c", "casadi_fk.so"))
    output(python, os.path.join(HERE, "casadi_fk.py"), URDF, TIP, source)
    output(*CC, "-O3", "-fPIC", "-shared", "-o", library, source, "-lm")
    return [library]


def pinocchio_program(name, level, packages, *libraries):
    """Path of a program built against Pinocchio from PyPI, which compiles for a minute or two; None where it is not to be had."""
    python = python_with("pinocchio", packages=["pin", "cmeel-eigen", *packages])
    if not python:
        print(f"  SKIPPED {name}: {', '.join(['pin', *packages])} cannot be installed")
        return None
    module = output(python, "-c", "import pinocchio as p, os; print(os.path.abspath(p.__file__))")
    prefix = module.strip().rpartition("/lib/python")[0]
    source, program, lib = os.path.join(HERE, name + ".cc"), os.path.join(BUILD, "bench", name), os.path.join(prefix, "lib")
    sources = source, os.path.join(HERE, "peer_timer.hh")
    if os.path.exists(program) and os.path.getmtime(program) > max(map(os.path.getmtime, sources)):
        return program
    done = subprocess.run(
        [*CXX, "-std=c++17", level, "-DNDEBUG", "-w", *PINOCCHIO_DEFINES, "-isystem", os.path.join(prefix, "include"),
         "-isystem", os.path.join(prefix, "include/eigen3"), "-o", program, source, f"-L{lib}", f"-Wl,-rpath,{lib}",
         "-lpinocchio_parsers", "-lpinocchio_default", "-lurdfdom_model", *libraries], capture_output=True, text=True)
    if done.returncode != 0:
        print(f"  SKIPPED {name}: its headers do not compile here:", done.stderr.strip()[:200])
        return None
    return program


def pinocchio(folder, rows):
    """Lines of the Pinocchio programs, of the library and of the C that it generates; none where they cannot be built."""
    library = pinocchio_program("pinocchio_fk", "-O3", [])
    # it only calls what gcc makes of the generated C, with -O3
    generator = pinocchio_program("pinocchio_codegen", "-O1", ["cmeel-cppad", "cmeel-cppadcodegen"], "-ldl")
    lines = output(library, URDF, TIP, rows) if library else ""
    if generator:
        lines += output(generator, URDF, TIP, rows, folder, shutil.which(CC[-1]))
    return lines


def kdl(folder, rows):
    """Lines of the KDL program; none where Debian's liborocos-kdl-dev is missing."""
    elements, program = os.path.join(folder, "elements.txt"), os.path.join(folder, "kdl_fk")
    python = python_with("numpy")
    if not python:
        print("  SKIPPED KDL: numpy, which reads the URDF for it, cannot be installed")
        return ""
    script = "import sys; from peer import chain_of; [print(k, *o, *a) for k, o, a in chain_of(*sys.argv[1:])]"
    with open(elements, "w") as f:
        f.write(output("env", f"PYTHONPATH={HERE}", python, "-B", "-c", script, URDF, TIP))
    done = subprocess.run([*CXX, "-std=c++17", "-O3", "-DNDEBUG", "-w", "-isystem", "/usr/include/eigen3", "-o", program,
                           os.path.join(HERE, "kdl_fk.cc"), "-lorocos-kdl"], capture_output=True, text=True)
    if done.returncode != 0:
        print("  SKIPPED KDL: it does not compile here (Debian: liborocos-kdl-dev)")
        return ""
    return output(program, elements, rows)


# words, name, goal of the ratio to the yardstick
LINES = (
    ("seven times the C library's sincos: the yardstick", "yardstick", None),
    ("position, many rows in one call", "positions", 0.4),
    ("position, one by one", "position", 1),
    ("  CasADi's generated C, parameters folded into the code", "casadi_position", None),
    ("  Pinocchio, forwardKinematics and the tip's frame", "pinocchio_position", None),
    ("  C that Pinocchio generates with CppADCodeGen", "pinocchio_generated_position", None),
    ("  KDL, JntToCart", "kdl_position", None),
    ("pose", "pose", None),
    ("pose and geometric Jacobian", "geometric_jacobian", 1.5),
    ("  Pinocchio, computeFrameJacobian", "pinocchio_jacobian", None),
    ("  C that Pinocchio generates: Jacobian alone", "pinocchio_generated_jacobian", None),
    ("  KDL, JntToCart and JntToJac", "kdl_jacobian", None),
    (f"position and Jacobian by {6 * (JOINTS + 1)} parameters", "jacobian", None),
    ("  CasADi's generated C", "casadi_jacobian", None),
    ("  the same, parameters folded into the code", "casadi_jacobian_constant", None),
    (f"  Pinocchio, kinematic regressor of {6 * JOINTS} parameters", "pinocchio_regressor", None),
    ("pose with every kind of effect (19)", "corrected_pose", None),
    ("pose and Jacobian with every kind of effect", "corrected_jacobian", 4),
)


def main():
    folder = os.path.join(BUILD, "bench")
    rows, table, repeats = os.path.join(folder, "angles.bin"), os.path.join(folder, "effects.tsv"), 3 * REPEATS
    print(f"\nforward kinematics, {URDF}, {JOINTS} joints, {ROWS} configurations, {repeats} runs: medians, and ratios to the"
          " yardstick, timed in the same repeats, with their quartiles")
    angles(rows, repeats)
    with open(table, "w") as f:
        f.write(output(os.path.join(HERE, "../cross/m7/table"), MUKCA))
    ours = output(os.path.join(folder, "bench_fk"), URDF, rows, table, *casadi_library(folder))
    theirs = pinocchio(folder, rows) + kdl(folder, rows)
    values = {name: [float(n) for n in numbers] for name, *numbers in map(str.split, (ours + theirs).splitlines())}
    checks = [line.split()[1:] for line in (ours + theirs).splitlines() if line.startswith("check")]
    if any(not abs(float(a) - float(b)) <= 1e-6 for other in checks[1:] for a, b in zip(checks[0], other)):
        raise SystemExit("bench: a peer's positions are not ours")
    for words, name, limit in LINES:
        if name not in values:
            continue
        ns, ratio, lower, upper = values[name]
        print(f"  {words:62}{ns:9.1f} ns{ratio:8.2f}  [{lower:.2f}, {upper:.2f}]{goal(ratio, limit)}")
    if "casadi_jacobian_constant" in values:
        ratio = values["jacobian"][1] / values["casadi_jacobian_constant"][1]
        print(f"  {'the Jacobian by parameters over that of the folded code':62}{'':12}{ratio:8.2f}{goal(ratio, 1)}")
