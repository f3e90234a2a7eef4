// What every friction law has to fulfil, whatever it says.
#include "simgap/model/friction/friction_law.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "simgap/core/error.h"

namespace simgap {
namespace {

class FrictionLawTest : public testing::TestWithParam<const FrictionLaw*> {
 protected:
  const FrictionLaw& law() const { return *GetParam(); }
  std::vector<double> theta() const {
    std::vector<double> values;
    for (std::size_t j = 0; j < law().terms.size(); ++j) values.push_back(0.3 + 0.17 * static_cast<double>(j));
    return values;
  }
  StribeckFriction closedForm() const {
    StribeckFriction friction = law().closed_form(theta());
    friction.v_s = 3.0;
    friction.delta = 1.4;
    return friction;
  }
  /// The sum over the terms, as the fit sees the law.
  double sumOfTerms(double w, double direction, double load) const {
    const double still = std::exp(-std::pow(std::abs(w) / 3.0, 1.4));
    double sum = 0.0;
    for (std::size_t j = 0; j < law().terms.size(); ++j) {
      const FrictionTerm& term = law().terms[j];
      const double x = term.basis == FrictionBasis::kLoad        ? std::abs(load) * direction
                       : term.basis == FrictionBasis::kDirection ? direction
                                                                 : w;
      const double shape = term.shape == FrictionShape::kAlways    ? 1.0
                           : term.shape == FrictionShape::kSliding ? 1.0 - still
                                                                   : still;
      sum += theta()[j] * x * shape;
    }
    return sum;
  }
};

TEST_P(FrictionLawTest, TermsAndClosedFormAreTheSameLaw) {
  const StribeckFriction friction = closedForm();
  for (const double w : {-20.0, -2.0, -0.1, 0.0, 0.5, 3.0, 40.0}) {
    for (const double load : {-7.0, 0.0, 2.0}) {
      for (const double direction : {-1.0, 1.0}) {
        EXPECT_NEAR(friction.torque(w, direction, load), sumOfTerms(w, direction, load), 1e-12);
      }
    }
  }
}

TEST_P(FrictionLawTest, IsOddInMotionAndEvenInLoad) {
  const StribeckFriction friction = closedForm();
  for (const double w : {0.2, 5.0}) {
    EXPECT_DOUBLE_EQ(friction.torque(-w, -1.0, 4.0), -friction.torque(w, 1.0, 4.0));
    EXPECT_DOUBLE_EQ(friction.torque(w, 1.0, -4.0), friction.torque(w, 1.0, 4.0));
    EXPECT_GT(friction.torque(w, 1.0, 4.0), 0.0);
  }
}

TEST_P(FrictionLawTest, SaysWhatItIs) {
  EXPECT_FALSE(law().summary.empty());
  EXPECT_FALSE(law().equation.empty());
  EXPECT_FALSE(law().source.empty());
  std::set<std::string_view> names;
  for (const FrictionTerm& term : law().terms) EXPECT_TRUE(names.insert(term.name).second);
  EXPECT_EQ(&friction::find(law().name), &law());
}

INSTANTIATE_TEST_SUITE_P(AllLaws, FrictionLawTest, testing::ValuesIn(friction::all().begin(), friction::all().end()),
                         [](const auto& instance) {
                           std::string name(instance.param->name);
                           for (char& c : name) c = c == '-' ? '_' : c;
                           return name;
                         });

TEST(FrictionLaws, UnknownOneListsTheKnown) {
  try {
    friction::find("variant-c");
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("variant-b"), std::string::npos);
  }
}

TEST(DirectionHold, KeepsTheLastDirectionThroughTheDeadBand) {
  DirectionHold hold(0.5);
  EXPECT_EQ(hold.update(0.1), 0.0);
  EXPECT_EQ(hold.update(2.0), 1.0);
  EXPECT_EQ(hold.update(-0.4), 1.0);
  EXPECT_EQ(hold.update(-0.6), -1.0);
}

}  // namespace
}  // namespace simgap
