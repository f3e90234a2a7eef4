/// \file
/// What `diagnose` answers (docs/formats.md), for logs and pose sets alike.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "simgap/model/effects/extension.h"

namespace simgap {

enum class DiagnosisVerdict {
  kCauseFound,    ///< named causes, each told apart from its look-alikes
  kAmbiguous,     ///< the first cause stands for a group that these data cannot separate
  kUnexplained,   ///< nothing was found, and structure is left that no cause of the catalogue explains
  kNothingFound,  ///< no cause improves the model on data it has not seen
  kDataFault,     ///< the data are wrong before any physics
};
std::string_view toString(DiagnosisVerdict verdict);

/// A value with its 95 % interval.
struct Interval {
  double value = 0.0;
  double lower95 = 0.0;
  double upper95 = 0.0;
};

/// An ordinary parameter of the model that had been carrying a cause.
struct Absorption {
  std::string parameter;
  double shift_sd;  ///< (after - before) / sd after
};

struct Cause {
  std::string effect;
  std::string form;      ///< "linear": by which of several laws of the cause; empty when it has one
  std::string target;    ///< which muscle, body or joint; empty otherwise
  std::string channel;   ///< the channel it depends on, or that is shifted; empty otherwise
  std::string sentence;  ///< the physical cause in words
  std::vector<Estimate> parameters;
  Interval gain_heldout;  ///< fraction of the held-out mean squared error; 0.1: 10 %
  double p_adjusted = 1.0;
  std::vector<std::string> ambiguous_with;  ///< "effect" or "effect:target"
  std::vector<Absorption> absorbed_by;      ///< largest shift first
};

/// A cause that a search accepted, but that is no finding.
struct Candidate {
  std::string effect, target;
  std::string reason;     ///< why not, continues "not named: "
  Interval gain_heldout;  ///< fraction of the held-out mean squared error
};

/// One hypothesis of one forward step, for hypotheses.csv.
struct HypothesisRecord {
  std::size_t step;  ///< counted from 1
  std::string effect, target;
  Interval gain_inner;  ///< fraction of the error on the inner validation blocks; kNotMeasured where none was needed
  double p_adjusted;
  std::string outcome;                  ///< "accepted", "ambiguous", "rejected: …", "pruned"
  std::optional<double> log_odds = {};  ///< against the model without it, where that decides (poses)
};
inline constexpr Interval kNotMeasured{std::numeric_limits<double>::quiet_NaN(),
                                       std::numeric_limits<double>::quiet_NaN(),
                                       std::numeric_limits<double>::quiet_NaN()};

/// The smallest magnitude of an effect that these data could have revealed.
struct Detectable {
  std::string effect, target;
  std::string parameter, unit;
  double magnitude95;
};

struct NotTestable {
  std::string effect;
  std::string reason;  ///< "needs temperature_degC"
};

struct DataFault {
  std::string channel;                      ///< a column, or "pose"
  std::string sentence;                     ///< what is wrong, with rows or poses, and what to do
  std::size_t first_row = 0, last_row = 0;  ///< of the file, counted from 1 after the header; 0: the whole channel
  std::size_t rows = 0;                     ///< how many
  bool corrected = false;                   ///< put right and said so: no reason to stop
};

/// Mean residual in a bin of a channel, before and after the causes, for evidence.csv and the plots.
struct EvidenceBin {
  std::string against;  ///< "temperature_degC", "joint shoulder", "pose order" …; "QUANTITY against CHANNEL" where it
                        ///< is not the plain residual
  double center;
  double before, before_ci95;  ///< mean residual and half width of its interval
  double after, after_ci95;
  std::size_t rows;
  std::string unit = {};  ///< of the channel, where its name does not say it
};

/// Explainable structure left over, by channel.
struct Leftover {
  std::string channel;
  double share;       ///< of the baseline's held-out error that a function of the channel still explains
  std::string shape;  ///< "rises with it", "falls with it", "bends"; empty when it has no plain one
};

struct ModelError {
  double mse = 0.0;  ///< on the rows (poses) that were fitted
  double mse_heldout = 0.0;
};

/// What the self-test measured on this design: hidden effect (row) against answer (column).
struct SelfTest {
  std::vector<std::string> hidden;      ///< shape (R): "none" first
  std::vector<std::string> answers;     ///< shape (A)
  std::vector<std::vector<int>> count;  ///< shape (R, A)
  double false_alarm_rate = 0.0, power = 0.0;
};

struct Diagnosis {
  DiagnosisVerdict verdict = DiagnosisVerdict::kNothingFound;
  std::string sentence;     ///< the answer in one sentence
  std::string error_unit;   ///< of the squared errors: "A2", "deg2" …
  std::size_t samples = 0;  ///< rows or poses
  double effective_samples = 0.0;
  double noise_floor = 0.0;  ///< mean squared error that no model can go below
  ModelError baseline, extended;
  std::vector<Cause> causes;          ///< in the order they were found
  double explainable_percent = 0.0;   ///< of it, by any function of logged channels; of poses, motions: beyond noise
  double explained_percent = 0.0;     ///< of the baseline's held-out error, by the named causes
  double left_over_percent = 0.0;     ///< of the baseline's held-out error: structure that no named cause explains
  std::vector<Leftover> unexplained;  ///< by channel; the shares add up to it
  std::vector<Candidate> candidates;  ///< below the line: what may be, and why it is not named
  std::vector<HypothesisRecord> hypotheses;
  std::vector<Detectable> detectable;
  std::vector<NotTestable> not_testable;
  std::vector<DataFault> faults;
  std::vector<EvidenceBin> evidence;
  std::string next_experiment;
  std::vector<std::string> warnings;
  std::optional<SelfTest> self_test;
  std::vector<Extension> extensions;  ///< of the causes, as the extended model holds them
};

/// What every diagnosis is asked with.
struct DiagnosisOptions {
  std::vector<std::string> effects;  ///< only these causes; empty: all
  double level = 0.05;               ///< of the false-alarm rate of each step
  bool ignore_faults = false;        ///< go on without the data that are faulty
  std::uint64_t seed = 1;

  bool wants(std::string_view effect) const {
    return effects.empty() || std::ranges::find(effects, effect) != effects.end();
  }
};

/// Called with what is being done and the share of the whole that is done.
using DiagnosisProgress = std::function<void(const std::string& what, double done)>;

/// Tells of a part of a whole: what is done of it counts as that share, behind `begin`. \param whole  outlives it
inline DiagnosisProgress partOfProgress(const DiagnosisProgress& whole, double begin, double share) {
  return [&whole, begin, share](const std::string& what, double done) {
    if (whole) whole(what, begin + share * done);
  };
}

/// Adds a warning for each cause that makes the data it was not chosen on worse.
void warnOfHarm(Diagnosis& diagnosis);

}  // namespace simgap
