// diagnose on the log of every joint of the sample robot, as a user runs it: one who fitted it before, and one day
// finds another robot.
#include <functional>
#include <map>

#include "cli_fixture.h"
#include "simgap/core/csv.h"

namespace simgap::test {
namespace {

/// What a day does to a log, shape (rows): of a column, by its name.
using Change = std::function<double(const std::vector<double>& column, std::size_t row)>;

class DiagnoseRobot : public CliTest {
 protected:
  /// The sample's other log with some columns changed, as today.csv.
  void record(const std::map<std::string, Change>& changes) const {
    const CsvTable log = CsvTable::load(robotFile("other_log.csv.gz"));
    CsvWriter changed(log.columns());
    std::map<std::string, std::vector<double>> values;
    for (const std::string& name : log.columns()) {
      const std::size_t unit = name.rfind('_');
      values[name] = log.quantity(name.substr(0, unit), name.substr(unit + 1));
    }
    for (std::size_t row = 0; row < log.rows(); ++row) {
      for (const std::string& name : log.columns()) {
        const auto change = changes.find(name);
        changed.add(change == changes.end() ? values[name][row] : change->second(values[name], row));
      }
      changed.endRow();
    }
    put("today.csv", changed.text());
  }
  Json diagnosis() const {
    succeed({"fit-dynamics", robotFile("robot.urdf"), "--log", robotFile("log.csv.gz"), "-q", "-o", "known"});
    succeed({"diagnose", "known/model.yaml", "--log", "today.csv", "-q", "-o", "why"});
    return Json::parse(text("why/result.json"));
  }
};

TEST_F(DiagnoseRobot, IsSilentOnTheRobotItKnows) {
  record({});
  const Json result = diagnosis();
  EXPECT_EQ(result.at("verdict"), "nothing-found") << result.at("sentence");
  EXPECT_TRUE(result.at("causes").empty());
}

TEST_F(DiagnoseRobot, NamesTheJointWhoseTorqueIsWorthLess) {
  // A drive whose constant has fallen by a tenth: its controller asks for more, and logs more.
  record({{"torque_j2_Nm", [](const std::vector<double>& torque, std::size_t row) { return torque[row] / 0.9; }}});
  const Json result = diagnosis();
  ASSERT_EQ(result.at("causes").size(), 1u) << result.at("sentence");
  const Json& cause = result.at("causes")[0];
  EXPECT_EQ(cause.at("effect"), "torque-constant");
  EXPECT_EQ(cause.at("target"), "j2");
  const Json& ci = cause.at("parameters")[0].at("ci95");
  EXPECT_LT(ci[0].get<double>(), -0.1);
  EXPECT_GT(ci[1].get<double>(), -0.1);
  const std::string page = text("why/report.html");
  EXPECT_NE(page.find("torque-constant"), std::string::npos);
  // Efforts were logged as torques: no number of the robot's file would be another.
  EXPECT_FALSE(std::filesystem::exists(path("why/model.yaml")));
  EXPECT_EQ(result.at("not_held"), Json::parse(R"(["torque-constant:j2"])"));
}

TEST_F(DiagnoseRobot, NamesTwoCausesOfTwoJoints) {
  // One joint's zero is lost, and another's drive has a tenth less torque.
  record({{"j3_rad", [](const std::vector<double>& angle, std::size_t row) { return angle[row] - 0.08; }},
          {"torque_j2_Nm", [](const std::vector<double>& torque, std::size_t row) { return torque[row] / 0.9; }}});
  const Json result = diagnosis();
  std::map<std::string, std::string> named;
  for (const Json& cause : result.at("causes")) named[cause.at("target")] = cause.at("effect");
  EXPECT_EQ(named, (std::map<std::string, std::string>{{"j2", "torque-constant"}, {"j3", "joint-offset"}}))
      << result.at("sentence");
}

TEST_F(DiagnoseRobot, SameForAnyNumberOfThreads) {
  record({});
  succeed({"fit-dynamics", robotFile("robot.urdf"), "--log", robotFile("log.csv.gz"), "-q", "-o", "known"});
  succeed({"diagnose", "known/model.yaml", "--log", "today.csv", "--threads", "1", "-q", "-o", "one"});
  succeed({"diagnose", "known/model.yaml", "--log", "today.csv", "--threads", "2", "-q", "-o", "two"});
  EXPECT_EQ(text("one/result.json"), text("two/result.json"));
}

TEST_F(DiagnoseRobot, WhatCannotBeIsOneSentence) {
  succeed({"fit-dynamics", robotFile("robot.urdf"), "--log", robotFile("log.csv.gz"), "-q", "-o", "known"});
  put("short.csv", "time_s,j1_rad\n0,0\n");
  expectRefused({"diagnose", "known/model.yaml", "--log", "short.csv", "-o", "why"}, 3, "joint j1");
  expectRefused({"diagnose", "known/model.yaml", "-o", "why"}, 2, "--log");
}

}  // namespace
}  // namespace simgap::test
