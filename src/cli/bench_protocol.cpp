#include "bench_protocol.h"

#include <fmt/format.h>

#include "cli/inputs.h"
#include "simgap/core/progress.h"
#include "simgap/report/actuators/protocol_report.h"

namespace simgap {

ExitCode designBench(const DriveDesignOptions& options, const std::vector<std::string>& argv) {
  Session session("design", options.common, argv);
  std::optional<FittedModel> fitted;
  if (!options.model.empty()) fitted = readModel(session, "model", options.model, {"friction"});
  ProtocolReport report;
  report.limits = DriveLimits::read(YamlNode::parse(session.read("limits", options.limits).content, options.limits),
                                    fitted ? &*fitted : nullptr);
  if (options.common.dry_run) {
    session.print(fmt::format("would choose {} sessions of {:g} s; nothing was written\n", report.limits.sessions(),
                              report.limits.session));
    return ExitCode::kDone;
  }
  const std::uint64_t seed = options.common.seed.value_or(1);
  session.begin(seed);
  {
    constexpr std::size_t kSteps = 1000;
    Progress progress("design", kSteps, options.common.quiet, Progress::Unit::kPercent);
    report.found = designProtocol(report.limits, seed,
                                  [&](double share) { progress.update(static_cast<std::size_t>(kSteps * share)); });
  }
  session.directory().write("protocol.csv", protocolCsv(report));
  const Json result = toJson(report);
  session.finish(result, protocolText(result));
  return ExitCode::kDone;
}

}  // namespace simgap
