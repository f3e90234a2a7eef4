/// \file
/// `simgap diagnose` as the real program on logs with a secret: it sees files only, the test reads result.json. A study
/// is many such cases. It may be run in pieces: with SIMGAP_STUDY_FILE every case is kept there as a line of JSON, and
/// read from there the next time; with SIMGAP_STUDY_PART=k/n only every n-th case is run, beginning with the k-th.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "reality/drive_draws.h"
#include "reality/servo_draws.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {

/// A log with something hidden in it, of either rig, and how to ask for it.
struct HiddenLog {
  std::string rig;                   ///< "prescribed" (drive_rig.h) or "servo" (servo_rig.h)
  std::vector<std::string> effects;  ///< names of the catalogue; "none"; or "outside: …"
  std::string channel;               ///< outside the catalogue: the channel it depends on
  std::uint64_t seed = 0;
  std::string law;
  std::vector<std::string> options;
  std::string bench;                                     ///< YAML; empty: none is needed
  std::optional<std::pair<std::string, double>> stated;  ///< parameter of the cause and its true value
  std::function<std::string()> csv;
  std::function<std::string()> plain_csv;  ///< the same log as if nothing were hidden
  std::function<std::string()> fresh_csv;  ///< another motion with the same secret; empty: it cannot come again
};

HiddenLog hiddenLog(const reality::DriveDraw& draw);
HiddenLog hiddenLog(const reality::ServoDraw& draw);

/// What the program said of one log, and how right that is.
struct StudyCase {
  std::string rig, hidden, verdict;
  std::uint64_t seed = 0;
  double worth = 0.0;  ///< share of the baseline's squared error on held-out data that is the secret's
  std::vector<std::vector<std::string>> named;  ///< a cause, with those it cannot be told from
  bool channel_right = false;                   ///< what is left names the channel of what is hidden
  std::optional<bool> interval_right;           ///< the stated parameter lies in its 95 % interval
  std::optional<bool> fresh_right;              ///< so does the gain on a fresh log
  double seconds = 0.0;

  bool silent() const { return verdict == "nothing-found"; }
  bool namedAlone(const std::string& effect) const;
  bool namedInGroup(const std::string& effect) const;  ///< alone, or in a group of at most three
  bool names(const std::string& effect) const;         ///< among others
  std::string text() const;
};

/// Runs cases in a folder of its own; prints a line for each.
class DiagnosisStudy {
 public:
  /// \param binary  the program.
  DiagnosisStudy(std::filesystem::path folder, std::string binary);

  /// Asks for the cases of this part. \param draws  one function per case that makes its log.
  std::vector<StudyCase> ask(const std::vector<std::function<HiddenLog()>>& draws,
                             const std::vector<std::string>& keys);
  /// Whether the last `ask` left cases out that are another part's.
  bool partial() const { return partial_; }

 private:
  StudyCase run(const HiddenLog& log) const;
  double baselineError(const HiddenLog& log) const;

  std::filesystem::path folder_;
  std::string binary_;
  std::map<std::string, StudyCase> kept_;
  bool partial_ = false;
};

/// Upper end of the exact 95 % interval of a rate of k in n (Clopper & Pearson 1934), one-sided.
double upperLimit(int k, int n);

}  // namespace simgap::test
