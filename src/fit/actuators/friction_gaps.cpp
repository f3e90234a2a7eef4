#include "friction_gaps.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "friction_signs.h"
#include "simgap/measure/logs/actuator_rows.h"
#include "simgap/measure/logs/channel_checks.h"

namespace simgap {
namespace {

/// Whether the load has one sign in the direction of motion, but for single rows.
bool inOneQuadrant(const Eigen::ArrayXd& loads, const Eigen::ArrayXd& direction) {
  constexpr double kSingle = 0.01;  // of the rows
  const Eigen::ArrayXd along = loads * direction;
  const double against = static_cast<double>(std::min((along > 0.0).count(), (along < 0.0).count()));
  return against < kSingle * static_cast<double>(along.size());
}

}  // namespace

std::string missingForLaw(const FrictionModel& model, const FrictionData& data, bool predict_load) {
  const bool gain_fixed = model.parameters()[0].fixed;
  if (data.rows() <= model.freeCount()) {
    return fmt::format("found {} usable rows for {} parameters of {}, expected many more", data.rows(),
                       model.freeCount(), model.law().name);
  }
  const std::size_t efforts = differentValues(spanOf(data.effort), model.freeCount());
  if (!predict_load && efforts <= model.freeCount()) {
    return fmt::format("{} takes {} different values for {} parameters of {}: with as many any law meets it",
                       data.effort_name, efforts, model.freeCount(), model.law().name);
  }
  if (!data.hasLoad() && !gain_fixed) {
    return "the load is 0 throughout, so k_a cannot be found: record with loads, or fix it (--fix k_a=…)";
  }
  if (!data.hasLoad() && model.law().needsLoad()) {
    return fmt::format(
        "the load is 0 throughout, so the load-dependent friction of {} cannot be found: record with "
        "loads, or use --model coulomb or stribeck",
        model.law().name);
  }
  if (!model.loadScaleKnown()) {
    return fmt::format(
        "neither k_a nor {} is known, and only their ratio acts on this log: fix one of them (--fix "
        "k_a=…)",
        fmt::join(data.rig_names, ", "));
  }
  return {};
}

std::string degenerateFit(const FrictionModel& model, const FrictionData& data, std::span<const double> theta,
                          bool predict_load) {
  constexpr double kNothing = 1e-6;  // of what is predicted: a driving effort or load that has no part in it
  constexpr double kTakenUp = 0.05;  // likewise, where friction by the load can be all of it
  constexpr double kBeyond = 1e3;    // times the largest effort or load: a friction that no row shows
  const FrictionLaw& law = model.law();
  const Eigen::ArrayXd loads = data.totalLoad(theta.subspan(1 + law.terms.size(), data.rig_names.size()));
  const double load = loads.abs().maxCoeff();
  const double effort = data.effort.abs().maxCoeff();
  const double driving = predict_load ? effort : load, target = predict_load ? load : effort;
  const double gain = predict_load ? theta[0] : 1.0 / theta[0];
  const bool alike = law.needsLoad() && inOneQuadrant(loads, data.direction);
  const bool no_gain =
      !model.parameters()[0].fixed && driving > 0.0 && gain * driving < (alike ? kTakenUp : kNothing) * target;
  const auto terms = theta.subspan(1, law.terms.size());
  if (no_gain || std::ranges::all_of(terms, [](double value) { return value == 0.0; })) {
    if (std::string sentence = oppositeSign(data); !sentence.empty()) return sentence;
  }
  if (no_gain && alike) {
    return fmt::format(
        "motion goes one way against loads of one sign, where k_a and friction that grows with the load act alike: "
        "k_a cannot be found with {}; record both directions, fix it (--fix k_a=…), or use --model coulomb",
        law.name);
  }
  if (no_gain) {
    return fmt::format(
        "{} does not grow with the load, so k_a cannot be found: check both channels, or fix it (--fix "
        "k_a=…)",
        data.effort_name);
  }
  const double torque = predict_load ? target : theta[0] * target;
  for (std::size_t j = 0; j < law.terms.size(); ++j) {
    const bool per_load = law.terms[j].basis == FrictionBasis::kLoad;
    const bool constant = law.terms[j].basis == FrictionBasis::kDirection;
    if (model.parameters()[1 + j].fixed || !(per_load || constant)) continue;
    if (terms[j] * (per_load ? load : 1.0) < kBeyond * torque) continue;
    return fmt::format(
        "{} of {} has no bound on this log ({:.2g}): no row is slow enough to show it; record slow motion "
        "through rest, or bound it (--bounds {}=0:…)",
        law.terms[j].name, law.name, terms[j], law.terms[j].name);
  }
  return {};
}

std::vector<std::string> motionGaps(const FrictionModel& model, const FrictionData& data,
                                    std::span<const double> theta) {
  std::vector<std::string> sentences;
  const bool forward = (data.direction > 0.0).any(), backward = (data.direction < 0.0).any();
  if (!forward || !backward) {
    sentences.push_back(
        fmt::format("all motion is in one direction: friction cannot be told from {}; record both "
                    "directions",
                    data.hasLoad() ? "an offset or, under a load of one sign, from k_a" : "an offset"));
  }
  const double first = data.load[0];
  if (!model.parameters()[0].fixed && data.load_per.cols() == 0 && (data.load == first).all()) {
    sentences.push_back(
        fmt::format("the load is {:.3g} {} in every row: k_a stands on this one, and an offset of {} looks like it; "
                    "record several loads",
                    first, data.load_unit, data.effort_name));
  }
  if (!model.law().hasStribeck() || model.parameters()[model.speedIndex()].fixed) return sentences;
  const double v_s = theta[model.speedIndex()];
  const auto below = (data.velocity.abs() < v_s).count();
  const auto above = (data.velocity.abs() > v_s).count();
  if (below < 20) {
    sentences.push_back(
        fmt::format("only {} rows are slower than v_s = {:.3g} {}: v_s, delta and static friction are "
                    "not determined; record slow motion through rest",
                    below, v_s, data.velocity_unit));
  } else if (above < 20) {
    sentences.push_back(
        fmt::format("only {} rows are faster than v_s = {:.3g} {}: v_s, delta and Coulomb friction are "
                    "not determined; record faster motion, or use a law without Stribeck term",
                    above, v_s, data.velocity_unit));
  }
  return sentences;
}

}  // namespace simgap
