#include "simgap/fit/actuators/prediction.h"

#include <gtest/gtest.h>

#include <cmath>

#include "simgap/core/error.h"

namespace simgap {
namespace {

FittedModel modelOf(const std::string& kind, const std::string& law,
                    std::initializer_list<std::pair<const char*, double>> values) {
  FittedModel model;
  model.kind = kind;
  model.law = law;
  for (const auto& [name, value] : values) {
    Estimate p;
    p.name = name;
    p.value = value;
    model.parameters.push_back(p);
  }
  return model;
}

TEST(Prediction, OfAMuscleIsItsForceAndBackItsPressure) {
  // f = p (a e^2 + b e + c), without a spring
  const FittedModel model = modelOf("pam", "no-spring", {{"a", 2e-3}, {"b", -4e-3}, {"c", 1e-3}});
  const CsvTable table = CsvTable::parse("pressure_Pa,contraction,force_N\n2e5,0.1,124\n4e5,0.2,100\n", "muscle.csv");
  const Prediction force = predictLog(model, table, {}, {});
  ASSERT_EQ(force.predicted.size(), 2u);
  EXPECT_NEAR(force.predicted[0], 2e5 * (2e-3 * 0.01 - 4e-4 + 1e-3), 1e-9);
  EXPECT_NEAR(force.predicted[1], 4e5 * (2e-3 * 0.04 - 8e-4 + 1e-3), 1e-9);
  EXPECT_EQ(force.unit, "N");
  const Prediction pressure = predictLog(model, table, {}, {true, {}, "m.yaml"});
  EXPECT_NEAR(pressure.predicted[0], 2e5, 1e-3);  // 124 N is what the first row's pressure gives
  EXPECT_EQ(pressure.measured[1], 4e5);
}

TEST(Prediction, CountsWhatNoPressureGives) {
  const FittedModel model = modelOf("pam", "no-spring", {{"a", 2e-3}, {"b", -4e-3}, {"c", 1e-3}});
  const Prediction pressure =
      predictLog(model, CsvTable::parse("pressure_Pa,contraction,force_N\n2e5,0.1,124\n2e5,0.9,50\n", "m.csv"), {},
                 {true, {}, "m.yaml"});
  EXPECT_EQ(pressure.refused, 1u);  // g(0.9) < 0: it cannot pull there
  EXPECT_TRUE(std::isnan(pressure.predicted[1]));
}

TEST(Prediction, OfAMotorNeedsWhatDrivesIt) {
  const FittedModel model =
      modelOf("motor", "motor",
              {{"R", 1.0}, {"L", 1e-4}, {"K_E", 0.02}, {"K_T", 0.02}, {"J_M", 1e-5}, {"mu_M", 1e-5}, {"tau_CM", 1e-3}});
  EXPECT_THROW(predictLog(model, CsvTable::parse("time_s,velocity_rad_s\n0,1\n0.1,2\n0.2,3\n", "m.csv"), {}, {}),
               DataError);
}

TEST(Prediction, TurnedRoundIsRefusedWhereItMeansNothing) {
  const CsvTable none = CsvTable::parse("time_s\n0\n", "log.csv");
  for (const char* kind : {"spring", "friction"}) {
    EXPECT_THROW(predictLog(modelOf(kind, "coulomb", {}), none, {}, {true, {}, "m.yaml"}), ConfigError) << kind;
  }
}

TEST(Prediction, ErrorIsOverRowsThatHaveBoth) {
  Prediction p{"force", "N", {}, {1.0, 2.0, std::nan("")}, {1.0, 5.0, 9.0}, 1};
  EXPECT_NEAR(rmsError(p).value(), 3.0 / std::sqrt(2.0), 1e-12);
  p.measured.clear();
  EXPECT_FALSE(rmsError(p).has_value());
}

}  // namespace
}  // namespace simgap
