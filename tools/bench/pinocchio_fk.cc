// Forward kinematics by Pinocchio, timed as bench_fk.c does: for kinematics.py, which compiles it
// against the headers and libraries that PyPI gives.
//
// usage: pinocchio_fk URDF TIP REPEATS ANGLES
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <vector>

#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/regressor.hpp>
#include <pinocchio/parsers/urdf.hpp>

template <typename Pass>
static void measure(const char *name, int repeats, std::size_t rows, Pass pass)
{
    std::vector<double> times;
    for (int i = 0; i < repeats; i++) {
        const auto start = std::chrono::steady_clock::now();
        for (std::size_t r = 0; r < rows; r++) pass(r);
        const std::chrono::duration<double, std::nano> took =
            std::chrono::steady_clock::now() - start;
        times.push_back(took.count() / static_cast<double>(rows));
    }
    std::sort(times.begin(), times.end());
    std::printf("%s %.6g\n", name, times[times.size() / 2]);
}

int main(int argc, char **argv)
{
    if (argc < 5) return 2;
    pinocchio::Model model;
    pinocchio::urdf::buildModel(argv[1], model);
    pinocchio::Data data(model);
    const auto tip = model.getFrameId(argv[2]);
    const int repeats = std::atoi(argv[3]);
    std::ifstream file(argv[4], std::ios::binary);
    std::vector<Eigen::VectorXd> q;
    Eigen::VectorXd row(model.nq);
    const auto bytes = static_cast<std::streamsize>(sizeof(double)) * model.nq;
    while (file.read(reinterpret_cast<char *>(row.data()), bytes)) q.push_back(row);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::MatrixXd regressor = Eigen::MatrixXd::Zero(6, 6 * (model.njoints - 1));
    measure("pinocchio_position", repeats, q.size(), [&](std::size_t r) {
        pinocchio::forwardKinematics(model, data, q[r]);
        pinocchio::updateFramePlacement(model, data, tip);
        sum += data.oMf[tip].translation();
    });
    measure("pinocchio_regressor", repeats, q.size(), [&](std::size_t r) {
        pinocchio::forwardKinematics(model, data, q[r]);
        pinocchio::updateFramePlacement(model, data, tip);
        pinocchio::computeFrameKinematicRegressor(model, data, tip, pinocchio::LOCAL_WORLD_ALIGNED,
                                                  regressor);
    });
    sum /= repeats;
    std::printf("check %.12g %.12g %.12g\n", sum[0], sum[1], sum[2]);
    return 0;
}
