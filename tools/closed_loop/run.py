"""Proof in the loop: recording, calibration, diagnosis and three tasks on arms of a physics engine.

run.py prints the table beside the paper's and draws docs/closed_loop.png; run.py --short does less and leaves
its picture in build/closed_loop. Exit code 1 where something that the table must show does not hold.
"""
import argparse
import json
import multiprocessing
import os
import subprocess
import sys

import numpy as np

import arm
import recording
import robot
import table
import tasks

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
BUILD = os.environ["BUILD"]
MUKCA = os.environ["MUKCA"]
OUT = os.path.join(BUILD, "closed_loop")
URDF = os.path.join(ROOT, "data", "demo", "arm.urdf")

PLACEMENTS = {"front": ((0.5, 0, 0.15), 0.3), "left": ((0.4, 0.35, 0.25), 1.2), "right": ((0.35, -0.4, 0.12), -0.5)}


def path(name, kind):
    return os.path.join(OUT, "%s-%s" % (name, kind))


def mukca(*arguments, text=None):
    done = subprocess.run([MUKCA, *arguments], capture_output=True, text=True, input=text)
    if done.returncode != 0:
        raise SystemExit("closed loop: mukca %s: %s" % (arguments[0], done.stderr.strip()))
    return done.stdout


def controller(name, model):
    """Arguments of the controller for a model."""
    offsets = path(name, "causes.tsv" if model == "causes" else "geometry.tsv")
    return [offsets] + (["--nominal"] if model == "nominal" else [])


def own_network(job):
    """Each job has a process and an LCM network of its own: an LCM instance goes on receiving while it lives."""
    worker = multiprocessing.current_process()._identity
    os.environ["LCM_DEFAULT_URL"] = "udpm://239.255.76.67:%d?ttl=0" % (7700 + (worker[0] if worker else 0))
    function, *arguments = job
    return function(*arguments)


# ---- jobs ----

def record(name, per_socket):
    """Record and calibrate; the diagnosis."""
    r = robot.Robot(URDF, arm.ARMS[name])
    session = path(name, "session.tsv")
    recording.session(r, MUKCA, URDF, session, PLACEMENTS, per_socket, 7)
    common = ["--urdf", URDF, session, "--force", "-q"]
    mukca("calibrate", *common, "-o", path(name, "geometry.tsv"))
    mukca("diagnose", *common, "-o", path(name, "causes.tsv"), "--json", path(name, "diagnosis.json"))
    with open(path(name, "diagnosis.json")) as f:
        return json.load(f)


def prepared(name):
    """The robot, connected, and the taught angles: of the first hole, and of the end of the X."""
    r = robot.Robot(URDF, arm.ARMS[name])
    r.connect()
    random = np.random.default_rng(11)
    first = tasks.teach(r, tasks.HOLE, random)
    end = tasks.teach(r, tasks.HOLE + [*tasks.cross()[5], 0], random, first)
    return r, first, end, random


def insertions(name, model, n, diameters, part, parts):
    r, first, _, random = prepared(name)
    starts = tasks.postures(r, tasks.HOLE + [0, 0, tasks.HOVER], n, random)
    return [tasks.insert(r, controller(name, model), path(name, "controller.log"), tasks.HOLE, first, q,
                         diameters=diameters) for q in starts[part::parts]]


def tip(name, model, q):
    """The model's tip at joint angles."""
    text = "\t".join("joint_%d" % (i + 1) for i in range(len(q))) + "\n" + "\t".join("%.17g" % x for x in q) + "\n"
    offsets = [] if model == "nominal" else ["--offsets", controller(name, model)[0]]
    lines = [x for x in mukca("fk", "--urdf", URDF, *offsets, text=text).splitlines() if not x.startswith("#")]
    return np.array([float(x) for x in lines[-1].split("\t")[-3:]])


def crossing(name, model, holes, part, parts):
    """The 24 holes: offsets turned by the direction from the first hole to the end of the X."""
    r, first, end, random = prepared(name)
    offsets = tasks.cross()[:holes]
    starts = [tasks.postures(r, tasks.HOLE + [*o, tasks.HOVER], 1, random)[0] for o in offsets]
    along, true = tip(name, model, end)[:2] - tip(name, model, first)[:2], tasks.cross()[5]
    a = np.arctan2(along[1], along[0]) - np.arctan2(true[1], true[0])
    turn = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    return [tasks.insert(r, controller(name, model), path(name, "controller.log"), tasks.HOLE + [*o, 0], first, q,
                         turn @ o, arm.HOLES[2:3])[0]
            for o, q in list(zip(offsets, starts))[part::parts]]


def drawing(name, model):
    r, first, _, random = prepared(name)
    starts = tasks.postures(r, tasks.HOLE + [0, 0, tasks.HOVER], 2, random)
    return [tasks.draw(r, controller(name, model), path(name, "controller.log"), first, q).tolist() for q in starts]


def models_of(name, diagnosis, short):
    """The nominal model, geometry, and with causes where there are any."""
    if not diagnosis["causes"]:
        return table.MODELS[:2]
    return table.MODELS[::2] if short or name == "worn" else table.MODELS


def main():
    options = argparse.ArgumentParser()
    options.add_argument("--short", action="store_true", help="two minutes: one arm, few attempts")
    options.add_argument("--arms", help="some of " + ",".join(arm.ARMS))
    options = options.parse_args()
    short = options.short
    names = options.arms.split(",") if options.arms else ["sprung"] if short else list(arm.ARMS)
    n, holes, diameters, parts = (2, 1, arm.HOLES[:3:2], 1) if short else (20, 24, arm.HOLES, 4)
    os.makedirs(OUT, exist_ok=True)
    jobs = {}
    with multiprocessing.Pool(os.cpu_count(), maxtasksperchild=1) as pool:
        diagnoses = dict(zip(names, pool.map(own_network, [(record, a, 20) for a in names], 1)))
        for a in names:
            for m in models_of(a, diagnoses[a], short):
                for p in range(parts):
                    jobs["insert", a, m, p] = insertions, a, m, n, diameters, p, parts
                    jobs["cross", a, m, p] = crossing, a, m, holes, p, parts
                jobs["draw", a, m, 0] = drawing, a, m
        results = dict(zip(jobs, pool.map(own_network, jobs.values(), 1)))
    picture = os.path.join(OUT if short or options.arms else os.path.join(ROOT, "docs"), "closed_loop.png")
    sys.exit(table.report(names, diagnoses, results, OUT, picture))


if __name__ == "__main__":
    main()
