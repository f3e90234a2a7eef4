/// \file
/// An arm as another program's internal model: a line of JSON with commands in, a line of JSON with sensors out
/// (docs/formats.md, "An arm served").
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "simgap/core/run_directory.h"
#include "simgap/simulate/rollout.h"

namespace simgap {

class ServedArm {
 public:
  /// \throws ConfigError as RolloutOptions::validate
  ServedArm(const ArmModel& model, const RolloutOptions& options);
  /// The answer to a line; a line that cannot be understood is answered by `{"error": …}` and changes nothing. What
  /// comes out depends on the lines since the last reset alone, to the last bit.
  std::string answer(std::string_view line);
  double time() const { return rollout_.time(); }  ///< [s] since the last reset

 private:
  struct Request;
  Request read(std::string_view line) const;
  bool readLine(const std::string& name, const Json& command, Request& request) const;
  std::string state() const;

  ArmModel model_;
  RolloutOptions options_;
  Rollout rollout_;
  std::vector<CommandKind> kinds_;                                 ///< shape (muscles)
  std::vector<double> commands_;                                   ///< shape (muscles + lines)
  std::vector<const PassiveTendon*> lines_;                        ///< of the model that take a command
  std::vector<std::string> joint_keys_, muscle_keys_, line_keys_;  ///< names as JSON
  bool blown_up_ = false;
};

}  // namespace simgap
