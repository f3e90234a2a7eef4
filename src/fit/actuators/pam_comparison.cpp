#include "simgap/fit/actuators/pam_comparison.h"

#include <algorithm>

namespace simgap {
namespace {

std::vector<Block> blocksOfMuscle(const PamLog& log, const std::optional<double>& block_s) {
  if (log.time.empty()) return splitRows(log.session, std::max<std::size_t>(1, log.rows() / 50));
  return splitBlocks(log.time, log.session, blockSeconds(block_s, log.time.back() - log.time.front()));
}

PamCandidate fitCandidate(const std::string& name, const PamLog& log, const PamFitOptions& options,
                          const std::vector<bool>& kept, bool final_on_all) {
  PamCandidate candidate{name, fitPam(log, options, kept), std::nullopt};
  if (std::ranges::count(kept, false) > 0) {
    std::vector<bool> held = kept;
    held.flip();
    candidate.mse_heldout = meanSquaredError(candidate.fit, log, held);
    if (final_on_all) candidate.fit = fitPam(log, options);
  }
  return candidate;
}

}  // namespace

PamComparison comparePam(const PamLog& log, const PamFitOptions& options, const std::optional<PamFit>& maker,
                         const Holdout& holdout, const std::optional<double>& block_s) {
  constexpr std::size_t kFewestBlocks = 5;  // one of them is a fifth
  // Which rows the fits see.
  Holdout judged_by = holdout;
  if (!holdout.any()) judged_by = {0.2, {}, "20 % of the blocks, before the final fit to all rows"};
  const std::vector<Block> blocks = blocksOfMuscle(log, block_s);
  std::vector<bool> kept(log.rows(), true);
  if (blocks.size() >= kFewestBlocks || holdout.any()) {
    kept = heldOutRows(judged_by, blocks);
    kept.flip();
  }
  // The paper's two stages: a, b, c of the maker's curves, k from the rig.
  PamFitOptions plain = options;
  plain.spring = false;
  if (maker) {
    for (std::size_t i = 0; i < 3; ++i) plain.fixed.try_emplace(std::string(1, "abc"[i]), maker->theta[i]);
  }
  PamFitOptions spring = plain;
  spring.spring = !plain.fixed.contains("k");

  PamComparison comparison;
  comparison.heldout = judged_by.words;
  std::vector<PamCandidate>& candidates = comparison.candidates;
  if (spring.spring) candidates.push_back(fitCandidate("no-spring", log, plain, kept, !holdout.any()));
  candidates.push_back(fitCandidate("spring", log, spring, kept, !holdout.any()));
  comparison.best = candidates.size() - 1;
  const auto judge = [](const PamCandidate& c) { return c.mse_heldout.value_or(c.fit.mse); };
  if (judge(candidates.front()) < judge(candidates.back())) comparison.best = 0;
  return comparison;
}

}  // namespace simgap
