#include "simgap/core/error.h"
#include "simgap/fit/poses/calibration.h"

namespace simgap {
namespace {

// An unknown fitness is null.
double number(const Json& json) {
  return json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
}

Json toJson(const Individual& individual) {
  return {{"y", individual.y}, {"s", individual.s}, {"fitness", numberOrNull(individual.fitness)}};
}

Individual individualFromJson(const Json& json) {
  return {json.at("y").get<std::vector<double>>(), json.at("s").get<std::vector<double>>(), number(json.at("fitness"))};
}

Json toJson(const GenerationRecord& r) {
  return {{"generation", r.generation},   {"best", r.best},           {"median", r.median},
          {"best_so_far", r.best_so_far}, {"sigma_min", r.sigma_min}, {"sigma_median", r.sigma_median},
          {"sigma_max", r.sigma_max},     {"invalid", r.invalid},     {"mje", r.mje}};
}

GenerationRecord recordFromJson(const Json& json) {
  GenerationRecord r;
  json.at("generation").get_to(r.generation);
  json.at("best").get_to(r.best);
  json.at("median").get_to(r.median);
  json.at("best_so_far").get_to(r.best_so_far);
  json.at("sigma_min").get_to(r.sigma_min);
  json.at("sigma_median").get_to(r.sigma_median);
  json.at("sigma_max").get_to(r.sigma_max);
  json.at("invalid").get_to(r.invalid);
  json.at("mje").get_to(r.mje);
  return r;
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
          {"best_mje", state.best_mje},
          {"invalid", state.invalid},
          {"evaluations", state.evaluations},
          {"wall_s", state.wall},
          {"history", history}};
}

CalibrationState calibrationStateFromJson(const Json& json) try {
  CalibrationState state;
  json.at("generation").get_to(state.strategy.generation);
  json.at("best_generation").get_to(state.strategy.best_generation);
  for (const StopReason reason : kStopReasons) {
    if (json.at("stop") == toString(reason)) state.strategy.stop = reason;
  }
  for (const Json& parent : json.at("parents")) state.strategy.parents.push_back(individualFromJson(parent));
  state.strategy.best = individualFromJson(json.at("best"));
  json.at("best_mje").get_to(state.best_mje);
  json.at("invalid").get_to(state.invalid);
  json.at("evaluations").get_to(state.evaluations);
  json.at("wall_s").get_to(state.wall);
  for (const Json& record : json.at("history")) state.history.push_back(recordFromJson(record));
  return state;
} catch (const Json::exception& error) {
  throw ConfigError(std::string("the stored state is not a simgap/calibration-state/1: ") + error.what());
}

}  // namespace simgap
