// Forward kinematics by Orocos KDL, timed as bench_fk.c does: for kinematics.py, which compiles it.
//
// usage: kdl_fk ELEMENTS ANGLES
//
// ELEMENTS: one line each from base to tip: type, x y z roll pitch yaw, axis.
#include "peer_timer.hh"

#include <fstream>

#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>

int main(int argc, char **argv)
{
    if (argc < 3) return 2;
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
    KDL::JntArray q(n);
    KDL::ChainFkSolverPos_recursive position(chain);
    KDL::ChainJntToJacSolver jacobian(chain);
    KDL::Frame tip;
    KDL::Jacobian J(n);
    PeerTimer timer(argv[2], static_cast<int>(n));
    const auto take = [&](std::size_t r) {
        for (unsigned j = 0; j < n; j++) q(j) = timer.q[r][j];
    };
    timer.add("kdl_position", [&](std::size_t r) {
        take(r);
        position.JntToCart(q, tip);
        std::copy(tip.p.data, tip.p.data + 3, &timer.tips[3 * r]);
    });
    timer.add("kdl_jacobian", [&](std::size_t r) {
        take(r);
        position.JntToCart(q, tip);
        jacobian.JntToJac(q, J);
    });
    timer.run();
    return 0;
}
