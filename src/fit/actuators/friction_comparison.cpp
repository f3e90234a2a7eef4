#include "simgap/fit/actuators/friction_comparison.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <optional>

#include "simgap/core/error.h"

namespace simgap {
namespace {

/// All laws at once: each has stretches of its own that only one thread can do.
std::vector<FrictionFit> fitLaws(std::span<const FrictionLaw* const> laws, const FrictionData& data,
                                 const FrictionFitOptions& options, std::vector<std::string>& left_out) {
  std::vector<std::optional<FrictionFit>> found(laws.size());
  std::vector<std::optional<Error>> reasons(laws.size());
  tbb::parallel_for(std::size_t{0}, laws.size(), [&](std::size_t k) {
    try {
      found[k] = fitFriction(*laws[k], data, options);
    } catch (const DataError& error) {
      reasons[k] = error;
    } catch (const NumericsError& error) {
      reasons[k] = error;
    }
  });
  std::vector<FrictionFit> fits;
  for (std::size_t k = 0; k < laws.size(); ++k) {
    if (found[k]) fits.push_back(std::move(*found[k]));
    if (reasons[k]) left_out.push_back(fmt::format("{} was left out: {}", laws[k]->name, reasons[k]->what()));
  }
  if (fits.empty()) throw Error(*reasons.back());
  return fits;
}

}  // namespace

std::vector<const FrictionLaw*> lawsNamed(std::span<const std::string> names) {
  std::vector<const FrictionLaw*> laws;
  const auto add = [&](const FrictionLaw* law) {
    if (std::ranges::find(laws, law) == laws.end()) laws.push_back(law);
  };
  for (const std::string& name : names) {
    if (name == "all") {
      for (const char* of_paper : {"classic", "variant-a", "variant-b"}) add(&friction::find(of_paper));
    } else if (name == "every") {
      for (const FrictionLaw* law : friction::all()) add(law);
    } else {
      add(&friction::find(name));
    }
  }
  return laws;
}

std::vector<std::string> parameterNames(std::span<const FrictionLaw* const> laws, const FrictionData& data,
                                        const FrictionFitOptions& options) {
  std::vector<std::string> names;
  for (const FrictionLaw* law : laws) {
    for (const ParameterSpec& p : makeFrictionProblem(*law, data, options).parameters) names.push_back(p.name);
  }
  return names;
}

FrictionComparison compareLaws(std::span<const FrictionLaw* const> laws, const FrictionData& data,
                               const FrictionFitOptions& options, const FrictionData* test, const std::string& words) {
  FrictionComparison comparison;
  std::vector<FrictionFit>& fits = comparison.fits;
  fits = fitLaws(laws, data, options, comparison.left_out);
  if (test != nullptr) {
    for (FrictionFit& fit : fits) fit.mse_heldout = meanSquaredError(fit, *test, options);
    comparison.heldout = words;
  } else if (fits.front().mse_heldout) {
    comparison.heldout =
        fmt::format("{}-fold cross-validation over blocks of {}", std::min<std::size_t>(5, data.blocks.size()),
                    data.timed ? fmt::format("{:.3g} s", data.block_seconds)
                               : fmt::format("{} rows", data.blocks.empty() ? 0 : data.blocks.front().size()));
  }
  comparison.best = compareFits(fits);
  return comparison;
}

}  // namespace simgap
