#include "simgap/model/effects/extension.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"

namespace simgap {

double Extension::value(std::string_view name) const {
  const auto found = std::ranges::find(parameters, name, &Estimate::name);
  if (found != parameters.end()) return found->value;
  throw ConfigError(fmt::format("found no parameter {} in the extension {}, expected it", name, effect));
}

std::string effectLabel(std::string_view effect, std::string_view target) {
  return target.empty() ? std::string(effect) : fmt::format("{}:{}", effect, target);
}

std::vector<Extension> readExtensions(const YamlNode& list) {
  std::vector<Extension> extensions;
  for (const YamlNode& entry : list.items()) {
    Extension& extension = extensions.emplace_back();
    extension.effect = entry.at("effect").text();
    if (const auto form = entry.find("form")) extension.form = form->text();
    if (const auto target = entry.find("target")) extension.target = target->text();
    const YamlNode parameters = entry.at("parameters");
    for (const std::string& name : parameters.keys()) {
      const YamlNode node = parameters.at(name);
      const auto sd = node.find("sd");
      extension.parameters.push_back(
          {name, node.at("unit").text(), node.at("value").number(), sd ? sd->number(kNonNegative) : std::nan("")});
    }
  }
  return extensions;
}

std::string writeExtensions(const std::vector<Extension>& extensions) {
  if (extensions.empty()) return "extensions: []\n";
  std::string text = "extensions:\n";
  for (const Extension& extension : extensions) {
    text += fmt::format("  - effect: {}\n", extension.effect);
    if (!extension.form.empty()) text += fmt::format("    form: {}\n", extension.form);
    if (!extension.target.empty()) text += fmt::format("    target: {}\n", yamlText(extension.target));
    text += extension.parameters.empty() ? "    parameters: {}\n" : "    parameters:\n";
    for (const Estimate& p : extension.parameters) {
      text += fmt::format("      {}: {{value: {}, unit: \"{}\"", p.name, p.value, p.unit);
      text += std::isfinite(p.sd) ? fmt::format(", sd: {}}}\n", p.sd) : "}\n";
    }
  }
  return text;
}

}  // namespace simgap
