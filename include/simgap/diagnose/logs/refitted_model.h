/// \file
/// The model file that comes out of a diagnosis or a refit: the law anew, with its effects.
#pragma once

#include <string>

#include "simgap/diagnose/logs/log_diagnosis.h"
#include "simgap/model/actuator/fitted_model.h"

namespace simgap {

/// The log that a model was fitted to.
struct LogSource {
  std::string file, sha256;
  std::size_t rows = 0;  ///< that counted
};

/// A model as any other command reads it: the law refitted to the log, with the effects of `fit`.
/// \param given  what the user's file held, empty for a law by name.
FittedModel refittedModel(const FittedModel& given, const ActuatorModel& subject, const LogFit& fit,
                          const PreparedLog& log, const LogSource& source);

}  // namespace simgap
