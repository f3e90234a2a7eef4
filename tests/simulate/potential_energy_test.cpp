// Gradient, Hessian and parameter derivatives against central differences, and the energy against the independent one.
#include <gtest/gtest.h>

#include "reality/arm_statics.h"
#include "simgap/model/arm/parameter_space.h"
#include "simgap/simulate/potential_energy.h"
#include "support/arms.h"
#include "support/statics.h"

namespace simgap {
namespace {

struct EnergyCase {
  reality::Arm arm;
  ArmModel model;
  std::vector<double> shafts;
  std::vector<JointPosition> joints;
};

// A random arm in a random position; every muscle is made taut or slack by chance.
EnergyCase randomCase(std::uint64_t seed) {
  std::mt19937 random(static_cast<unsigned>(seed));
  EnergyCase c;
  c.arm = seed == 0 ? reality::referenceArm() : reality::randomArm(seed);
  c.model = test::modelOf(c.arm, false);
  c.shafts = reality::randomShafts(c.arm, seed);
  for (const Joint& joint : c.model.joints) {
    const Eigen::Vector3d axis = test::randomDirection(random);
    JointPosition position = test::ballAt(test::uniform(random, 0.0, 1.2), axis);
    position.angle = std::clamp(test::uniform(random, -1.0, 1.5), joint.lower_limit, joint.upper_limit);
    c.joints.push_back(position);
  }
  return c;
}

std::vector<JointPosition> energyDisplaced(const EnergyCase& c, const PotentialEnergy& energy,
                                           const Eigen::VectorXd& w) {
  std::vector<JointPosition> joints = c.joints;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const int d = energy.firstDof(static_cast<int>(j));
    if (c.model.joints[j].type == JointType::kSpherical) {
      const Eigen::Vector3d turn = w.segment<3>(d);
      if (turn.norm() > 0.0) {
        joints[j].rotation = joints[j].rotation * Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
      }
    } else {
      joints[j].angle += w[d];
    }
  }
  return joints;
}

class PotentialEnergyOfArms : public testing::TestWithParam<int> {
 protected:
  PotentialEnergyOfArms() : c_(randomCase(static_cast<std::uint64_t>(GetParam()))), energy_(c_.model) {
    energy_.setShafts(c_.shafts);
    energy_.evaluate(c_.joints);
  }
  double energyAt(const Eigen::VectorXd& w) {
    energy_.evaluate(energyDisplaced(c_, energy_, w));
    return energy_.energy();
  }
  EnergyCase c_;
  PotentialEnergy energy_;
};

TEST_P(PotentialEnergyOfArms, EqualsTheIndependentEnergyAndTorque) {
  const reality::Configuration q = test::configurationOf(c_.arm, c_.joints);
  EXPECT_NEAR(energy_.energy(), reality::totalEnergy(c_.arm, c_.shafts, q), 1e-10);
  const reality::JointTorques torques = reality::jointTorque(c_.arm, c_.shafts, q);
  for (std::size_t j = 0; j < torques.size(); ++j) {
    const int d = energy_.firstDof(static_cast<int>(j));
    for (int i = 0; i < torques[j].size(); ++i) {
      EXPECT_NEAR(-energy_.gradient()[d + i], torques[j][i], 1e-9) << "joint " << j << ", component " << i;
    }
  }
}

TEST_P(PotentialEnergyOfArms, HessianAgreesWithSecondDifferencesOfTheEnergy) {
  const Eigen::MatrixXd hessian = energy_.hessian();
  const int n = energy_.degreesOfFreedom();
  const double h = 1e-4;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j <= i; ++j) {
      const auto at = [&](double a, double b) {
        return energyAt(a * Eigen::VectorXd::Unit(n, i) + b * Eigen::VectorXd::Unit(n, j));
      };
      const double second = (at(h, h) - at(h, -h) - at(-h, h) + at(-h, -h)) / (4.0 * h * h);
      // Truncation h^2 E'''' and rounding 1e-15 E / h^2, both about 1e-6 of some tens of N m.
      EXPECT_NEAR(hessian(i, j), second, 3e-5) << i << ", " << j;
      EXPECT_EQ(hessian(i, j), hessian(j, i));
    }
  }
}

TEST_P(PotentialEnergyOfArms, EveryParameterDerivativeAgreesWithDifferencesOfTheGradient) {
  std::vector<std::string> names;
  std::vector<double> values;
  visitParameters(c_.model, [&](const ParameterPath& path, const ParameterKind&, double& value) {
    names.push_back(path.str());
    values.push_back(value);
  });
  const std::vector<StaticParameter> parameters = staticParameters(c_.model, names);
  Eigen::MatrixXd columns(energy_.degreesOfFreedom(), names.size());
  energy_.differentiate(parameters, columns);
  int moving = 0;
  for (std::size_t p = 0; p < names.size(); ++p) {
    const double h = 1e-6 * std::max(0.1, std::abs(values[p]));
    const auto gradientAt = [&](double value) {
      ArmModel changed = c_.model;
      std::size_t k = 0;
      visitParameters(changed, [&](const ParameterPath&, const ParameterKind&, double& number) {
        if (k++ == p) number = value;
      });
      PotentialEnergy energy(changed);
      energy.setShafts(c_.shafts);
      energy.evaluate(c_.joints);
      return Eigen::VectorXd(energy.gradient());
    };
    const Eigen::VectorXd slope = (gradientAt(values[p] + h) - gradientAt(values[p] - h)) / (2.0 * h);
    const double scale = std::max(1.0, slope.lpNorm<Eigen::Infinity>());
    EXPECT_LT((columns.col(p) - slope).lpNorm<Eigen::Infinity>(), 1e-6 * scale)
        << names[p] << ": " << columns.col(p).transpose() << " for " << slope.transpose();
    moving += slope.norm() > 1e-6;
  }
  EXPECT_GT(moving, 20);
}

TEST_P(PotentialEnergyOfArms, ShaftDerivativesAgreeWithDifferencesOfTheGradient) {
  Eigen::MatrixXd columns(energy_.degreesOfFreedom(), c_.shafts.size());
  energy_.differentiateByShafts(columns);
  for (std::size_t m = 0; m < c_.shafts.size(); ++m) {
    const auto gradientAt = [&](double h) {
      std::vector<double> shafts = c_.shafts;
      shafts[m] += h;
      energy_.setShafts(shafts);
      energy_.evaluate(c_.joints);
      return Eigen::VectorXd(energy_.gradient());
    };
    const Eigen::VectorXd slope = (gradientAt(1e-5) - gradientAt(-1e-5)) / 2e-5;
    EXPECT_LT((columns.col(m) - slope).lpNorm<Eigen::Infinity>(), 1e-7) << "muscle " << m;
  }
}

INSTANTIATE_TEST_SUITE_P(Arms, PotentialEnergyOfArms, testing::Range(0, 24));

TEST(PotentialEnergy, OneMuscleByHand) {
  // A 3-4-5 triangle: the cord is stretched by 0.01 m and pulls with 9 N on a lever arm of 0.03 * 0.8 = 0.024 m.
  ArmModel model = test::pendulum();
  test::addMuscle(model, {0, {0, 0.03, 0}}, {1, {0, 0, -0.04}}, 0.04);
  PotentialEnergy energy(model);
  energy.setShafts(std::vector<double>{0.0});
  energy.evaluate(std::vector<JointPosition>{test::hingeAt(0.0)});
  EXPECT_NEAR(energy.tension(0), 9.0, 1e-12);
  EXPECT_NEAR(-energy.gradient()[0], 9.0 * 0.024, 1e-12);
  // L^2 = a^2 + b^2 + 2 a b sin(q), so L'' = -L'^2 / L at q = 0: k L'^2 + F L'' + m g l.
  const double curvature =
      (900.0 - 9.0 / 0.05) * 0.024 * 0.024 + test::kPendulumMass * test::kGravity * test::kPendulumLength;
  EXPECT_NEAR(energy.hessian()(0, 0), curvature, 1e-12);
}

}  // namespace
}  // namespace simgap
