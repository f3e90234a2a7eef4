#include "simgap/model/actuator/fitted_model.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/measure/logs/log_kind.h"

namespace simgap {
namespace {

/// Those that a log of its own is fitted to.
std::vector<std::string> allKinds() {
  std::vector<std::string> names;
  for (const LogKind* kind : log_kinds::all()) {
    if (kind->prepare != nullptr) names.emplace_back(kind->name);
  }
  return names;
}

constexpr Range kPlausible{-1e15, 1e15, false, "a number of a size of at most 1e15"};  // in whatever unit

/// What no estimate can have: a variance below 0, a correlation beyond 1.
void refuseNoCovariance(const YamlNode& node, const Eigen::MatrixXd& covariance) {
  constexpr double kRounding = 1.01;
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    if (covariance(i, i) < 0.0)
      node.fail(fmt::format("found the variance {:g}, expected none below 0", covariance(i, i)));
  }
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    for (Eigen::Index j = 0; j < covariance.cols(); ++j) {
      const double most = kRounding * std::sqrt(covariance(i, i)) * std::sqrt(covariance(j, j));
      if (std::abs(covariance(i, j)) <= most) continue;
      node.fail(fmt::format("found {:g} in row {}, column {}, expected at most {:g}, or the correlation is beyond 1",
                            covariance(i, j), i + 1, j + 1, most));
    }
  }
}

std::vector<double> numbers(const YamlNode& list) {
  std::vector<double> values;
  for (const YamlNode& item : list.items()) values.push_back(item.number());
  return values;
}

}  // namespace

bool FittedModel::has(std::string_view name) const {
  return std::ranges::find(parameters, name, &Estimate::name) != parameters.end();
}

double FittedModel::value(std::string_view name) const {
  const auto found = std::ranges::find(parameters, name, &Estimate::name);
  if (found != parameters.end()) return found->value;
  throw ConfigError(
      fmt::format("{}found no parameter {} in the {} model, expected it: a fit leaves out what its log does "
                  "not tell",
                  file.empty() ? "" : file + ": ", name, kind));
}

std::string FittedModel::setting(const std::string& key, const std::string& otherwise) const {
  const auto found = settings.find(key);
  return found == settings.end() ? otherwise : found->second;
}

FittedModel fittedModel(const std::string& kind, const std::string& law, const Uncertainty& uncertainty) {
  FittedModel model;
  model.kind = kind;
  model.law = law;
  std::vector<Eigen::Index> known;  // what could not be found is left out
  for (std::size_t i = 0; i < uncertainty.estimates.size(); ++i) {
    const Estimate& e = uncertainty.estimates[i];
    if (!std::isfinite(e.value)) continue;
    model.parameters.push_back(e);
    known.push_back(static_cast<Eigen::Index>(i));
  }
  model.covariance = uncertainty.covariance(known, known);
  return model;
}

std::string writeFittedModel(const FittedModel& model) {
  std::string text = fmt::format("format: simgap/{}/1\n", model.kind);
  if (!model.law.empty()) text += fmt::format("law: {}\n", yamlText(model.law));
  text += "parameters:\n";
  for (const Estimate& p : model.parameters) {
    text += fmt::format("  {}: {{value: {}, unit: \"{}\"", p.name, p.value, p.unit);
    if (std::isfinite(p.sd) && !p.fixed) text += fmt::format(", sd: {}", p.sd);
    text += p.fixed ? ", fixed: true}\n" : "}\n";
  }
  if (model.covariance.size() > 0) {
    text += "covariance:  # in the order of the parameters\n";
    for (Eigen::Index i = 0; i < model.covariance.rows(); ++i) {
      const Eigen::VectorXd row = model.covariance.row(i);
      text += fmt::format("  - [{}]\n", fmt::join(row.data(), row.data() + row.size(), ", "));
    }
  }
  if (!model.settings.empty()) text += "settings:\n";
  for (const auto& [key, value] : model.settings) text += fmt::format("  {}: {}\n", key, yamlText(value));
  text += fmt::format("data: {{file: {}, sha256: \"{}\", rows: {}}}\n", yamlText(model.data_file), model.data_sha256,
                      model.data_rows);
  return text + writeExtensions(model.extensions);
}

FittedModel readFittedModel(const YamlNode& root, const std::vector<std::string>& kinds) {
  FittedModel model;
  std::vector<std::string> formats;
  for (const std::string& kind : kinds.empty() ? allKinds() : kinds) formats.push_back("simgap/" + kind + "/1");
  const std::string format = root.at("format").oneOf(formats);
  model.kind = format.substr(7, format.size() - 9);
  if (const auto law = root.find("law")) model.law = law->text();
  const YamlNode parameters = root.at("parameters");
  for (const std::string& name : parameters.keys()) {
    const YamlNode node = parameters.at(name);
    Estimate p{name, node.at("unit").text(), node.at("value").number(kPlausible), std::nan("")};
    if (const auto fixed = node.find("fixed")) p.fixed = fixed->boolean();
    if (const auto sd = node.find("sd")) p.sd = sd->number(kNonNegative);
    model.parameters.push_back(p);
  }
  if (const auto covariance = root.find("covariance")) {
    const auto count = static_cast<Eigen::Index>(model.parameters.size());
    model.covariance.resize(count, count);
    const std::vector<YamlNode> rows = covariance->items();
    if (static_cast<Eigen::Index>(rows.size()) != count)
      covariance->fail(fmt::format("found {} rows, expected {}", rows.size(), count));
    for (Eigen::Index i = 0; i < count; ++i) {
      const std::vector<double> row = numbers(rows[i]);
      if (static_cast<Eigen::Index>(row.size()) != count) {
        rows[i].fail(fmt::format("found {} numbers, expected {}", row.size(), count));
      }
      for (Eigen::Index j = 0; j < count; ++j) model.covariance(i, j) = row[j];
    }
    refuseNoCovariance(*covariance, model.covariance);
  }
  if (const auto settings = root.find("settings")) {
    for (const std::string& key : settings->keys()) model.settings[key] = settings->at(key).text();
  }
  if (const auto data = root.find("data")) {
    model.data_file = data->at("file").text();
    model.data_sha256 = data->at("sha256").text();
    model.data_rows = static_cast<std::size_t>(data->at("rows").integer(0, std::numeric_limits<long>::max()));
  }
  if (const auto extensions = root.find("extensions")) model.extensions = readExtensions(*extensions);
  root.expectAllRead();
  return model;
}

}  // namespace simgap
