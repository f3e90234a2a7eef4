/// \file
/// What is left after a model, against all that was logged: binned means for people, and a flexible model that bounds
/// what any function of the channels could still explain.
#pragma once

#include <vector>

#include "simgap/diagnose/logs/log_diagnosis.h"

namespace simgap {

/// A channel by which residuals are looked at, shape (rows).
struct EvidenceChannel {
  std::string name;
  Eigen::ArrayXd values;
  std::string unit;  ///< where the name does not say it
};

/// Motion, load, context channels, quadrant of the power flow, time since reversal, session.
std::vector<EvidenceChannel> evidenceChannels(const PreparedLog& log);

/// Mean residual in bins of equal counts. \param before, after  shape (rows), 0 where a row does not count. \param
/// correlation  [rows] of `after`
std::vector<EvidenceBin> binEvidence(const PreparedLog& log, const std::vector<EvidenceChannel>& channels,
                                     const Eigen::VectorXd& before, const Eigen::VectorXd& after, double correlation);

/// What random forests (Breiman 2001) of all channels predict of a residual in blocks they have not seen.
struct Ceiling {
  double share = 0.0;              ///< of the residual's mean square; 0 when nothing
  std::vector<Leftover> channels;  ///< how much of it is lost when a channel is shuffled, largest first
};
Ceiling explainable(const PreparedLog& log, const std::vector<EvidenceChannel>& channels,
                    const Eigen::VectorXd& residual, std::uint64_t seed);

}  // namespace simgap
