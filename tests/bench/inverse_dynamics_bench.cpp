/// \file
/// The regressor of a chain of six hinges, one moment of a log: time per joint and row.
#include <benchmark/benchmark.h>

#include <cmath>

#include "simgap/model/arm/inverse_dynamics.h"

namespace simgap {
namespace {

ArmModel chainOf(int joints) {
  ArmModel model;
  model.name = "chain";
  model.bodies.push_back({.name = "base", .fixed = true, .parts = {}, .surfaces = {}});
  for (int j = 0; j < joints; ++j) {
    Part part;
    part.name = "mass";
    part.shape = Part::Shape::kBox;
    part.size = {0.1, 0.1, 0.4};
    part.mass = 3.0;
    part.position = {0.01, 0.02, 0.2};
    model.bodies.push_back({.name = "link", .fixed = false, .parts = {part}, .surfaces = {}});
    Joint joint;
    joint.type = JointType::kRevolute;
    joint.parent = j;
    joint.child = j + 1;
    joint.parent_position = {0.0, 0.0, 0.4};
    joint.axis = Eigen::Vector3d::Unit(j % 3);
    joint.parent_orientation = Eigen::AngleAxisd(0.3 * j, Eigen::Vector3d::UnitY());
    model.joints.push_back(joint);
  }
  return model;
}

void RegressorPerRow(benchmark::State& state) {
  const auto joints = static_cast<std::size_t>(state.range(0));
  const ArmModel model = chainOf(static_cast<int>(joints));
  const InverseDynamics dynamics(model);
  InverseDynamics::Workspace work = dynamics.workspace();
  RegressorMatrix y(state.range(0), dynamics.parameters());
  std::vector<double> q(joints, 0.3), v(joints, 0.7), a(joints, -0.4);
  double moved = 0.0;
  for (auto _ : state) {
    q[0] = moved += 1e-3;
    dynamics.regressor(q, v, a, model.gravity, work, y);
    benchmark::DoNotOptimize(y.data());
  }
  state.counters["per_joint_and_row"] = benchmark::Counter(
      static_cast<double>(joints), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(RegressorPerRow)->Arg(2)->Arg(6)->Arg(7);

}  // namespace
}  // namespace simgap
