#include "simgap/fit/actuators/pam_comparison.h"

#include <algorithm>

namespace simgap {
namespace {

std::vector<Block> blocksOfMuscle(const PamLog& log, const std::optional<double>& block_s) {
  if (log.time.empty()) return splitRows(log.session, std::max<std::size_t>(1, log.rows() / 50));
  return splitBlocks(log.time, log.session, blockSeconds(block_s, log.time.back() - log.time.front()));
}

}  // namespace

PamComparison comparePam(const PamLog& log, const PamFitOptions& options, const std::optional<PamFit>& maker,
                         const Holdout& holdout, const std::optional<double>& block_s) {
  const JudgedRows rows = judgedRows(holdout, blocksOfMuscle(log, block_s));
  // The paper's two stages: a, b, c of the maker's curves, k from the rig.
  PamFitOptions plain = options;
  plain.spring = false;
  if (maker) {
    for (std::size_t i = 0; i < 3; ++i) plain.fixed.try_emplace(std::string(1, "abc"[i]), maker->theta[i]);
  }
  PamFitOptions spring = plain;
  spring.spring = !plain.fixed.contains("k");

  const auto candidate = [&](const std::string& name, const PamFitOptions& of) {
    return fitCandidate(
        name, rows, [&](const std::vector<bool>& some) { return fitPam(log, of, some); },
        [&](const PamFit& fit, const std::vector<bool>& some) { return meanSquaredError(fit, log, some); });
  };
  PamComparison comparison;
  comparison.heldout = rows.words;
  std::vector<PamCandidate>& candidates = comparison.candidates;
  if (spring.spring) candidates.push_back(candidate("no-spring", plain));
  candidates.push_back(candidate("spring", spring));
  const bool stiff = std::ranges::any_of(candidates.back().fit.uncertainty.estimates,
                                         [](const Estimate& e) { return e.name == "k" && e.at_bound; });
  comparison.choose(stiff ? "a spring as stiff as it may be is none" : "");
  return comparison;
}

}  // namespace simgap
