// The same forward kinematics as C that Pinocchio's code generation (CppADCodeGen) wrote and gcc
// compiled, with the arm's numbers folded in; for kinematics.py.
//
// usage: pinocchio_codegen URDF TIP ANGLES FOLDER CC      FOLDER: for what is generated;
// CC: path of gcc
#include <string>

#include <cppad/cg.hpp>
// after CppADCodeGen, which its headers extend
#include <pinocchio/codegen/cppadcg.hpp>

#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/parsers/urdf.hpp>

#include "peer_timer.hh"

using Code = CppAD::cg::CG<double>;
using Recorded = CppAD::AD<Code>;
using Vector = Eigen::Matrix<Recorded, Eigen::Dynamic, 1>;
using Matrix = Eigen::Matrix<Recorded, Eigen::Dynamic, Eigen::Dynamic>;
using Library = std::unique_ptr<CppAD::cg::DynamicLib<double>>;

static Library generate(CppAD::ADFun<Code> &function, const std::string &name, char **arguments)
{
    function.optimize("no_compare_op");
    CppAD::cg::ModelCSourceGen<double> source(function, name);
    source.setCreateForwardZero(true);
    CppAD::cg::ModelLibraryCSourceGen<double> library(source);
    CppAD::cg::GccCompiler<double> compiler(arguments[5]);
    compiler.setCompileFlags({"-O3"});
    CppAD::cg::DynamicModelLibraryProcessor<double> processor(
        library, std::string(arguments[4]) + "/" + name);
    return processor.createDynamicLibrary(compiler);
}

int main(int argc, char **argv)
{
    if (argc < 6) return 2;
    pinocchio::Model model;
    pinocchio::urdf::buildModel(argv[1], model);
    const auto arm = model.cast<Recorded>();
    pinocchio::DataTpl<Recorded> data(arm);
    const auto tip = model.getFrameId(argv[2]);

    Vector q(model.nq), position(3), entries(6 * model.nv);
    for (int j = 0; j < model.nq; j++) q[j] = Recorded(0.1);
    CppAD::Independent(q);
    pinocchio::forwardKinematics(arm, data, q);
    pinocchio::updateFramePlacement(arm, data, tip);
    position = data.oMf[tip].translation();
    CppAD::ADFun<Code> place(q, position);

    CppAD::Independent(q);
    Matrix J = Matrix::Zero(6, model.nv);
    pinocchio::computeFrameJacobian(arm, data, q, tip, pinocchio::LOCAL_WORLD_ALIGNED, J);
    entries = Eigen::Map<Vector>(J.data(), J.size());
    CppAD::ADFun<Code> motion(q, entries);

    const Library libraries[] = {generate(place, "pinocchio_generated_position", argv),
                                 generate(motion, "pinocchio_generated_jacobian", argv)};
    const auto first = libraries[0]->model("pinocchio_generated_position"),
               second = libraries[1]->model("pinocchio_generated_jacobian");
    std::vector<double> out(3), all(6 * static_cast<std::size_t>(model.nv));
    PeerTimer timer(argv[3], model.nq);
    timer.add("pinocchio_generated_position", [&](std::size_t r) {
        first->ForwardZero(CppAD::cg::ArrayView<const double>(timer.q[r]),
                           CppAD::cg::ArrayView<double>(out));
        std::copy(out.begin(), out.end(), &timer.tips[3 * r]);
    });
    timer.add("pinocchio_generated_jacobian", [&](std::size_t r) {
        second->ForwardZero(CppAD::cg::ArrayView<const double>(timer.q[r]),
                            CppAD::cg::ArrayView<double>(all));
    });
    timer.run();
    return 0;
}
