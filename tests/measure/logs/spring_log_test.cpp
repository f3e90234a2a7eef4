// Logs of springs: what is read, what is left out, and that rests stay.
#include "simgap/measure/logs/spring_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "simgap/core/error.h"
#include "simgap/measure/logs/prepared_log.h"

namespace simgap::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

CsvTable table(const std::string& text) { return CsvTable::parse(text, "log.csv"); }

std::string refusal(const std::string& text) {
  try {
    static_cast<void>(readSpringLog(table(text)));
  } catch (const DataError& error) {
    return error.what();
  }
  return "nothing was refused";
}

TEST(SpringLog, ReadsLengthsAndAnglesInTheirUnits) {
  const SpringLog line = readSpringLog(table("deflection_mm,force_N\n1,2\n3,4\n"));
  EXPECT_THAT(line.deflection, ElementsAre(0.001, 0.003));
  EXPECT_FALSE(line.angular || line.own_length || line.has_time);
  EXPECT_THAT(line.time, ElementsAre(0.0, 1.0));
  const SpringLog cord = readSpringLog(table("time_s,length_m,force_N\n0,1,2\n0.5,3,4\n"));
  EXPECT_TRUE(cord.own_length && cord.has_time);
  const SpringLog torsion = readSpringLog(table("deflection_deg,torque_mNm\n180,2000\n"));
  EXPECT_TRUE(torsion.angular);
  EXPECT_NEAR(torsion.deflection[0], M_PI, 1e-12);
  EXPECT_DOUBLE_EQ(torsion.force[0], 2.0);
}

TEST(SpringLog, RefusesWhatIsNoSpring) {
  EXPECT_THAT(refusal("deflection_m,deflection_rad,force_N\n1,2,3\n"), HasSubstr("a deflection in m and one in rad"));
  EXPECT_THAT(refusal("deflection_m,torque_Nm\n1,2\n"), HasSubstr("force"));
  EXPECT_THAT(refusal("force_N\n1\n"), HasSubstr("deflection"));
  EXPECT_THAT(refusal("time_s,deflection_m,force_N\n0,1,2\n0,2,3\n"), HasSubstr("log.csv:3"));
}

TEST(SpringLog, ALimitIsWhereOneChannelMovesOnWithoutTheOther) {
  std::vector<double> force, deflection;
  for (int i = 0; i < 400; ++i) {
    deflection.push_back(std::sin(0.05 * i));
    force.push_back(std::min(100.0 * deflection.back(), 80.0));
  }
  const std::vector<int> session(400, 0);
  const std::vector<std::size_t> rows = findClipped(force, deflection, session);
  EXPECT_EQ(static_cast<long>(rows.size()), std::ranges::count(force, 80.0));
  EXPECT_TRUE(std::ranges::all_of(rows, [&](std::size_t i) { return force[i] == 80.0; }));
  EXPECT_TRUE(findClipped(deflection, force, session).empty());
  // Held at its largest value, as often as one likes: no limit.
  std::vector<double> held_force, held;
  for (int i = 0; i < 400; ++i) {
    held.push_back(0.01 * std::round(100.0 * std::min(std::abs(std::sin(0.05 * i)), 0.5)));
    held_force.push_back(100.0 * held.back());
  }
  EXPECT_TRUE(findClipped(held_force, held, session).empty());
}

TEST(SpringLog, RestsStayAndWrongSamplesGo) {
  std::string text = "time_s,deflection_m,force_N\n";
  for (int i = 0; i < 600; ++i) {
    const double x = std::min(0.001 * i, 0.2) + (i == 100 ? 0.5 : 0.0);
    text += std::to_string(0.02 * i) + "," + std::to_string(x) + "," +
            std::to_string(100.0 * std::min(0.001 * i, 0.2) + 0.01 * std::sin(1.7 * i) - (i == 150 ? 9.0 : 0.0)) + "\n";
  }
  const PreparedLog log = prepareLog(table(text), {}, ActuatorKind::kSpring);
  ASSERT_EQ(log.spikes.size(), 2u);
  EXPECT_THAT(log.spikes[0].rows, ElementsAre(100));
  EXPECT_THAT(log.spikes[1].rows, ElementsAre(150));
  EXPECT_NEAR(log.data.rows.deflection[100], 0.1, 1e-9);
  EXPECT_EQ(std::ranges::count(log.data.keep, false), 2) << "rows at rest are evidence";
}

}  // namespace
}  // namespace simgap::test
