#include "simgap/fit/dynamics/dynamics_fit.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "consistent_fit.h"
#include "simgap/core/statistics.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Both fits to some blocks: what the log says alone, and the robot that can exist.
struct BothFits {
  std::vector<JointSums> sums;  ///< of those blocks
  BaseSolution base;
  MatrixXd covariance;
  double inflation = 1.0;
  ConsistentFit consistent;
};

BothFits fitBoth(const DynamicsData& data, const std::vector<bool>& used, const std::vector<double>& constants) {
  BothFits fits;
  fits.sums = data.sums.total(used);
  const std::vector<JointSums>& sums = fits.sums;
  fits.base = solveBase(data, sums, constants);
  fits.covariance = jackknifeCovariance(data, fits.base, constants, used);
  fits.inflation = inflationOf(data, sums, fits.base, fits.covariance);
  fits.consistent = fitConsistent(data, sums, fits.base.variance, fits.inflation, constants);
  return fits;
}

double relative(double squares, double of) { return of > 0.0 ? std::sqrt(squares / of) : std::nan(""); }

BaseEstimate baseEstimate(const DynamicsData& data, const BothFits& fits, Index k, double quantile) {
  BaseEstimate base;
  Estimate& e = base.estimate;
  base.text = data.base.texts[k];
  e.name = data.base.names[k];
  e.unit = data.regressor.units()[data.base.columns[k]];
  e.value = fits.base.x[k];
  e.identifiable = fits.base.determined[k];
  e.sd = e.identifiable ? std::sqrt(fits.covariance(k, k)) : std::nan("");
  e.lower95 = e.value - quantile * e.sd;
  e.upper95 = e.value + quantile * e.sd;
  return base;
}

}  // namespace

DynamicsFit fitDynamics(const DynamicsData& data, const std::vector<double>& torque_constants) {
  const std::vector<bool> all(data.sums.blocks.size(), true);
  const BothFits fits = fitBoth(data, all, torque_constants);
  const std::vector<JointSums>& sums = fits.sums;
  DynamicsFit fit;
  fit.model = {fits.consistent.parameters, torque_constants};
  fit.sd = fits.consistent.sd;
  fit.prior_sd = fits.consistent.prior_sd;
  fit.base_covariance = fits.consistent.base_covariance;
  fit.inflation = fits.inflation;
  fit.converged = fits.consistent.converged;
  const double quantile = studentQuantile(static_cast<double>(data.sums.blocks.size()) - 1.0);
  const VectorXd in_file = baseInFile(data), in_model = data.base.combination * fit.model.parameters;
  for (Index k = 0; k < in_file.size(); ++k) {
    fit.base.push_back(baseEstimate(data, fits, k, quantile));
    fit.base.back().in_file = in_file[k];
    fit.base.back().in_model = in_model[k];
  }
  for (std::size_t c = 0; c < sums.size(); ++c) {
    const double constant = fit.model.torque_constants[c];
    const double error = squaredError(sums[c], data.base.acts[c], in_model, constant) / (constant * constant);
    fit.rows.push_back(sums[c].rows);
    fit.noise.push_back(std::sqrt(error / std::max(1.0, sums[c].rows)));
    fit.error.push_back(relative(error, sums[c].effortSquares()));
  }
  return fit;
}

VectorXd fittedParameters(const DynamicsData& data, const std::vector<double>& torque_constants,
                          const std::vector<bool>& used) {
  return fitBoth(data, used, torque_constants).consistent.parameters;
}

HeldOutErrors crossValidate(const ArmModel& arm, const RobotRegressor& regressor, const BaseParameters& base,
                            const SumsOfFold& sums_of, const std::vector<double>& torque_constants,
                            const std::vector<int>& fold) {
  const int folds = *std::ranges::max_element(fold) + 1;
  const std::size_t n = regressor.coordinates();
  MatrixXd alone(folds, n), model(folds, n), squares(folds, n), rows(folds, n);
  tbb::parallel_for(0, folds, [&](int f) {
    std::vector<bool> fitted, held_out;
    for (const int of_block : fold) {
      fitted.push_back(of_block != f);
      held_out.push_back(of_block == f);
    }
    const std::shared_ptr<const DynamicsSums> sums = sums_of(fitted);
    const DynamicsData data{arm, regressor, base, *sums};
    const std::vector<JointSums> own = sums->total(held_out);
    const BothFits fits = fitBoth(data, fitted, torque_constants);
    const VectorXd x = data.base.combination * fits.consistent.parameters;
    for (std::size_t c = 0; c < n; ++c) {
      const Index column = c;
      const double constant = torque_constants[c];
      squares(f, column) = own[c].effortSquares();
      rows(f, column) = own[c].rows;
      alone(f, column) = squaredErrorAlone(own[c], fitAlone(data, fits.sums[c], c));
      model(f, column) = squaredError(own[c], data.base.acts[c], x, constant) / (constant * constant);
    }
  });
  HeldOutErrors errors;
  for (Index c = 0; c < alone.cols(); ++c) {
    errors.alone.push_back(relative(alone.col(c).sum(), squares.col(c).sum()));
    errors.model.push_back(relative(model.col(c).sum(), squares.col(c).sum()));
    errors.sd.push_back(std::sqrt(model.col(c).sum() / std::max(1.0, rows.col(c).sum())));
  }
  return errors;
}

ArmModel armWith(const ArmModel& arm, const RobotRegressor& regressor, const VectorXd& parameters) {
  ArmModel found = arm;
  const std::vector<int>& bodies = regressor.dynamics().bodies();
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (regressor.massless(b)) continue;
    const MassProperties mass = massPropertiesOf(parameters.segment<kBodyParameters>(regressor.bodyColumn(b)));
    Part part;
    part.name = found.bodies[bodies[b]].parts.front().name;
    part.shape = Part::Shape::kInertia;
    part.mass = mass.mass;
    part.position = mass.centre_of_mass;
    part.inertia = 0.5 * (mass.inertia + mass.inertia.transpose());
    found.bodies[bodies[b]].parts = {part};
  }
  const std::vector<int>& joints = regressor.dynamics().joints();
  for (std::size_t c = 0; c < joints.size(); ++c) {
    Joint& joint = found.joints[joints[c]];
    Index at = regressor.frictionColumn(c);
    joint.coulomb_friction = joint.viscous_friction = 0.0;
    for (const FrictionTerm& term : regressor.law().terms) {
      const double value = parameters[at++];
      // What an arm's joint has: the friction of sliding. The rest of a Stribeck law is in the model's own keys.
      if (term.basis == FrictionBasis::kVelocity) joint.viscous_friction += value;
      if (term.basis == FrictionBasis::kDirection && term.shape != FrictionShape::kStatic) {
        joint.coulomb_friction += value;
      }
    }
  }
  return found;
}

}  // namespace simgap
