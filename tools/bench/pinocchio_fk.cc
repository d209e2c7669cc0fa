// Forward kinematics by Pinocchio, timed as bench_fk.c does: for kinematics.py, which compiles it
// against the headers and libraries that PyPI gives.
//
// usage: pinocchio_fk URDF TIP REPEATS ANGLES
#include "peer_timer.hh"

#include <cstdlib>

#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/regressor.hpp>
#include <pinocchio/parsers/urdf.hpp>

int main(int argc, char **argv)
{
    if (argc < 5) return 2;
    pinocchio::Model model;
    pinocchio::urdf::buildModel(argv[1], model);
    pinocchio::Data data(model);
    const auto tip = model.getFrameId(argv[2]);
    const int repeats = std::atoi(argv[3]);
    const auto rows = read_rows(argv[4], static_cast<std::size_t>(model.nq));
    std::vector<Eigen::VectorXd> q;
    for (const auto &row : rows) q.push_back(Eigen::VectorXd::Map(row.data(), model.nq));
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::MatrixXd regressor = Eigen::MatrixXd::Zero(6, 6 * (model.njoints - 1));
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(6, model.nv);
    PeerTimer timer(repeats, rows);
    timer.add("pinocchio_position", [&](std::size_t r) {
        pinocchio::forwardKinematics(model, data, q[r]);
        pinocchio::updateFramePlacement(model, data, tip);
        sum += data.oMf[tip].translation();
    });
    timer.add("pinocchio_jacobian", [&](std::size_t r) {
        J.setZero();
        pinocchio::computeFrameJacobian(model, data, q[r], tip, pinocchio::LOCAL_WORLD_ALIGNED, J);
    });
    timer.add("pinocchio_regressor", [&](std::size_t r) {
        pinocchio::forwardKinematics(model, data, q[r]);
        pinocchio::updateFramePlacement(model, data, tip);
        pinocchio::computeFrameKinematicRegressor(model, data, tip, pinocchio::LOCAL_WORLD_ALIGNED,
                                                  regressor);
    });
    timer.run();
    sum /= repeats;
    std::printf("check %.12g %.12g %.12g\n", sum[0], sum[1], sum[2]);
    return 0;
}
