// Masses of bodies: what shapes add up to, and what MuJoCo's compiler makes of it all.
#include "mjcf_robot.h"
#include "simgap/core/decompositions.h"

namespace simgap {
namespace {

/// Moments of which one is more than the others together belong to no body: their mean, as in MuJoCo.
void balance(MassProperties& mass) {
  const Eigen::Vector3d moments = symmetricEigen(mass.inertia).values;
  if (moments[2] > moments[0] + moments[1]) mass.inertia = moments.mean() * Eigen::Matrix3d::Identity();
}

}  // namespace

MassProperties inFrame(const MassProperties& mass, const Eigen::Isometry3d& frame) {
  return {mass.mass, frame * mass.centre_of_mass, frame.linear() * mass.inertia * frame.linear().transpose()};
}

MassProperties addMass(const MassProperties& a, const MassProperties& b) {
  MassProperties sum;
  sum.mass = a.mass + b.mass;
  if (sum.mass <= 0.0) return a;
  sum.centre_of_mass = (a.mass * a.centre_of_mass + b.mass * b.centre_of_mass) / sum.mass;
  for (const MassProperties* part : {&a, &b}) {
    const Eigen::Vector3d way = part->centre_of_mass - sum.centre_of_mass;
    sum.inertia +=
        part->inertia + part->mass * (way.squaredNorm() * Eigen::Matrix3d::Identity() - way * way.transpose());
  }
  return sum;
}

void workOutMasses(const MjcfFile::Compiler& compiler, MjcfRobot& robot) {
  double total = 0.0;
  for (MjcfBody& body : robot.bodies) {
    body.mass.mass = std::max(body.mass.mass, compiler.least_mass);
    if (compiler.least_inertia > 0.0) {
      // The bound holds for the moments about the principal axes.
      const SymmetricEigen principal = symmetricEigen(body.mass.inertia);
      const Eigen::Vector3d moments = principal.values.cwiseMax(compiler.least_inertia);
      if (moments != principal.values) {
        body.mass.inertia = principal.vectors * moments.asDiagonal() * principal.vectors.transpose();
      }
    }
    if (compiler.balance_inertia) balance(body.mass);
    total += body.mass.mass;
  }
  setSpringDampers(robot);  // as in MuJoCo, before masses are scaled
  if (compiler.total_mass > 0.0 && total > 0.0) {
    for (MjcfBody& body : robot.bodies) {
      body.mass.mass *= compiler.total_mass / total;
      body.mass.inertia *= compiler.total_mass / total;
    }
  }
}

}  // namespace simgap
