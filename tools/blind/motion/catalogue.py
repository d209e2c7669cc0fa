"""Names of the exam's effects: those of `mukca motion`, and some outside its catalogue."""

LISTED = ["payload", "link_mass", "link_centre", "armature", "coulomb", "viscous", "stribeck", "load_friction",
          "asymmetry", "offset", "torque_gain", "torque_gain_all", "delay", "spring", "cogging", "thermal_friction"]
UNLISTED = ["hysteresis", "push", "drag", "coupling"]

# What the torque of an effect varies with (`varies_with`); where the effect's own equation has two such
# factors, either is right.
VARIES_WITH = {
    "payload": {"gravity"}, "link_mass": {"gravity"}, "link_centre": {"gravity"}, "armature": {"acceleration"},
    "coulomb": {"direction"}, "viscous": {"velocity"}, "stribeck": {"velocity", "direction"},
    "load_friction": {"load"}, "asymmetry": {"velocity"}, "offset": {"torque"}, "torque_gain": {"torque"},
    "delay": {"shift"}, "spring": {"angle"}, "cogging": {"angle"}, "thermal_friction": {"time", "direction"},
    "hysteresis": {"direction", "angle"}, "push": {"time"}, "drag": {"velocity"}, "coupling": {"velocity"}}

# A hand pushes at these joints, with so much of the size.
PUSHED = {1: 0.6, 2: 0.4, 3: 0.15}
