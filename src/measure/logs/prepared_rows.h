/// \file
/// What the preparations of all kinds of logs share.
#pragma once

#include <initializer_list>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "simgap/measure/logs/prepared_log.h"

namespace simgap {

Eigen::ArrayXd toArray(const std::vector<double>& values);

/// What all logs have; channels without meaning for this kind are 0.
PreparedLog prepared(ActuatorKind kind, const std::string& file, const std::vector<double>& time,
                     const std::vector<int>& session, const std::vector<std::string>& session_names);

/// A drive's rows, standstill included. \throws DataError as readActuatorLog and prepareFrictionData.
PreparedLog prepareDrive(const CsvTable& table, const Bench& bench, const FrictionDataOptions& options);

/// Length of the blocks [s]: the time within sessions, cut into as many as are long enough.
double blockSecondsOf(const std::vector<double>& time, const std::vector<int>& session);
double medianStep(const ActuatorRows& rows);

/// \name Channels that no model needs.
///@{
/// One of them, or nothing: also where it was logged more slowly than the rest, which `log` then says.
Eigen::ArrayXd optional(const CsvTable& table, const char* stem, const char* unit, PreparedLog& log);
/// A channel that the residual may depend on.
void addContext(PreparedLog& log, const std::string& name, const Eigen::ArrayXd& values);
/// Numeric columns that no quantity of the model came from. A command or an estimate that follows the effort is no
/// cause: it says what was measured once more. \param own  further stems that the model reads.
void addContext(const CsvTable& table, PreparedLog& log, const std::set<std::string>& own = {});
/// What a winding's and a muscle's log may hold besides the model's own channels, which may hide a cause as well.
void addOptional(const CsvTable& table, PreparedLog& log,
                 std::initializer_list<std::pair<const char*, const Eigen::ArrayXd*>> own);
///@}

/// \name Motion and history.
///@{
/// d values / dt of the smoothed values, run by run.
Eigen::ArrayXd slopeOf(const ActuatorRows& rows, const Eigen::ArrayXd& values, double bandwidth);
/// Travel in the direction of motion since the row before, by trapezia; after a reversal since the turning point.
Eigen::ArrayXd travelOf(const ActuatorRows& rows);
/// How long the current rest lasts, or, in motion, the last one lasted [s].
Eigen::ArrayXd restOf(const ActuatorRows& rows, double dead_band);
/// The held sign of what moves, with its dead band and top speed.
void setDirection(const std::vector<double>& motion, PreparedLog& log);
/// Before the first motion the direction is unknown: those rows do not count, but every number has to be one.
void fillDirection(ActuatorRows& rows);
///@}

/// Rows whose samples mean nothing.
void leaveOutRows(const std::vector<ChannelSpikes>& channels, std::vector<bool>& keep);
/// Rows in and beside a jump: where a rate of change is far above its usual size, sampling and smoothing have blurred
/// it.
void leaveOutJumps(const Eigen::ArrayXd& rate, std::vector<bool>& keep);

}  // namespace simgap
