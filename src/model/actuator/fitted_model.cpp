#include "simgap/model/actuator/fitted_model.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"

namespace simgap {
namespace {

const std::vector<std::string> kKinds = {"friction", "motor", "gearbox", "pam", "spring"};

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
  throw ConfigError(fmt::format("found no parameter {} in the {} model, expected it", name, kind));
}

std::string FittedModel::setting(const std::string& key, const std::string& otherwise) const {
  const auto found = settings.find(key);
  return found == settings.end() ? otherwise : found->second;
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
  for (const std::string& kind : kinds.empty() ? kKinds : kinds) formats.push_back("simgap/" + kind + "/1");
  const std::string format = root.at("format").oneOf(formats);
  model.kind = format.substr(7, format.size() - 9);
  if (const auto law = root.find("law")) model.law = law->text();
  const YamlNode parameters = root.at("parameters");
  for (const std::string& name : parameters.keys()) {
    const YamlNode node = parameters.at(name);
    Estimate p{name, node.at("unit").text(), node.at("value").number(), std::nan("")};
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
      const std::vector<double> row = numbers(rows[static_cast<std::size_t>(i)]);
      if (static_cast<Eigen::Index>(row.size()) != count) {
        rows[static_cast<std::size_t>(i)].fail(fmt::format("found {} numbers, expected {}", row.size(), count));
      }
      for (Eigen::Index j = 0; j < count; ++j) model.covariance(i, j) = row[static_cast<std::size_t>(j)];
    }
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
