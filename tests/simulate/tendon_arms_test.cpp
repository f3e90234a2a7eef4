// Arms of every kind of joint and tendon: derivatives of their energy against differences, rests against an independent
// minimiser and against the simulation.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "simgap/core/csv.h"
#include "simgap/core/joint_kind.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/model/arm/parameter_space.h"
#include "simgap/simulate/bullet_arm.h"
#include "simgap/simulate/equilibrium_arm.h"
#include "support/arms.h"
#include "support/files.h"
#include "support/many_kinds.h"

namespace simgap {
namespace {

ArmModel manyKinds() { return readArm(YamlNode::parse(test::kManyKinds, "many.yaml")); }

struct Drawn {
  ArmModel model;
  std::vector<double> shafts;
  std::vector<JointPosition> joints;
};

/// Every number of the model moved a little, in a random position.
Drawn drawn(int seed) {
  std::mt19937 random(static_cast<unsigned>(seed));
  Drawn d{manyKinds(), {}, {}};
  visitParameters(d.model, [&](const ParameterPath& path, const ParameterKind& kind, double& value) {
    if (path.member == "mass_kg" || kind.unit == "1") return;
    value = kind.unit == "m" && kind.range.lower < 0.0 ? value + test::uniform(random, -4e-3, 4e-3)
                                                       : value * test::uniform(random, 0.9, 1.1);
  });
  for (std::size_t m = 0; m < d.model.muscles.size(); ++m) d.shafts.push_back(test::uniform(random, 0.0, 12.0));
  for (const Joint& joint : d.model.joints) {
    const Eigen::Vector3d axis = test::randomDirection(random);
    JointPosition position = test::ballAt(test::uniform(random, 0.1, 1.0), axis);
    position.angle = joint.slides() ? test::uniform(random, -0.05, 0.1) : test::uniform(random, -0.2, 1.8);
    d.joints.push_back(position);
  }
  return d;
}

std::vector<JointPosition> tendonDisplaced(const Drawn& c, const PotentialEnergy& energy, const Eigen::VectorXd& w) {
  std::vector<JointPosition> joints = c.joints;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const int d = energy.firstDof(static_cast<int>(j));
    if (c.model.joints[j].hasAxis()) {
      joints[j].angle += w[d];
    } else {
      joints[j].rotation = joints[j].rotation * Eigen::Quaterniond(expSo3(w.segment<3>(d)));
    }
  }
  return joints;
}

class ArmsOfManyKinds : public testing::TestWithParam<int> {
 protected:
  ArmsOfManyKinds() : c_(drawn(GetParam())), energy_(c_.model) {
    energy_.setShafts(c_.shafts);
    energy_.evaluate(c_.joints);
  }
  Drawn c_;
  PotentialEnergy energy_;
};

TEST_P(ArmsOfManyKinds, GradientAndHessianAreDerivativesOfTheEnergy) {
  const int n = energy_.degreesOfFreedom();
  ASSERT_EQ(n, 6);
  const Eigen::VectorXd gradient = energy_.gradient();
  const Eigen::MatrixXd hessian = energy_.hessian();
  PotentialEnergy other(c_.model);
  other.setShafts(c_.shafts);
  const auto at = [&](const Eigen::VectorXd& w) {
    other.evaluate(tendonDisplaced(c_, other, w));
    return other.energy();
  };
  const double h = 1e-4;
  const auto unit = [&](int i) { return Eigen::VectorXd(h * Eigen::VectorXd::Unit(n, i)); };
  const double scale = std::max(1.0, hessian.lpNorm<Eigen::Infinity>());
  for (int i = 0; i < n; ++i) {
    EXPECT_NEAR(gradient[i], (at(unit(i)) - at(-unit(i))) / (2.0 * h), 2e-6 * scale) << i;
    for (int j = 0; j <= i; ++j) {
      const double second =
          (at(unit(i) + unit(j)) - at(unit(i) - unit(j)) - at(unit(j) - unit(i)) + at(-unit(i) - unit(j))) /
          (4.0 * h * h);
      EXPECT_NEAR(hessian(i, j), second, 2e-5 * scale) << i << ", " << j;
      EXPECT_EQ(hessian(i, j), hessian(j, i));
    }
  }
}

TEST_P(ArmsOfManyKinds, EveryParameterDerivativeAgreesWithDifferencesOfTheGradient) {
  std::vector<std::string> names;
  std::vector<double> values;
  visitParameters(c_.model, [&](const ParameterPath& path, const ParameterKind&, double& value) {
    names.push_back(path.str());
    values.push_back(value);
  });
  const std::vector<StaticParameter> parameters = staticParameters(c_.model, names);
  Eigen::MatrixXd columns(energy_.degreesOfFreedom(), names.size());
  energy_.differentiate(parameters, columns);
  PotentialEnergy energy(c_.model);
  int moving = 0;
  for (std::size_t p = 0; p < names.size(); ++p) {
    const double h = 1e-6 * std::max(0.1, std::abs(values[p]));
    const auto gradientAt = [&](double value) {
      ArmModel changed = c_.model;
      std::size_t k = 0;
      visitParameters(changed, [&](const ParameterPath&, const ParameterKind&, double& number) {
        if (k++ == p) number = value;
      });
      energy.setModel(changed);
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
  EXPECT_GT(moving, 60);
}

TEST_P(ArmsOfManyKinds, MomentArmsAreDerivativesOfTheLengthThatThePathHas) {
  const std::size_t lines = c_.model.muscles.size() + c_.model.tendons.size();
  const auto lengthAt = [&](std::size_t line, const std::vector<JointPosition>& joints) {
    const std::size_t muscles = c_.model.muscles.size();
    const TendonPath& path = line < muscles ? static_cast<const TendonPath&>(c_.model.muscles[line])
                                            : static_cast<const TendonPath&>(c_.model.tendons[line - muscles]);
    return tendonLength(c_.model, path, bodiesInWorld(c_.model, joints), joints);
  };
  const int n = energy_.degreesOfFreedom();
  Eigen::VectorXd arms(n);
  for (std::size_t line = 0; line < lines; ++line) {
    if (energy_.length(line) == 0.0) continue;
    EXPECT_NEAR(energy_.length(line), lengthAt(line, c_.joints), 1e-12) << "line " << line;
    energy_.momentArms(line, arms);
    for (int i = 0; i < n; ++i) {
      const Eigen::VectorXd w = 1e-6 * Eigen::VectorXd::Unit(n, i);
      const double slope =
          (lengthAt(line, tendonDisplaced(c_, energy_, w)) - lengthAt(line, tendonDisplaced(c_, energy_, -w))) / 2e-6;
      EXPECT_NEAR(arms[i], slope, 1e-8) << "line " << line << ", " << i;
    }
  }
}

/// How the joints differ, by degree of freedom.
Eigen::VectorXd difference(const ArmModel& model, const PotentialEnergy& energy, const std::vector<JointPosition>& from,
                           const std::vector<JointPosition>& to) {
  Eigen::VectorXd way(energy.degreesOfFreedom());
  for (std::size_t j = 0; j < from.size(); ++j) {
    const int d = energy.firstDof(static_cast<int>(j));
    if (model.joints[j].hasAxis()) {
      way[d] = to[j].angle - from[j].angle;
    } else {
      way.segment<3>(d) = logSo3(from[j].rotation.conjugate() * to[j].rotation);
    }
  }
  return way;
}

TEST(ArmOfManyKinds, SensitivitiesOfTheRestAgreeWithDifferencesOfRests) {
  const std::vector<std::string> names = {"muscles.routed.kite_line_length_m", "tendons.spring.rest_length_m",
                                          "bodies.upper.elbow_roll.radius_m", "joints.slide.spring.rest_m",
                                          "muscles.branched.attachments.7.point_m.y"};
  int rested = 0;
  for (int seed = 1; seed <= 12; ++seed) {
    const Drawn c = drawn(seed);
    EquilibriumArm arm(c.model);
    // Where an end enters a surface the line jumps to straight, as MuJoCo has it: some of these arms rest on that edge.
    if (!arm.solveFrom(startPosition(c.model), c.shafts, 400).stable) continue;
    ++rested;
    arm.linearise();
    const std::vector<JointPosition> rest = arm.joints();
    EXPECT_NEAR(rest[3].angle, c.model.joints[3].coupling_offset + 0.6 * rest[2].angle, 1e-15);
    Eigen::MatrixXd columns(arm.energy().degreesOfFreedom(), names.size());
    arm.sensitivities(staticParameters(c.model, names), columns);
    for (std::size_t p = 0; p < names.size(); ++p) {
      const auto restAt = [&](double change) {
        ArmModel changed = c.model;
        visitParameters(changed, [&](const ParameterPath& path, const ParameterKind&, double& value) {
          if (path.str() == names[p]) value += change;
        });
        EquilibriumArm other(changed);
        EXPECT_TRUE(other.solveFrom(rest, c.shafts, 400).stable);
        return other.joints();
      };
      const double h = 1e-5;
      const Eigen::VectorXd slope = difference(c.model, arm.energy(), restAt(-h), restAt(h)) / (2.0 * h);
      EXPECT_LT((columns.col(p) - slope).lpNorm<Eigen::Infinity>(), 2e-3) << names[p] << " of arm " << seed;
    }
  }
  EXPECT_GE(rested, 5);
}

INSTANTIATE_TEST_SUITE_P(Seeds, ArmsOfManyKinds, testing::Range(1, 13));

TEST(ArmOfManyKinds, RestsInTheSimulationWhereItsEnergyIsLeast) {
  const ArmModel model = manyKinds();
  const std::vector<double> shafts = {3.0, 2.0, 6.0, 5.0};
  EquilibriumArm statics(model);
  BulletArm dynamics(model, {.step = 0.001});
  dynamics.setShaftReferences(shafts);
  for (int i = 0; i < 20000; ++i) dynamics.step();
  ASSERT_TRUE(dynamics.isFinite());
  std::vector<double> reached;
  std::vector<JointPosition> joints;
  for (std::size_t m = 0; m < shafts.size(); ++m) reached.push_back(dynamics.shaftAngle(m));
  for (std::size_t j = 0; j < model.joints.size(); ++j) joints.push_back(dynamics.jointPosition(j));
  ASSERT_TRUE(statics.solveFrom(joints, reached, 400).stable);
  for (std::size_t j = 0; j < joints.size(); ++j) {
    EXPECT_LT(dynamics.jointSpeed(j), 1e-6) << model.joints[j].name;
    EXPECT_LT(jointError(model.joints[j].type, joints[j], statics.joints()[j]), 1e-6) << model.joints[j].name;
  }
  EXPECT_GT(dynamics.force(2), 1.0);
  EXPECT_GT(dynamics.force(3), 1.0);
}

// tests/reality/finger: another program's finger, its rests found by differences of an energy written anew.
TEST(Finger, RestsWhereTheIndependentMinimiserFindsIt) {
  const ArmModel model = readArm(YamlNode::load(test::sourceFile("tests/reality/finger/arm.yaml")));
  const CsvTable rests = CsvTable::load(test::sourceFile("tests/reality/finger/rests.csv"));
  EquilibriumArm arm(model);
  ASSERT_GE(rests.rows(), 20u);
  for (std::size_t row = 0; row < rests.rows(); ++row) {
    std::vector<double> shafts;
    for (const Muscle& muscle : model.muscles) shafts.push_back(rests.quantity("shaft_" + muscle.name, "rad")[row]);
    ASSERT_TRUE(arm.solve(shafts).stable) << row;
    for (std::size_t j = 0; j < model.joints.size(); ++j) {
      EXPECT_NEAR(arm.joints()[j].angle, rests.quantity(model.joints[j].name, "rad")[row], 2e-5)
          << model.joints[j].name << " of pose " << row;
    }
  }
}

}  // namespace
}  // namespace simgap
