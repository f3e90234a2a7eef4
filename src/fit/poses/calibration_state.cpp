#include <limits>

#include "simgap/core/error.h"
#include "simgap/core/json_numbers.h"
#include "simgap/fit/poses/calibration.h"

namespace simgap {
namespace {

// An unknown fitness is null; the infinite objective of a descent without an equilibrium, too.
double number(const Json& json) {
  return json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
}

Json toJson(const Individual& individual) {
  return {{"y", individual.y}, {"s", individual.s}, {"fitness", numberOrNull(individual.fitness)}};
}

Individual individualFromJson(const Json& json) {
  return {json.at("y").get<std::vector<double>>(), json.at("s").get<std::vector<double>>(), number(json.at("fitness"))};
}

Json numbersOrNull(const std::vector<double>& values) {
  Json json = Json::array();
  for (const double value : values) json.push_back(numberOrNull(value));
  return json;
}

std::vector<double> numbers(const Json& json) {
  std::vector<double> values;
  for (const Json& value : json) values.push_back(number(value));
  return values;
}

Json toJson(const GenerationRecord& r) {
  return {{"generation", r.generation},       {"best", numberOrNull(r.best)},
          {"median", numberOrNull(r.median)}, {"best_so_far", numberOrNull(r.best_so_far)},
          {"sigma_min", r.sigma_min},         {"sigma_median", r.sigma_median},
          {"sigma_max", r.sigma_max},         {"invalid", r.invalid},
          {"mje", numbersOrNull(r.mje)}};
}

GenerationRecord recordFromJson(const Json& json) {
  GenerationRecord r;
  r.generation = static_cast<int>(wholeNumber(json.at("generation")));
  r.best = number(json.at("best"));
  r.median = number(json.at("median"));
  r.best_so_far = number(json.at("best_so_far"));
  json.at("sigma_min").get_to(r.sigma_min);
  json.at("sigma_median").get_to(r.sigma_median);
  json.at("sigma_max").get_to(r.sigma_max);
  r.invalid = static_cast<int>(wholeNumber(json.at("invalid")));
  r.mje = numbers(json.at("mje"));
  return r;
}

Json toJson(const Eigen::VectorXd& z) { return std::vector<double>(z.begin(), z.end()); }

Eigen::VectorXd vectorFromJson(const Json& json) {
  const std::vector<double> values = numbers(json);
  return Eigen::Map<const Eigen::VectorXd>(values.data(), std::ssize(values));
}

Json toJson(const SearchJournal& journal) {
  Json fits = Json::array();
  for (const PosteriorFit& fit : journal.fits) {
    fits.push_back({{"z", toJson(fit.z)},
                    {"objective", numberOrNull(fit.objective)},
                    {"iterations", fit.iterations},
                    {"evaluations", fit.evaluations}});
  }
  return {{"whitened_at", toJson(journal.whitened_at)}, {"fits", fits}};
}

SearchJournal journalFromJson(const Json& json) {
  SearchJournal journal{vectorFromJson(json.at("whitened_at")), {}};
  for (const Json& fit : json.at("fits")) {
    const Json& objective = fit.at("objective");
    journal.fits.push_back({vectorFromJson(fit.at("z")),
                            objective.is_null() ? std::numeric_limits<double>::infinity() : objective.get<double>(),
                            static_cast<int>(wholeNumber(fit.at("iterations"))), wholeNumber(fit.at("evaluations"))});
  }
  return journal;
}

constexpr StopReason kStopReasons[] = {StopReason::kNone, StopReason::kMaxGenerations, StopReason::kTargetFitness,
                                       StopReason::kNoValidIndividual, StopReason::kConverged};

}  // namespace

Json toJson(const CalibrationState& state) {
  Json parents = Json::array();
  for (const Individual& parent : state.strategy.parents) parents.push_back(toJson(parent));
  Json history = Json::array();
  for (const GenerationRecord& record : state.history) history.push_back(toJson(record));
  return {{"format", "simgap/calibration-state/1"},
          {"generation", state.strategy.generation},
          {"best_generation", state.strategy.best_generation},
          {"stop", toString(state.strategy.stop)},
          {"parents", parents},
          {"best", toJson(state.strategy.best)},
          {"best_mje", numbersOrNull(state.best_mje)},
          {"invalid", state.invalid},
          {"evaluations", state.evaluations},
          {"wall_s", state.wall},
          {"history", history},
          {"told", state.told},
          {"journal", toJson(state.journal)}};
}

CalibrationState calibrationStateFromJson(const Json& json) try {
  CalibrationState state;
  state.strategy.generation = static_cast<int>(wholeNumber(json.at("generation")));
  state.strategy.best_generation = static_cast<int>(wholeNumber(json.at("best_generation")));
  for (const StopReason reason : kStopReasons) {
    if (json.at("stop") == toString(reason)) state.strategy.stop = reason;
  }
  for (const Json& parent : json.at("parents")) state.strategy.parents.push_back(individualFromJson(parent));
  state.strategy.best = individualFromJson(json.at("best"));
  state.best_mje = numbers(json.at("best_mje"));
  state.invalid = wholeNumber(json.at("invalid"));
  state.evaluations = wholeNumber(json.at("evaluations"));
  json.at("wall_s").get_to(state.wall);
  for (const Json& record : json.at("history")) state.history.push_back(recordFromJson(record));
  json.at("told").get_to(state.told);
  state.journal = journalFromJson(json.at("journal"));
  return state;
} catch (const Json::exception& error) {
  throw ConfigError(std::string("the stored state is not a simgap/calibration-state/1: ") + error.what());
}

}  // namespace simgap
