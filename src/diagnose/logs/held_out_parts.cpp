#include "held_out_parts.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <string_view>
#include <utility>

namespace simgap {
namespace {

/// Most causes explain nothing, not even of the rows that they were fitted to.
std::vector<Hypothesis> promisingOf(const std::vector<Hypothesis>& named, const std::vector<HypothesisRecord>& records,
                                    const LogDiagnosisOptions& options) {
  constexpr double kSomething = 0.5;  // of the least gain
  std::vector<Hypothesis> promising;
  for (const Hypothesis& h : named) {
    const auto explained = [&](const HypothesisRecord& record) {
      return record.effect == titleOf(*h.effect) && record.gain_inner.value >= kSomething * options.least_gain;
    };
    if (std::ranges::any_of(records, explained)) promising.push_back(h);
  }
  return promising;
}

}  // namespace

HeldOutParts::HeldOutParts(const LogSearch& search, std::vector<Block> heldout, std::size_t own)
    : search_(search), heldout_(std::move(heldout)), own_(own), blocks_(heldout_) {}

void HeldOutParts::addOthers(const PreparedLog& log, const ActuatorModel& subject, const std::vector<Hypothesis>& named,
                             const std::vector<HypothesisRecord>& records, const LogDiagnosisOptions& options,
                             const DiagnosisProgress& progress) {
  const std::vector<Hypothesis> promising = promisingOf(named, records, options);
  const std::vector<LogSplit> splits = otherSplits(log, options);
  for (std::size_t s = 0; s < splits.size(); ++s) {
    const DiagnosisProgress part = partOfProgress(progress, kMainShare * (1.0 + static_cast<double>(s)), kMainShare);
    auto search = std::make_unique<LogSearch>(subject.base, log.data, splits[s].training, options);
    Selection selection = selectCauses(*search, subject.effects, promising, {}, options, part);
    blocks_.insert(blocks_.end(), splits[s].heldout.begin(), splits[s].heldout.end());
    others_.push_back({std::move(search), splits[s].heldout, std::move(selection.baseline), std::move(selection.chosen),
                       std::move(selection.ambiguous_with)});
  }
  std::ranges::sort(blocks_, {}, &Block::begin);
}

/// Which of the causes chosen here is the main selection's: the same, or one that either cannot tell from it.
std::optional<std::size_t> HeldOutParts::sameCause(const Choice& here, const Selection& main, std::size_t cause,
                                                   const std::vector<std::size_t>& taken) const {
  const std::string_view name = main.chosen.model->effects()[own_ + cause]->name;
  const auto contains = [](const std::vector<std::string>& names, std::string_view one) {
    return std::ranges::find(names, one) != names.end();
  };
  std::optional<std::size_t> rival;
  for (std::size_t k = 0; k < here.ambiguous_with.size(); ++k) {
    if (std::ranges::find(taken, k) != taken.end()) continue;
    const std::string_view other = here.chosen.model->effects()[own_ + k]->name;
    if (other == name) return k;
    const bool same = contains(here.ambiguous_with[k], name) || contains(main.ambiguous_with[cause], other);
    if (same && !rival) rival = k;
  }
  return rival;
}

void HeldOutParts::take(const Selection& main) {
  const std::size_t causes = main.steps.size() - 1;
  parts_.assign(1 + others_.size(), {});
  parts_.front() = {&search_, heldout_, main.baseline, main.chosen, main.steps, std::vector<Fitted>(causes)};
  tbb::parallel_for(std::size_t{0}, causes + others_.size(), [&](std::size_t i) {
    if (i < causes) {
      parts_.front().without[i] = search_.without(main.chosen, own_ + i);
    } else {
      parts_[1 + i - causes] = partOf(others_[i - causes], main);
    }
  });
}

HeldOutPart HeldOutParts::partOf(const Choice& here, const Selection& main) const {
  HeldOutPart part{here.search.get(), here.heldout, here.baseline, here.baseline, {here.baseline}, {}};
  const auto& all = here.chosen.model->effects();
  std::vector<const ActuatorEffect*> effects(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(own_));
  std::vector<std::size_t> taken;              // of the causes chosen here
  std::vector<std::optional<std::size_t>> at;  // of the main causes in this part's model
  for (std::size_t k = 0; k + 1 < main.steps.size(); ++k) {
    const auto chosen = sameCause(here, main, k, taken);
    at.push_back(chosen ? std::optional(effects.size()) : std::nullopt);
    if (chosen) {
      taken.push_back(*chosen);
      effects.push_back(all[own_ + *chosen]);
      part.chosen = here.search->fit(effects, &here.chosen);
    }
    part.steps.push_back(part.chosen);
  }
  for (const auto& effect : at)
    part.without.push_back(effect ? here.search->without(part.chosen, *effect) : part.chosen);
  return part;
}

std::vector<Eigen::VectorXd> HeldOutParts::residuals(
    const std::function<std::vector<Fitted>(const HeldOutPart&)>& models_of) const {
  std::vector<std::vector<Eigen::VectorXd>> own(parts_.size());
  tbb::parallel_for(std::size_t{0}, parts_.size(), [&](std::size_t p) {
    const HeldOutPart& part = parts_[p];
    own[p] = heldOutResiduals(*part.search, models_of(part), part.heldout, search_.data().rows.session);
  });
  std::vector<Eigen::VectorXd> all = std::move(own.front());
  for (std::size_t p = 1; p < own.size(); ++p) {
    for (std::size_t m = 0; m < all.size(); ++m) all[m] += own[p][m];
  }
  return all;
}

}  // namespace simgap
