// Public measured logs beside the repository, against their published figures; skipped where they are missing.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "simgap/fit/actuators/friction_fit.h"
#include "support/files.h"

namespace simgap::test {
namespace {

std::filesystem::path realLog(const std::string& name) {
  for (const char* base : {"../shared/data/real/", "../../shared/data/real/"}) {
    const std::filesystem::path file = sourceFile(base + name);
    if (std::filesystem::exists(file)) return file;
  }
  return {};
}

TEST(RealLogs, IntervalsOfEmpsHoldThePublishedParameters) {
  const std::filesystem::path file = realLog("emps/emps_train.csv.gz");
  if (file.empty()) GTEST_SKIP() << "the EMPS log is not there";
  Bench bench;
  bench.load = BenchLoad::kFreeAxis;
  bench.mass = {1.0, true};
  FrictionFitOptions options;
  options.fixed = {{"k_a", 1.0}};
  options.offset = true;
  for (const bool every_row : {false, true}) {  // as it was published
    FrictionDataOptions data;
    data.bandwidth = 60.0;
    data.raw_sign = every_row;
    const FrictionFit fit =
        fitFriction(friction::find("coulomb"),
                    prepareFrictionData(readActuatorLog(CsvTable::load(file), {}), bench, data), options);
    // Janot, Gautier, Brunot: M 95.109 kg, F_v 203.50 N s/m, F_c 20.394 N, offset -3.165 N.
    const std::map<std::string, double> published = {
        {"mass", 95.109}, {"k_v", 203.50}, {"tau_c", 20.394}, {"offset", -3.165}};
    for (const Estimate& e : fit.uncertainty.estimates) {
      if (e.fixed) continue;
      EXPECT_LE(e.lower95, published.at(e.name)) << e.name;
      EXPECT_GE(e.upper95, published.at(e.name)) << e.name;
      EXPECT_LT(e.sd, (e.name == "mass" ? 0.01 : e.name == "offset" ? 0.1 : 0.05) * std::abs(e.value)) << e.name;
    }
    EXPECT_NEAR(fit.value("mass"), 95.109, 0.005 * 95.109);
    if (every_row) EXPECT_NEAR(fit.value("k_v"), 203.50, 0.01 * 203.50);
  }
}

TEST(RealLogs, TMotorPredictsTorqueBetterThanPublished) {
  const std::filesystem::path file = realLog("tmotor_ak80_9/loaded_trial8_identification.csv.gz");
  if (file.empty()) GTEST_SKIP() << "the T-Motor log is not there";
  CsvOptions csv;
  csv.rename = {{"motor_velocity_rad_s", "output_velocity_rad_s"}, {"external_torque_Nm", "measured_output_torque_Nm"}};
  FrictionDataOptions data;
  data.raw_sign = true;  // every row counts, as in the published figure
  FrictionFitOptions options;
  options.predict_load = true;
  const FrictionFit fit =
      fitFriction(friction::find("variant-a"),
                  prepareFrictionData(readActuatorLog(CsvTable::load(file, csv), {}), {}, data), options);
  EXPECT_EQ(fit.n, 3300u);
  EXPECT_LT(std::sqrt(fit.mse), 1.731);
}

}  // namespace
}  // namespace simgap::test
