/// \file
/// What `diagnose --log` and `fit-* --model FILE` share: the model of a drive, its log, and the model file that comes
/// out.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "simgap/cli/command.h"
#include "simgap/cli/session.h"
#include "simgap/diagnose/logs/log_diagnosis.h"
#include "simgap/measure/logs/bench.h"
#include "simgap/model/actuator/fitted_model.h"

namespace simgap {

/// A file, not the name of a law.
bool namesFile(const std::string& model);

/// \param model  a file, or a name: of a friction law, motor, gearbox, or pam. \param fitted  set to what a file holds.
ActuatorModel readSubject(const std::string& model, Session& session, FittedModel& fitted);

/// The rig of a file, or a torque sensor without one; `ratio` replaces its own.
Bench readRig(Session& session, const std::string& file, std::optional<double> ratio);

PreparedLog prepareLog(const CsvTable& table, const Bench& bench, ActuatorKind kind,
                       FrictionDataOptions data_options = {});

/// A model as any other command reads it: the law refitted to the log, with the effects of `fit`.
FittedModel modelFile(const FittedModel& given, const ActuatorModel& subject, const LogFit& fit,
                      const ActuatorData& data, double dead_band, std::size_t rows, const Input& log);

/// time_s, measured, predictions by name, and whether a row counts.
std::string predictionsCsv(const PreparedLog& log,
                           const std::vector<std::pair<std::string, const Eigen::ArrayXd*>>& predictions);

/// `fit-* LOG --model FILE`: law and extensions of a diagnosed model, fitted together to a log.
struct ExtendedFitOptions {
  std::string command;  ///< "fit-friction"
  std::string model, log;
  Bench bench;
  CsvOptions csv;
};
/// \throws ConfigError: a model of another kind than the command fits.
ExitCode fitExtended(const ExtendedFitOptions& options, Session& session, const CommonOptions& common,
                     const CLI::App& app);

}  // namespace simgap
