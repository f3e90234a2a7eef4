// A pneumatic muscle's log.
#include <algorithm>
#include <numeric>
#include <span>

#include "measure/logs/prepared_rows.h"
#include "simgap/measure/logs/log_kind.h"
#include "simgap/measure/logs/motion.h"

namespace simgap::log_kinds::pam {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

/// What a muscle's friction opposes: the change of its contraction or, in sessions at one length, of its pressure.
std::vector<double> changesOf(const PamLog& log, const ActuatorRows& rows) {
  constexpr double kFixedLength = 2e-3;  // spread of a contraction that is held
  std::vector<double> changes(log.rows(), 0.0);
  for (const Block& b : splitRows(log.session, log.rows())) {
    const Index begin = b.begin, n = b.size();
    const auto spread = [&](const ArrayXd& values) {
      return values.segment(begin, n).maxCoeff() - values.segment(begin, n).minCoeff();
    };
    const ArrayXd& moved = spread(rows.contraction) > kFixedLength ? rows.contraction : rows.pressure;
    const double scale = std::max(spread(moved), 1e-300);
    ArrayXd slope = ArrayXd::Zero(n);
    if (log.time.empty()) {  // levels, one after the other
      slope.tail(n - 1) = moved.segment(begin, n).tail(n - 1) - moved.segment(begin, n).head(n - 1);
    } else if (n >= 4) {
      const std::span<const double> time(log.time.data() + b.begin, b.size());
      const std::span<const double> values(moved.data() + begin, b.size());
      slope = toArray(differentiate(time, smooth(time, values, FrictionDataOptions::kDefaultBandwidth / rows.step)));
    }
    ArrayXd::Map(changes.data() + begin, n) = slope / scale;
  }
  return changes;
}

/// How far a muscle went on in its direction between two rows, as a share of the session's range.
ArrayXd shareTravelled(const PamLog& log, const std::vector<double>& changes, const ActuatorRows& rows) {
  ArrayXd travel = ArrayXd::Zero(rows.rows());
  for (Index i = 1; i < rows.rows(); ++i) {
    if (rows.session[i] != rows.session[i - 1]) continue;
    const double dt = log.time.empty() ? 1.0 : rows.time[i] - rows.time[i - 1];
    travel[i] = std::max(0.0, rows.direction[i] * changes[i]) * dt;
  }
  return travel;
}

PreparedLog prepare(const CsvTable& table, const Bench& /*bench*/, const FrictionDataOptions& /*options*/) {
  PamLog muscle = readPamLog(table);
  repairSpikes(muscle);
  std::vector<double> time = muscle.time;
  if (time.empty()) {  // rows in their order
    time.resize(muscle.rows());
    std::iota(time.begin(), time.end(), 0.0);
  }
  PreparedLog log = prepared(ActuatorKind::kPam, muscle.file, time, muscle.session, muscle.session_names);
  log.effort_column = "force_N";
  log.spikes = muscle.spikes;
  leaveOutRows(log.spikes, log.data.keep);
  log.data.effort_unit = log.data.load_unit = "N";
  ActuatorRows& rows = log.data.rows;
  rows.timed = !muscle.time.empty();
  rows.effort = toArray(muscle.force);
  rows.pressure = toArray(muscle.pressure);
  rows.contraction = toArray(muscle.contraction);
  const std::vector<double> changes = changesOf(muscle, rows);
  setDirection(changes, log);
  rows.travel = shareTravelled(muscle, changes, rows);
  addOptional(table, log, {{"pressure", &rows.pressure}, {"contraction", &rows.contraction}});
  return log;
}

}  // namespace

extern const LogKind entry;
const LogKind entry{
    .kind = ActuatorKind::kPam, .name = "pam", .prepare = prepare, .checks = FaultChecks::kLevels, .answer = "force_N"};

}  // namespace simgap::log_kinds::pam
