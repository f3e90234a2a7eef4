// All joints of the UR10e at once, on its 14-harmonic motion, with the torque constants that others use with it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>

#include "real/real_logs.h"
#include "simgap/core/run_directory.h"
#include "support/files.h"
#include "support/process.h"

namespace simgap::test {
namespace {

TEST(RealRobot, Ur10eHeldOut) {
  if (!realFolder()) GTEST_SKIP() << "no measured logs: set SIMGAP_REAL_DATA";
  const std::filesystem::path log = *realFolder() / "ur10e/fourier_14harm_noload.csv.gz";
  const std::filesystem::path robot = realFolder()->parent_path() / "models/ur10e.urdf";
  if (!std::filesystem::exists(log) || !std::filesystem::exists(robot)) {
    GTEST_SKIP() << "no " << log << " or no " << robot;
  }
  const TemporaryFolder folder;
  std::map<std::string, std::vector<double>> errors;  // held out, of each law and joint
  for (const char* law : {"coulomb", "stribeck", "load-coulomb"}) {
    const ProcessResult done =
        runProcess({SIMGAP_BINARY, "fit-dynamics", robot.string(), "--log", log.string(), "--torque-constants",
                    "14.87,13.26,11.13,10.62,11.03,11.47", "--law", law, "-q", "--force", "-o", "fit"},
                   folder.path());
    ASSERT_EQ(done.exit_code, 0) << done.err;
    const Json result = Json::parse(readText(folder.path() / "fit/result.json"));
    for (const Json& joint : result.at("joints")) {
      const double alone = joint.at("error_alone"), all = joint.at("error_heldout");
      fmt::print("{} {}: alone {:.2f} %, all joints {:.2f} %\n", law, joint.at("name").get<std::string>(),
                 100.0 * alone, 100.0 * all);
      EXPECT_LT(all, alone);
      errors[law].push_back(all);
    }
    // What one joint's model leaves of the shoulder's lift and the elbow is the arm's weight and its coupling.
    EXPECT_LT(result.at("joints")[1].at("error_heldout").get<double>(), 0.06);
    EXPECT_LT(result.at("joints")[2].at("error_heldout").get<double>(), 0.07);
    for (const Json& body : result.at("bodies")) EXPECT_GT(body.at("smallest_moment").get<double>(), 0.0) << body;
  }
  // Where a joint carries the arm, friction grows with what it carries.
  for (const std::size_t joint : {1, 2}) EXPECT_LT(errors["load-coulomb"][joint], 0.85 * errors["coulomb"][joint]);
}

}  // namespace
}  // namespace simgap::test
