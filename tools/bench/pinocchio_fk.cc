// Forward kinematics by Pinocchio, timed as bench_fk.c does: for kinematics.py, which compiles it
// against the headers and libraries that PyPI gives.
//
// usage: pinocchio_fk URDF TIP ANGLES
#include "peer_timer.hh"

#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/regressor.hpp>
#include <pinocchio/parsers/urdf.hpp>

int main(int argc, char **argv)
{
    if (argc < 4) return 2;
    pinocchio::Model model;
    pinocchio::urdf::buildModel(argv[1], model);
    pinocchio::Data data(model);
    const auto tip = model.getFrameId(argv[2]);
    Eigen::VectorXd q(model.nq);
    Eigen::MatrixXd regressor = Eigen::MatrixXd::Zero(6, 6 * (model.njoints - 1));
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(6, model.nv);
    PeerTimer timer(argv[3], model.nq);
    const auto take = [&](std::size_t r) { q = Eigen::VectorXd::Map(timer.q[r].data(), model.nq); };
    timer.add("pinocchio_position", [&](std::size_t r) {
        take(r);
        pinocchio::forwardKinematics(model, data, q);
        pinocchio::updateFramePlacement(model, data, tip);
        Eigen::Vector3d::Map(&timer.tips[3 * r]) = data.oMf[tip].translation();
    });
    timer.add("pinocchio_jacobian", [&](std::size_t r) {
        take(r);
        J.setZero();
        pinocchio::computeFrameJacobian(model, data, q, tip, pinocchio::LOCAL_WORLD_ALIGNED, J);
    });
    timer.add("pinocchio_regressor", [&](std::size_t r) {
        take(r);
        pinocchio::forwardKinematics(model, data, q);
        pinocchio::updateFramePlacement(model, data, tip);
        pinocchio::computeFrameKinematicRegressor(model, data, tip, pinocchio::LOCAL_WORLD_ALIGNED,
                                                  regressor);
    });
    timer.run();
    return 0;
}
