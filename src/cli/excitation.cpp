#include "excitation.h"

#include <fmt/format.h>

#include "cli/robot_inputs.h"
#include "simgap/core/progress.h"
#include "simgap/report/actuators/excitation_report.h"

namespace simgap {

ExitCode designExcitation(const ExciteOptions& options, const std::vector<std::string>& argv) {
  Session session("design", options.common, argv);
  ExcitationReport report;
  report.robot = readRobotFile(session, options.robot, options.gravity);
  report.law = options.law;
  const FrictionLaw& law = friction::find(options.law);
  report.limits = ExcitationLimits::read(
      YamlNode::parse(session.read("limits", options.limits).content, options.limits), report.robot);
  if (options.common.dry_run) {
    session.print(fmt::format("would search a motion of {:g} s for {} joints; nothing was written\n",
                              report.limits.duration, report.limits.joints.size()));
    return ExitCode::kDone;
  }
  const std::uint64_t seed = options.common.seed.value_or(1);
  session.begin(seed);
  {
    constexpr std::size_t kSteps = 1000;
    Progress progress("design", kSteps, options.common.quiet, Progress::Unit::kPercent);
    report.found = exciteRobot(report.robot, law, report.limits, seed,
                               [&](double share) { progress.update(static_cast<std::size_t>(kSteps * share)); });
  }
  session.directory().write("trajectory.csv", trajectoryCsv(report));
  session.directory().write("trajectory.json", rosTrajectory(report).dump() + "\n");
  const Json result = toJson(report);
  session.finish(result, excitationText(result));
  return ExitCode::kDone;
}

}  // namespace simgap
