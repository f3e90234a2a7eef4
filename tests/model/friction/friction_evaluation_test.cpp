#include "simgap/model/friction/friction_evaluation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace simgap {
namespace {

class LawOverRows : public testing::TestWithParam<const FrictionLaw*> {};

// Speeds and loads of both signs; the columns' sum is the law's closed form.
TEST_P(LawOverRows, ColumnsAddUpToTheClosedForm) {
  const FrictionLaw& law = *GetParam();
  const Eigen::ArrayXd velocity = Eigen::ArrayXd::LinSpaced(40, -10.1, 9.9);
  const Eigen::ArrayXd load = Eigen::ArrayXd::LinSpaced(40, 5.0, -3.0);
  const Eigen::ArrayXd direction = velocity.sign();
  std::vector<double> theta;
  for (std::size_t j = 0; j < law.terms.size(); ++j) theta.push_back(0.3 + 0.1 * static_cast<double>(j));
  const double v_s = 2.0, delta = 1.3;
  const StribeckFactor stribeck = stribeckFactor(velocity.abs().log(), v_s, delta);
  Eigen::ArrayXd torque = Eigen::ArrayXd::Zero(velocity.size());
  for (std::size_t j = 0; j < law.terms.size(); ++j) {
    visitBasis(law.terms[j].basis, load.abs(), direction, velocity, [&](const auto& column) {
      visitShape(law.terms[j].shape, column, stribeck.value, [&](const auto& shaped) { torque += theta[j] * shaped; });
    });
  }
  StribeckFriction closed = law.closed_form(theta);
  closed.v_s = v_s;
  closed.delta = delta;
  for (Eigen::Index i = 0; i < velocity.size(); ++i) {
    EXPECT_NEAR(torque[i], closed.torque(velocity[i], direction[i], load[i]), 1e-13) << "row " << i;
  }
}

TEST_P(LawOverRows, ParametersAreTheTermsAndWhatTheStribeckFactorNeeds) {
  const FrictionLaw& law = *GetParam();
  const std::vector<ParameterSpec> terms = termParameters(law, "Nm");
  ASSERT_EQ(terms.size(), law.terms.size());
  for (std::size_t j = 0; j < terms.size(); ++j) {
    EXPECT_EQ(terms[j].name, law.terms[j].name);
    EXPECT_EQ(terms[j].lower, 0.0);
    EXPECT_EQ(terms[j].unit == "1", law.terms[j].basis == FrictionBasis::kLoad);
  }
  const std::vector<ParameterSpec> curve = stribeckParameters(law, 7.0, "rad_s");
  ASSERT_EQ(curve.size(), law.hasStribeck() ? 2U : 0U);
  if (curve.empty()) return;
  EXPECT_EQ(curve[0].name, "v_s");
  EXPECT_EQ(curve[1].name, "delta");
  // At the ends of the box the factor is 1 or 0 wherever a log has rows: no curve outside tells more.
  const Eigen::ArrayXd speeds = Eigen::ArrayXd::LinSpaced(50, 0.07, 7.0).log();
  EXPECT_GT(stribeckFactor(speeds, curve[0].upper, 2.0).value.minCoeff(), 0.98);
  EXPECT_LT(stribeckFactor(speeds, curve[0].lower, 2.0).value.maxCoeff(), 1e-100);
}

INSTANTIATE_TEST_SUITE_P(All, LawOverRows, testing::ValuesIn(friction::all().begin(), friction::all().end()),
                         [](const auto& law) {
                           std::string name(law.param->name);
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

TEST(StribeckFactor, IsFiniteForTheSteepestCurveFarAboveItsVelocity) {
  const StribeckFactor factor = stribeckFactor(Eigen::ArrayXd::Constant(1, std::log(1e30)), 1e-6, 20.0);
  EXPECT_EQ(factor.value[0], 0.0);
  EXPECT_TRUE(std::isfinite(factor.exponent[0]));
  EXPECT_EQ(factor.exponent[0] * factor.value[0], 0.0);  // what derivatives are made of
}

}  // namespace
}  // namespace simgap
