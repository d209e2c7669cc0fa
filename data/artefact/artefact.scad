// The artefact: a plate with two sockets, and a ball on an adapter for the flange of the arm.
// All lengths in mm. `make artefact` writes the STL files, the drawing and the picture.

part = "assembly"; // plate, adapter, drawing, assembly
distance = 50;     // between the ball centres in the two sockets; mukca --distance, in m
ball = 20;         // diameter of the bought steel ball; of both sockets
flange = [50, 6];  // ISO 9409-1: pitch circle and thread of four screws: [50, 6], [40, 6], [31.5, 5]
offset = 35;       // of the ball from the axis of the last joint
height = 50;       // of the ball's centre above the face of the flange
printed_ball = false; // print the ball as well, if there is no steel ball
magnet = [8.2, 3.2];  // pocket under each socket: diameter and depth; [0, 0]: none

$fn = 48;
r = ball / 2;
tilt = 45;               // of the three faces of a socket
apex = r / cos(tilt);    // depth of their common point below the ball's centre
rim = 0.3 * r;           // depth of the socket's rim: the caliper reaches the ball's equator
floor_depth = 1.1 * r;   // the ball's lowest point stays clear of the floor
wall = 1;                // between the floor and the magnet
base = 8;                // thickness of plate and flange disc
centre = base + max(floor_depth + wall + magnet[1] - base + 1, 0.9 * r); // above the plate's underside
width = 3.4 * r + 20;
length = distance + width;

// Three faces at 120 degrees that touch the ball in one point each, seen from the ball's centre.
module socket() {
    intersection() {
        translate([0, 0, -apex]) rotate([0, 0, 30])
            cylinder(h = 3 * r, r1 = 0, r2 = 6 * r * tan(90 - tilt), $fn = 3);
        translate([0, 0, -floor_depth]) cylinder(h = 3 * r, d = 2.4 * r);
    }
}

module plate() {
    difference() {
        union() {
            translate([-width / 2, -width / 2, 0]) cube([length, width, base]);
            for (x = [0, distance]) translate([x, 0, 0]) cylinder(h = centre - rim, d = 3.2 * r);
        }
        for (x = [0, distance]) translate([x, 0, centre]) {
            socket();
            translate([0, 0, -centre - 1]) cylinder(h = magnet[1] + 1, d = magnet[0]);
        }
        for (x = [7 - width / 2, length - width / 2 - 7], y = [7 - width / 2, width / 2 - 7])
            translate([x, y, -1]) cylinder(h = base + 2, d = 6.6);
        for (i = [0, 1]) translate([i * distance, -width / 2 + 5, base - 0.6])
            linear_extrude(1) text(str(i), size = 7, halign = "center", valign = "center", $fn = 12);
    }
}

module along_stem(z) { // to a point of the stem, seen from its root; z along its axis
    rotate([0, atan2(offset, height - base), 0]) translate([0, 0, z]) children();
}

module adapter() {
    stem = norm([offset, height - base]);
    root = 0.56 * flange[0];
    tip = 0.7 * ball;
    head = flange[1] * 1.8; // of a cylinder head screw, with clearance
    difference() {
        union() {
            cylinder(h = base, d = flange[0] + 2.2 * flange[1]);
            intersection() {
                translate([0, 0, base]) along_stem(-root)
                    cylinder(h = stem - sqrt(r * r - tip * tip / 4) + root,
                             d1 = root + (root - tip) * root / stem, d2 = tip);
                translate([-2 * height, -2 * height, 0]) cube(4 * height);
            }
            if (printed_ball) translate([offset, 0, height]) sphere(r);
        }
        if (!printed_ball) translate([offset, 0, height]) sphere(r + 0.1, $fn = 32); // glue
        for (a = [45:90:315]) rotate([0, 0, a]) translate([flange[0] / 2, 0, -1]) {
            cylinder(h = base + 2, d = flange[1] + 0.6);
            translate([0, 0, base]) cylinder(h = 2 * height, d = head);
        }
    }
}

module steel() { color("silver") sphere(r, $fn = 96); }

module assembly() {
    color("steelblue") plate();
    translate([distance, 0, centre]) steel();
    translate([0, 0, centre + 45]) rotate([0, 180, 0]) rotate([0, 0, 180])
        translate([-offset, 0, -height]) {
            color("orange") adapter();
            translate([offset, 0, height]) steel();
        }
}

// ---- drawing: outlines of projections and sections, with dimensions ----------------------------
module line(from, to, w = 0.25) { hull() for (p = [from, to]) translate(p) circle(d = w, $fn = 8); }
module outline(w = 0.35) { difference() { children(); offset(delta = -w) children(); } }
module label(p, text) { translate(p) text(text, size = 3, halign = "center", $fn = 8); }
module dimension(a, b, d, text, vertical = false) { // from a to b, d away from both
    c = vertical ? [max(a[0], b[0]) + d, a[1]] : [a[0], min(a[1], b[1]) - d];
    e = vertical ? [c[0], b[1]] : [b[0], c[1]];
    line(a, c, 0.12);
    line(b, e, 0.12);
    line(c, e);
    for (p = [c, e]) line(p - [0.8, 0.8], p + [0.8, 0.8]);
    if (vertical) translate([c[0] + 1, (a[1] + b[1]) / 2 - 1.5]) text(text, size = 3, $fn = 8);
    else label([(a[0] + b[0]) / 2, c[1] + 1], text);
}

module drawing() {
    w = width / 2;
    outline() projection() plate();
    for (x = [0, distance]) translate([x, 0]) outline() projection(cut = true)
        translate([0, 0, rim + 0.01]) socket();
    dimension([0, 0], [distance, 0], w + 9, str(distance, " (measured, 0.02)"));
    dimension([-w, -w], [length - w, -w], 16, str(length));
    dimension([length - w, -w], [length - w, w], 5, str(width), true);
    dimension([7 - w, w - 7], [length - w - 7, w - 7], -14, str(length - 14, ", four holes 6.6"));
    label([distance / 2, -w - 24], "plate, from above");
    translate([0, -w - 75]) {
        outline() projection(cut = true) rotate([-90, 0, 0]) plate();
        for (x = [0, distance]) translate([x, centre]) outline(0.15) circle(r);
        dimension([distance, centre - r], [distance, centre + r], w - 5, str("ball ", ball), true);
        dimension([-r, centre], [distance + r, centre], -r - 6, str(distance + ball, ": caliper over the balls"));
        dimension([-w, 0], [-w, base], -9, str(base), true);
        label([distance / 2, -9], str("section; faces at ", tilt, " degrees, magnet ", magnet[0], " x ", magnet[1]));
    }
    translate([length + w + 20, 0]) {
        outline() projection() adapter();
        outline(0.12) circle(d = flange[0]);
        label([0, -w - 12], str("adapter: ISO 9409-1-", flange[0], "-4-M", flange[1]));
        translate([0, -w - 75]) {
            outline() projection(cut = true) rotate([-90, 0, 0]) adapter();
            translate([offset, height]) outline(0.15) circle(r);
            dimension([0, 0], [offset, height], 9, str(offset));
            dimension([offset, 0], [offset, height], 16, str(height), true);
            label([5, -18], str("section; disc ", flange[0] + 2.2 * flange[1], " x ", base));
        }
    }
}

if (part == "plate") plate();
else if (part == "adapter") adapter();
else if (part == "drawing") drawing();
else assembly();
