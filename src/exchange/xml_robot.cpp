#include "xml_robot.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/text.h"
#include "simgap/core/units.h"
#include "simgap/core/words.h"

namespace simgap {
namespace {

int countElements(const XmlElement& element) {
  int count = 1;
  for (const auto* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) {
    count += countElements(*child);
    if (count > kMostRobotElements) break;
  }
  return count;
}

/// Whether every byte above 127 belongs to a character, each of which is as long as its first byte says.
bool isUtf8(std::string_view text) {
  std::size_t left = 0;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool follows = (byte & 0xC0U) == 0x80U;
    if (follows != (left > 0)) return false;
    if (follows) {
      --left;
    } else if (byte >= 0x80U) {
      if (byte < 0xC2U || byte > 0xF4U) return false;
      left = byte < 0xE0U ? 1 : byte < 0xF0U ? 2 : 3;
    }
  }
  return left == 0;
}

std::string heldName(std::string name) {
  for (char& c : name) {
    if (c == '.' || c == '*' || c == ',' || static_cast<unsigned char>(c) < 0x20) c = '_';
  }
  return name.empty() ? "unnamed" : name;
}

}  // namespace

const XmlElement& XmlRobot::parse(const std::string& text, const std::filesystem::path& file,
                                  const std::vector<std::string>& roots) {
  // Included files are told apart by their folders.
  const std::string name = documents_.empty() ? file.filename().string() : file.generic_string();
  if (text.size() > kLargestRobotFile) {
    throw DataError(fmt::format("{}: found {} bytes, expected at most {}", name, text.size(), kLargestRobotFile));
  }
  Document& document = documents_.emplace_back();
  document.name = name;
  if (document.xml.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
    const int line = std::max(1, document.xml.ErrorLineNum());
    if (document.xml.ErrorID() == tinyxml2::XML_ELEMENT_DEPTH_EXCEEDED) {
      throw DataError(
          fmt::format("{}:{}: found elements nested deeper than {}, the most that can be read of one file; deeper "
                      "bodies of MJCF can "
                      "stand in an <include>",
                      name, line, TINYXML2_MAX_ELEMENT_DEPTH));
    }
    throw DataError(fmt::format("{}:{}: found no XML that can be read ({}), expected a robot in XML", name, line,
                                document.xml.ErrorName()));
  }
  const XmlElement* const root = document.xml.RootElement();
  if (root == nullptr) throw DataError(fmt::format("{}: found no element, expected <{}>", name, roots.front()));
  document.xml.SetUserData(&document);
  // What a DOCTYPE declares (entities, defaults of attributes) is never expanded: a robot in it would be another.
  for (const auto* node = document.xml.FirstChild(); node; node = node->NextSibling()) {
    if (node->ToUnknown() == nullptr) continue;
    throw DataError(fmt::format("{}:{}: found a document type, expected none in a robot", name, node->GetLineNum()));
  }
  if (std::ranges::find(roots, root->Name()) == roots.end()) {
    fail(*root, fmt::format("found it as the outermost element, expected <{}>", fmt::join(roots, "> or <")));
  }
  if (countElements(*root) > kMostRobotElements) {
    throw DataError(fmt::format("{}: found more than {} elements, expected a robot", name, kMostRobotElements));
  }
  understand(*root);
  return *root;
}

std::string XmlRobot::place(const XmlElement& element) const {
  const auto* const document = static_cast<const Document*>(element.GetDocument()->GetUserData());
  return fmt::format("{}:{}", document->name, element.GetLineNum());
}

void XmlRobot::fail(const XmlElement& element, const std::string& sentence) const {
  throw DataError(fmt::format("{}: {}: {}", place(element), abridged(element.Name()), sentence));
}

const char* XmlRobot::find(const XmlElement& element, const char* attribute) {
  const tinyxml2::XMLAttribute* const found = element.FindAttribute(attribute);
  if (found == nullptr) return nullptr;
  understood_.insert(found);
  checkText(element, found->Value());
  return found->Value();
}

void XmlRobot::refuseMacros(const XmlElement& element) const {
  const auto refuse = [&](std::string_view found) {
    fail(element, fmt::format("found '{}', a macro of xacro: expand it with xacro first", abridged(found)));
  };
  if (std::string_view(element.Name()).starts_with("xacro:")) refuse(element.Name());
  for (const auto* a = element.FirstAttribute(); a; a = a->Next()) {
    if (std::string_view(a->Value()).find("${") != std::string_view::npos) refuse(a->Value());
  }
  for (const auto* e = element.FirstChildElement(); e; e = e->NextSiblingElement()) refuseMacros(*e);
}

void XmlRobot::checkText(const XmlElement& element, std::string_view text) const {
  if (!isUtf8(text)) fail(element, "found a text that is no UTF-8, expected names in UTF-8");
}

std::string XmlRobot::required(const XmlElement& element, const char* attribute) {
  const char* const value = find(element, attribute);
  if (value == nullptr || *value == '\0') fail(element, fmt::format("found no {}, expected one", attribute));
  return value;
}

const XmlElement* XmlRobot::child(const XmlElement& element, const char* name) {
  const XmlElement* const found = element.FirstChildElement(name);
  if (found != nullptr) understand(*found);
  return found;
}

void XmlRobot::cover(const XmlElement& element) {
  understood_.insert(&element);
  for (const auto* a = element.FirstAttribute(); a; a = a->Next()) understood_.insert(a);
  for (const auto* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) cover(*child);
}

void XmlRobot::add(const std::string& what, const std::string& done, bool matters, const std::string& place) {
  const auto [entry, fresh] = index_.try_emplace(what + '\n' + done, remarks_.size());
  if (fresh) remarks_.push_back({what, done, matters, {}});
  std::vector<std::string>& places = remarks_[entry->second].places;
  if (!place.empty() && (places.empty() || places.back() != place)) places.push_back(place);
}

void XmlRobot::remark(const XmlElement& element, const std::string& what, const std::string& done, bool matters) {
  cover(element);
  add(what, done, matters, place(element));
}

void XmlRobot::remarkUnread(const XmlElement& element, const std::map<std::string, std::string>& ignored) {
  const auto say = [&](const std::string& key, const std::string& what) {
    const auto reason = ignored.find(key);
    const bool matters = reason == ignored.end();
    add(what, matters ? "not understood, left out" : reason->second, matters, place(element));
  };
  const std::string name = abridged(element.Name());
  if (!understood_.contains(&element)) return say(element.Name(), name);
  for (const auto* a = element.FirstAttribute(); a; a = a->Next()) {
    if (!understood_.contains(a)) say(fmt::format("@{}", a->Name()), fmt::format("{} {}", name, abridged(a->Name())));
  }
  for (const auto* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) {
    remarkUnread(*child, ignored);
  }
}

std::vector<ExchangeRemark> XmlRobot::finish(const std::map<std::string, std::string>& ignored) {
  for (const Document& document : documents_) remarkUnread(*document.xml.RootElement(), ignored);
  std::ranges::stable_sort(remarks_, {}, [](const ExchangeRemark& remark) { return !remark.matters; });
  return remarks_;
}

std::vector<double> XmlRobot::numbers(const XmlElement& element, const char* attribute, const char* text) const {
  Words words(text);
  std::vector<double> values;
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    const std::optional<double> value = parseNumber(word);
    if (!value || std::abs(*value) > kLargestRobotNumber) {
      fail(element, fmt::format("{}: found '{}', expected a finite number", attribute, abridged(word)));
    }
    values.push_back(*value);
  }
  return values;
}

double XmlRobot::number(const XmlElement& element, const char* attribute, const char* text) const {
  const std::vector<double> values = numbers(element, attribute, text);
  if (values.size() != 1) fail(element, fmt::format("{}: found {} numbers, expected one", attribute, values.size()));
  return values[0];
}

Eigen::Vector3d XmlRobot::vector3(const XmlElement& element, const char* attribute, const char* text) const {
  const std::vector<double> values = numbers(element, attribute, text);
  if (values.size() != 3) fail(element, fmt::format("{}: found {} numbers, expected three", attribute, values.size()));
  return {values[0], values[1], values[2]};
}

void giveNames(const std::vector<NameWish>& wishes, std::set<std::string>& taken, XmlRobot& xml) {
  const auto holdable = [](const NameWish& wish) { return !wish.given.empty() && heldName(wish.given) == wish.given; };
  for (const NameWish& wish : wishes) {
    if (holdable(wish) && taken.insert(wish.given).second) *wish.name = wish.given;
  }
  for (const NameWish& wish : wishes) {
    if (wish.given.empty() || !wish.name->empty()) continue;
    *wish.name = freeName(wish.given, taken);
    xml.add(fmt::format("{} '{}'", wish.kind, abridged(wish.given)),
            fmt::format("called '{}' here: {}", abridged(*wish.name),
                        holdable(wish) ? "the name is taken" : "names hold neither '.' nor '*' nor ','"),
            false, wish.place);
  }
  for (const NameWish& wish : wishes) {
    if (wish.given.empty()) *wish.name = freeName(wish.made_up, taken);
  }
}

std::string freeName(std::string wanted, std::set<std::string>& taken) {
  wanted = heldName(std::move(wanted));
  std::string name = wanted;
  for (int i = 2; !taken.insert(name).second; ++i) name = fmt::format("{}_{}", wanted, i);
  return name;
}

}  // namespace simgap
