// Forward kinematics by Orocos KDL, timed as bench_fk.c does: for kinematics.py, which compiles it.
//
// usage: kdl_fk ELEMENTS REPEATS ANGLES
//
// ELEMENTS: one line each from base to tip: type, x y z roll pitch yaw, axis.
#include "peer_timer.hh"

#include <cstdlib>
#include <fstream>

#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>

int main(int argc, char **argv)
{
    if (argc < 4) return 2;
    KDL::Chain chain;
    std::ifstream elements(argv[1]);
    std::string type;
    double x, y, z, roll, pitch, yaw, a, b, c;
    while (elements >> type >> x >> y >> z >> roll >> pitch >> yaw >> a >> b >> c) {
        const KDL::Frame origin(KDL::Rotation::RPY(roll, pitch, yaw), KDL::Vector(x, y, z));
        const KDL::Joint joint =
            type == "fixed"
                ? KDL::Joint(KDL::Joint::None)
                : KDL::Joint(origin.p, origin.M * KDL::Vector(a, b, c), KDL::Joint::RotAxis);
        chain.addSegment(KDL::Segment(joint, origin));
    }
    const unsigned n = chain.getNrOfJoints();
    const auto rows = read_rows(argv[3], n);
    std::vector<KDL::JntArray> q(rows.size(), KDL::JntArray(n));
    for (std::size_t r = 0; r < rows.size(); r++)
        for (unsigned j = 0; j < n; j++) q[r](j) = rows[r][j];
    KDL::ChainFkSolverPos_recursive position(chain);
    KDL::ChainJntToJacSolver jacobian(chain);
    KDL::Frame tip;
    KDL::Jacobian J(n);
    double sum[3] = {0, 0, 0};
    const int repeats = std::atoi(argv[2]);
    PeerTimer timer(repeats, rows);
    timer.add("kdl_position", [&](std::size_t r) {
        position.JntToCart(q[r], tip);
        for (int i = 0; i < 3; i++) sum[i] += tip.p[i];
    });
    timer.add("kdl_jacobian", [&](std::size_t r) {
        position.JntToCart(q[r], tip);
        jacobian.JntToJac(q[r], J);
    });
    timer.run();
    std::printf("check %.12g %.12g %.12g\n", sum[0] / repeats, sum[1] / repeats, sum[2] / repeats);
    return 0;
}
