// design --drive, as a user runs it.
#include <algorithm>

#include "cli_fixture.h"
#include "simgap/core/csv.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {
namespace {

const std::string kLimits = sourceFile("data/logs/drive-limits.yaml").string();

class DesignDriveTest : public CliTest {};

TEST_F(DesignDriveTest, WritesTheLogToRecord) {
  succeed({"design", "--drive", kLimits, "-q", "-o", "next"});
  const Json result = Json::parse(text("next/result.json"));
  EXPECT_EQ(result.at("format"), "simgap/bench-protocol/1");
  EXPECT_GT(result.at("sd_ratio").at("best_random").get<double>(), 1.0);
  EXPECT_EQ(result.at("parameters").size(), 8u);
  EXPECT_EQ(result.at("sessions").size(), 15u);
  const CsvTable rows = CsvTable::parse(text("next/protocol.csv"), "protocol.csv");
  EXPECT_EQ(rows.rows(), 15000u);
  const std::vector<double> angles = rows.quantity("joint_position", "rad");
  auto first = angles.begin();
  for (const Json& session : result.at("sessions")) {  // what is said of a session is what its rows do
    const auto [lower, upper] = std::minmax_element(first, first + 1000);
    EXPECT_NEAR(session.at("lower_rad").get<double>(), *lower, 1e-9) << session;
    EXPECT_NEAR(session.at("upper_rad").get<double>(), *upper, 1e-9) << session;
    first += 1000;
  }
  EXPECT_NE(text("next/report.html").find("Load over velocity"), std::string::npos);
  // What is to be recorded is a log that fit-friction reads: without noise it finds what the limits say.
  succeed({"fit-friction", "next/protocol.csv", "--ratio", "97.74", "--model", "variant-b", "-q", "-o", "fit"});
  const Json fitted = Json::parse(text("fit/result.json"));
  for (const Json& p : fitted.at("parameters")) {
    for (const Json& given : result.at("parameters")) {
      if (given.at("name") != p.at("name")) continue;
      EXPECT_NEAR(p.at("value").get<double>(), given.at("value").get<double>(), 0.01 * given.at("value").get<double>())
          << p;
    }
  }
}

TEST_F(DesignDriveTest, TakesAFittedDriveInsteadOfAGuess) {
  succeed({"fit-friction", sourceFile("data/logs/none.csv.gz").string(), "--model", "classic", "-q", "-o", "fit"});
  std::string limits = readText(kLimits);
  limits = replaced(limits.substr(0, limits.find("law:")), "duration_s: 300", "duration_s: 60");
  put("limits.yaml", limits);
  succeed({"design", "--drive", "limits.yaml", "fit/model.yaml", "-q", "-o", "next"});
  EXPECT_EQ(Json::parse(text("next/result.json")).at("law"), "classic");
  expectRefused({"design", "--drive", "limits.yaml", "-o", "other"}, 2, "law");
  expectRefused({"design", "--drive", kLimits, "fit/model.yaml", "-o", "other"}, 2, "expected one");
}

TEST_F(DesignDriveTest, SameForAnyNumberOfThreads) {
  put("limits.yaml", replaced(readText(kLimits), "duration_s: 300", "duration_s: 60"));
  succeed({"design", "--drive", "limits.yaml", "--threads", "1", "-q", "-o", "next"});
  const std::string one = text("next/result.json"), rows = text("next/protocol.csv");
  succeed({"design", "--drive", "limits.yaml", "--threads", "2", "-q", "--force", "-o", "next"});
  EXPECT_EQ(text("next/result.json"), one);
  EXPECT_EQ(text("next/protocol.csv"), rows);
}

TEST_F(DesignDriveTest, WhatCannotBeIsOneSentence) {
  expectRefused({"design", "--drive", "missing.yaml", "-o", "next"}, 2, "missing.yaml");
  expectRefused({"design", "--drive", kLimits, "--poses", "poses.csv", "-o", "next"}, 2, "found --drive LIMITS with");
  put("limits.yaml", replaced(readText(kLimits), "torque_Nm: 20", "torque_Nm: many"));
  expectRefused({"design", "--drive", "limits.yaml", "-o", "next"}, 2, "torque_Nm");
}

}  // namespace
}  // namespace simgap::test
