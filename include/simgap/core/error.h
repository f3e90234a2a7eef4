/// \file
/// Errors a user can cause. Each carries the exit code of the command line contract; a programmer's error asserts.
#pragma once

#include <stdexcept>
#include <string>

namespace simgap {

/// Exit codes of every command.
enum class ExitCode : int {
  kDone = 0,
  kCriterionFailed = 1,  ///< ran, but a criterion the user set failed
  kUsage = 2,            ///< usage or configuration
  kBadData = 3,          ///< bad input data
  kNumerics = 4,         ///< no valid individual, a fit that did not converge
  kInternal = 70,        ///< a bug
  kInterrupted = 130,    ///< interrupted; the state is saved
};

/// One clear sentence for the user: where, what was found, what was expected.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& sentence) : std::runtime_error(sentence), code_(code) {}
  ExitCode code() const noexcept { return code_; }

 private:
  ExitCode code_;
};

/// Wrong options, or a wrong YAML file (model, configuration).
struct ConfigError : Error {
  explicit ConfigError(const std::string& sentence) : Error(ExitCode::kUsage, sentence) {}
};

/// Wrong measured data (CSV).
struct DataError : Error {
  explicit DataError(const std::string& sentence) : Error(ExitCode::kBadData, sentence) {}
};

/// The numerics failed; the sentence says why.
struct NumericsError : Error {
  explicit NumericsError(const std::string& sentence) : Error(ExitCode::kNumerics, sentence) {}
};

/// The user interrupted; the sentence names the resume command.
struct InterruptedError : Error {
  explicit InterruptedError(const std::string& sentence) : Error(ExitCode::kInterrupted, sentence) {}
};

}  // namespace simgap
