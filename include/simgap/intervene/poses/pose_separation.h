/// \file
/// Which poses to record next so that the models of a diagnosis fall apart. For the named model and each that
/// contradicts it, either of them right, a pose more is expected to change the log odds by
///
///     v^T S^-1 v / 2,   S = 1 + J C J^T,   v = d - J x
///
/// (Buzzi-Ferraris & Forzatti 1983; the divergence of two normal predictions): d: the whitened distance of the two
/// predictions, C, J: what is left open of the wrong model's parameters and what they move; x: by how much the poses
/// chosen before have already turned them towards the right one. Poses are chosen one after the other so that the sum
/// of exp(-log odds) over all pairs falls most: the pair that is told apart worst counts most.
///
/// That chooses; it does not promise. The chosen poses are bent further than derivatives reach, and a wrong model is
/// weighed with all that it can still become. So what they are expected to tell is played: the right model's
/// parameters, friction and noise are drawn, the poses simulated, and judged as recorded ones would be
/// (pose_intervention.h).
#pragma once

#include <cstdint>
#include <vector>

#include "simgap/intervene/poses/pose_intervention.h"

namespace simgap {

struct SeparationOptions {
  std::size_t candidates = 300;  ///< commands to choose from
  std::size_t poses = 7;         ///< to choose
  std::uint64_t seed = 1;
  double most_tension = kInfinity;  ///< [N] of a muscle, as the named model expects it
};

/// What the chosen poses are expected to say of one pair of models.
struct SeparatedPair {
  std::size_t right = 0, wrong = 0;  ///< places in PoseEvidence::candidates
  double log_odds = 0.0;             ///< of the right over the wrong one, from all chosen poses: median of the draws
};

struct PoseSeparation {
  std::vector<Pose> poses;              ///< commands in their order, with the named model's equilibria as joints
  std::vector<SeparatedPair> pairs;     ///< the named one against each rival, and each rival against it
  double promised = 0.0;                ///< the smallest of the pairs' log odds
  double promised_random = 0.0;         ///< the same of as many random commands
  std::vector<double> smallest;         ///< shape (poses): by derivatives, after 1, 2 … poses
  std::vector<double> smallest_random;  ///< the same of random commands: the mean of several draws
};

/// Commands within the recorded ranges of the shafts that every candidate can take, and none stretches a cord of the
/// named model beyond its linear range. \throws ConfigError: no candidate contradicts the named one.
/// NumericsError: too few commands lead to an equilibrium, or none of the draws' poses.
PoseSeparation separatePoses(const PoseEvidence& evidence, const SeparationOptions& options);

}  // namespace simgap
