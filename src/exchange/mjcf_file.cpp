#include "mjcf_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "mjcf_defaults.h"
#include "mjcf_keywords.h"
#include "simgap/core/error.h"
#include "simgap/core/text.h"

namespace simgap {
namespace {

constexpr std::size_t kMostIncludes = 200;

/// What changes neither where a robot rests nor how it moves here, by element or "@attribute".
const std::map<std::string, std::string> kIgnoredInMjcf = [] {
  std::map<std::string, std::string> reasons;
  const auto add = [&](const std::string& reason, const std::vector<std::string>& names) {
    for (const std::string& name : names) reasons[name] = reason;
  };
  add("looks: left out", {"visual", "statistic", "light", "camera", "asset", "skin", "@rgba", "@material", "@group",
                          "@markrgb", "@width"});
  add("the user's own data: left out", {"custom", "@user", "size"});
  add("sensors and stored states: left out", {"sensor", "keyframe"});
  add("contacts are not modelled: left out",
      {"contact", "@contype", "@conaffinity", "@condim", "@friction", "@margin", "@gap", "@solmix", "@priority"});
  add("no air and no liquid acts on bodies: left out", {"@fluidshape", "@fluidcoef"});
  add("how far MuJoCo's contacts and couplings give way: left out, couplings hold exactly here",
      {"@solref", "@solimp"});
  add("how MuJoCo solves, not what: left out",
      {"@solreflimit", "@solimplimit", "@solreffriction", "@solimpfriction", "@sleep", "lengthrange", "@lengthrange",
       "@meshdir", "@texturedir", "@assetdir", "@strippath", "@usethread", "@fusestatic", "@discardvisual",
       "@convexhull", "@alignfree", "@saveinertial", "@inertiagrouprange"});
  return reasons;
}();

}  // namespace

MjcfFile::MjcfFile(const std::string& text, const std::filesystem::path& file, FileReader read)
    : file_(file), read_(std::move(read)), root_(&xml_.parse(text, file, {"mujoco"})) {
  classes_["main"];
  readCompiler();
  for (const XmlElement* section : childElements(*root_)) {
    if (std::string(section->Name()) == "default") readDefaults(*section, "main", "");
  }
}

std::string MjcfFile::includedText(const XmlElement& include, const std::filesystem::path& file) const {
  try {
    return read_(file);
  } catch (const Error& error) {
    xml_.fail(include, fmt::format("file: {}", error.what()));
  }
}

const XmlElement& MjcfFile::includedRoot(const XmlElement& include) {
  const auto known = included_.find(&include);
  if (known != included_.end()) return *known->second;
  const char* const name = xml_.find(include, "file");
  xml_.understand(include);
  if (name == nullptr) xml_.fail(include, "found no file, expected one");
  const std::filesystem::path wanted(name);
  if (wanted.is_absolute()) {
    xml_.fail(include, fmt::format("file: found '{}', expected a way from the main file's folder", abridged(name)));
  }
  // As in MuJoCo, from the main file's folder wherever the include itself stands.
  const std::filesystem::path folder = file_.parent_path().empty() ? "." : file_.parent_path();
  const std::filesystem::path there = (folder / wanted).lexically_normal();
  if (!files_.insert(there.string()).second) {
    xml_.fail(include, fmt::format("file: found '{}' a second time, expected it once", abridged(name)));
  }
  if (files_.size() > kMostIncludes) {
    xml_.fail(include, fmt::format("found more than {} included files", kMostIncludes));
  }
  const XmlElement& root = xml_.parse(includedText(include, there), wanted, {"mujocoinclude", "mujoco"});
  xml_.find(root, "model");
  return *(included_[&include] = &root);
}

std::vector<const XmlElement*> MjcfFile::childElements(const XmlElement& element) {
  std::vector<const XmlElement*> children;
  for (const auto* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) {
    if (std::string_view(child->Name()) != "include") {
      children.push_back(child);
      continue;
    }
    const std::vector<const XmlElement*> inner = childElements(includedRoot(*child));
    children.insert(children.end(), inner.begin(), inner.end());
  }
  return children;
}

void MjcfFile::checkDepth(const XmlElement& element, int depth) const {
  if (depth > kDeepestMjcf) xml_.fail(element, fmt::format("found elements nested deeper than {}", kDeepestMjcf));
}

void MjcfFile::checkKeywords(const XmlElement& element) const {
  for (const auto* a = element.FirstAttribute(); a; a = a->Next()) {
    const std::span<const std::string_view> words = mjcfKeywords(element.Name(), a->Name());
    if (words.empty() || std::ranges::find(words, a->Value()) != words.end()) continue;
    xml_.fail(element,
              fmt::format("{}: found '{}', expected {}", a->Name(), abridged(a->Value()), fmt::join(words, ", ")));
  }
}

void MjcfFile::leaveOut(const XmlElement& element, int depth) {
  checkDepth(element, depth);
  used_.erase(&element);
  xml_.understand(element);
  for (const auto* a = element.FirstAttribute(); a; a = a->Next()) xml_.find(element, a->Name());
  for (const XmlElement* child : childElements(element)) leaveOut(*child, depth + 1);
}

std::string MjcfFile::modelName() {
  const char* const name = xml_.find(*root_, "model");
  return name == nullptr || *name == '\0' ? "robot" : name;
}

std::vector<MjcfNode> MjcfFile::sections(const std::string& name) {
  std::vector<MjcfNode> found;
  for (const XmlElement* section : childElements(*root_)) {
    if (section->Name() == name) found.emplace_back(*this, *section, "", "mujoco");
  }
  return found;
}

void MjcfFile::readCompiler() {
  for (const MjcfNode& node : sections("compiler")) {
    if (const char* angle = node.find("angle")) compiler_.degrees = std::string(angle) != "radian";
    if (const char* order = node.find("eulerseq")) {
      compiler_.euler = order;
      if (compiler_.euler.size() != 3 || compiler_.euler.find_first_not_of("xyzXYZ") != std::string::npos) {
        node.fail(fmt::format("eulerseq: found '{}', expected three of x, y, z, X, Y, Z", abridged(order)));
      }
    }
    compiler_.autolimits = node.flag("autolimits", compiler_.autolimits);
    if (const char* from = node.find("inertiafromgeom")) compiler_.inertia_from_geom = from;
    if (const char* groups = node.find("inertiagrouprange")) {
      compiler_.inertia_groups = xml_.numbers(node.xml(), "inertiagrouprange", groups);
      if (compiler_.inertia_groups.size() != 2) node.fail("inertiagrouprange: expected two numbers");
    }
    compiler_.total_mass = node.number("settotalmass", compiler_.total_mass);
    compiler_.balance_inertia = node.flag("balanceinertia", compiler_.balance_inertia);
    compiler_.least_mass = node.nonNegative("boundmass", compiler_.least_mass);
    compiler_.least_inertia = node.nonNegative("boundinertia", compiler_.least_inertia);
    if (const char* coordinate = node.find("coordinate"); coordinate && std::string(coordinate) != "local") {
      node.fail("coordinate: found global coordinates, expected local ones");
    }
  }
}

void MjcfFile::readDefaults(const XmlElement& element, const std::string& name, const std::string& parent, int depth) {
  checkDepth(element, depth);
  xml_.understand(element);
  const char* const given = xml_.find(element, "class");
  const std::string own = given != nullptr ? given : name;
  if (own.empty()) xml_.fail(element, "found no class, expected its name");
  const bool outermost = parent.empty();
  if (!names_["default class"].insert(own).second && !outermost) {
    xml_.fail(element, fmt::format("the name '{}' is taken by another default class", abridged(own)));
  }
  // The outermost class holds for all, whatever it is called.
  const std::string filled = outermost ? "main" : own;
  if (own != "main") classes_[own].parent = outermost ? "main" : parent;
  for (const XmlElement* child : childElements(element)) {
    if (std::string_view(child->Name()) == "default") {
      readDefaults(*child, "", filled, depth + 1);
    } else {
      checkKeywords(*child);
      classes_[filled].elements[defaultTag("default", child->Name())].push_back(child);
      xml_.understand(*child);
    }
  }
}

std::vector<const XmlElement*> MjcfFile::defaultsOf(const std::string& tag, const std::string& name) const {
  std::vector<const XmlElement*> layers;
  for (auto at = classes_.find(name); at != classes_.end(); at = classes_.find(at->second.parent)) {
    const auto elements = at->second.elements.find(tag);
    if (elements == at->second.elements.end()) continue;
    layers.insert(layers.begin(), elements->second.begin(), elements->second.end());
  }
  return layers;
}

std::vector<ExchangeRemark> MjcfFile::finish() {
  // Defaults that no element of the robot takes say nothing about it.
  std::set<const XmlElement*> asked;
  for (const auto& [element, layers] : used_) asked.insert(layers.begin(), layers.end());
  for (const auto& [name, known] : classes_) {
    for (const auto& [tag, elements] : known.elements) {
      for (const XmlElement* element : elements) {
        if (asked.contains(element)) continue;
        for (const auto* a = element->FirstAttribute(); a; a = a->Next()) xml_.find(*element, a->Name());
      }
    }
  }
  return xml_.finish(kIgnoredInMjcf);
}

}  // namespace simgap
