// A spring's log: force or torque against one deflection. Its rests stay: what its force does while nothing moves is
// creep. Samples that stand alone and sensors at their limit do not count.
#include "measure/logs/prepared_rows.h"
#include "simgap/core/units.h"
#include "simgap/measure/logs/log_kind.h"
#include "simgap/measure/logs/spring_log.h"

namespace simgap::log_kinds::spring {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

/// Single wrong samples, and sensors at their limit. Wrong samples are replaced: a spring that remembers would carry
/// them on, and a limit is not where they are.
void leaveOutBadSamples(SpringLog& spring, PreparedLog& log) {
  const std::string deflection = quantityName("deflection", spring.deflectionUnit());
  const SearchedChannel channels[] = {{deflection, &spring.deflection, kMotionSpikes},
                                      {log.effort_column, &spring.force, kEffortSpikes}};
  log.spikes = repairSpikes(spring.time, spring.session, channels);
  const ChannelSpikes ends[] = {{deflection, findClipped(spring.deflection, spring.force, spring.session)},
                                {log.effort_column, findClipped(spring.force, spring.deflection, spring.session)}};
  for (const ChannelSpikes& channel : ends) {
    if (!channel.rows.empty()) log.clipped.push_back(channel);
  }
  leaveOutRows(log.spikes, log.data.keep);
  leaveOutRows(log.clipped, log.data.keep);
}

PreparedLog prepare(const CsvTable& table, const Bench& /*bench*/, const FrictionDataOptions& /*options*/) {
  SpringLog spring = readSpringLog(table);
  PreparedLog log = prepared(ActuatorKind::kSpring, spring.file, spring.time, spring.session, spring.session_names);
  log.effort_column = quantityName(spring.forceName(), spring.forceUnit());
  log.data.effort_unit = log.data.load_unit = spring.forceUnit();
  log.data.velocity_unit = spring.angular ? "rad_s" : "m_s";
  leaveOutBadSamples(spring, log);
  ActuatorRows& rows = log.data.rows;
  rows.timed = spring.has_time;
  rows.effort = toArray(spring.force);
  rows.deflection = toArray(spring.deflection);
  if (spring.has_time) {
    rows.speed = slopeOf(rows, rows.deflection, FrictionDataOptions::kDefaultBandwidth / rows.step);
    setDirection({rows.speed.begin(), rows.speed.end()}, log);
  } else {
    ArrayXd change = ArrayXd::Zero(rows.rows());
    change.tail(rows.rows() - 1) = rows.deflection.tail(rows.rows() - 1) - rows.deflection.head(rows.rows() - 1);
    setDirection({change.begin(), change.end()}, log);
  }
  rows.temperature = optional(table, "temperature", "degC", log);
  addContext(table, log, {"deflection", "length", "torque"});
  addContext(log, "deflection", rows.deflection);
  if (spring.has_time) {
    addContext(log, "deflection_rate", rows.speed);
    addContext(log, "time", rows.elapsed);
  }
  return log;
}

}  // namespace

extern const LogKind entry;
const LogKind entry{.kind = ActuatorKind::kSpring,
                    .name = "spring",
                    .prepare = prepare,
                    .checks = FaultChecks::kDeflection,
                    .fits_in_turn = true};

}  // namespace simgap::log_kinds::spring
