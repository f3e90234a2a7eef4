#include "mjcf_file.h"

#include <fmt/format.h>

#include <numbers>

#include "simgap/core/error.h"
#include "simgap/core/rotation.h"
#include "simgap/core/text.h"

namespace simgap {
namespace {

constexpr std::size_t kMostIncludes = 200;
constexpr double kShortestAxis = 1e-10;

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
      {"contact", "@contype", "@conaffinity", "@condim", "@friction", "@solref", "@solimp", "@margin", "@gap",
       "@solmix", "@priority", "@fluidshape", "@fluidcoef"});
  add("how MuJoCo solves, not what: left out",
      {"@solreflimit", "@solimplimit", "@solreffriction", "@solimpfriction", "@sleep", "lengthrange", "@lengthrange",
       "@meshdir", "@texturedir", "@assetdir", "@strippath", "@usethread", "@fusestatic", "@discardvisual",
       "@convexhull", "@alignfree", "@saveinertial", "@inertiagrouprange"});
  return reasons;
}();

/// Whether `inner` stands in `folder` or below it.
bool standsBelow(const std::filesystem::path& folder, const std::filesystem::path& inner) {
  const std::filesystem::path way = inner.lexically_normal().lexically_relative(folder.lexically_normal());
  return !way.empty() && *way.begin() != "..";
}

}  // namespace

MjcfFile::MjcfFile(const std::string& text, const std::filesystem::path& file, FileReader read)
    : file_(file), read_(std::move(read)), root_(&xml_.parse(text, file, {"mujoco"})) {
  classes_["main"];
  readCompiler();
  for (const XmlElement* section : childElements(*root_)) {
    if (std::string(section->Name()) == "default") readDefaults(*section, "main", "");
  }
}

const XmlElement& MjcfFile::includedRoot(const XmlElement& include) {
  const auto known = included_.find(&include);
  if (known != included_.end()) return *known->second;
  const char* const name = xml_.find(include, "file");
  xml_.understand(include);
  if (name == nullptr) xml_.fail(include, "found no file, expected one");
  const std::filesystem::path wanted(name);
  const std::filesystem::path folder = file_.parent_path().empty() ? "." : file_.parent_path();
  if (wanted.is_absolute() || !standsBelow(folder, folder / wanted)) {
    xml_.fail(include, fmt::format("file: found '{}', expected a file in the model's own folder", abridged(name)));
  }
  if (!files_.insert(wanted.lexically_normal().string()).second) {
    xml_.fail(include, fmt::format("file: found '{}' a second time, expected it once", abridged(name)));
  }
  if (files_.size() > kMostIncludes) {
    xml_.fail(include, fmt::format("found more than {} included files", kMostIncludes));
  }
  const XmlElement& root = xml_.parse(read_(folder / wanted), wanted, {"mujocoinclude", "mujoco"});
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

std::string MjcfFile::modelName() {
  const char* const name = xml_.find(*root_, "model");
  return name == nullptr || *name == '\0' ? "robot" : name;
}

std::vector<MjcfNode> MjcfFile::sections(const std::string& name) {
  std::vector<MjcfNode> found;
  for (const XmlElement* section : childElements(*root_)) {
    if (section->Name() == name) found.emplace_back(*this, *section, "");
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
    compiler_.least_mass = node.nonNegative("boundmass", compiler_.least_mass);
    compiler_.least_inertia = node.nonNegative("boundinertia", compiler_.least_inertia);
    if (const char* coordinate = node.find("coordinate"); coordinate && std::string(coordinate) != "local") {
      node.fail("coordinate: found global coordinates, expected local ones");
    }
  }
}

void MjcfFile::readDefaults(const XmlElement& element, const std::string& name, const std::string& parent) {
  xml_.understand(element);
  const char* const given = xml_.find(element, "class");
  const std::string own = given != nullptr ? given : name;
  if (own.empty()) xml_.fail(element, "found no class, expected its name");
  if (own != "main") classes_[own].parent = parent;
  for (const XmlElement* child : childElements(element)) {
    if (std::string_view(child->Name()) == "default") {
      readDefaults(*child, "", own);
    } else {
      classes_[own].elements[child->Name()].push_back(child);
      xml_.understand(*child);
    }
  }
}

const char* MjcfFile::findDefault(const std::string& tag, const std::string& name, const char* attribute) {
  // Classes stand in a tree, whose depth XML limits; a class that is its own ancestor by a repeated name ends here.
  std::size_t steps = 0;
  for (std::string at = name; !at.empty() && steps <= classes_.size(); ++steps) {
    const auto found = classes_.find(at);
    if (found == classes_.end()) return nullptr;
    const auto elements = found->second.elements.find(tag);
    if (elements != found->second.elements.end()) {
      for (auto e = elements->second.rbegin(); e != elements->second.rend(); ++e) {
        if (const char* value = xml_.find(**e, attribute)) return value;
      }
    }
    at = found->second.parent;
  }
  return nullptr;
}

std::vector<ExchangeRemark> MjcfFile::finish() {
  // Defaults that no element of the robot takes say nothing about it.
  std::set<const XmlElement*> asked;
  for (const auto& [tag, name] : used_) {
    std::size_t steps = 0;
    for (std::string at = name; !at.empty() && steps <= classes_.size(); at = classes_[at].parent, ++steps) {
      for (const XmlElement* element : classes_[at].elements[tag]) asked.insert(element);
    }
  }
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

MjcfNode::MjcfNode(MjcfFile& file, const XmlElement& element, std::string childclass)
    : file_(&file), element_(&element), childclass_(std::move(childclass)) {
  file.xml().understand(element);
  if (const char* inner = file.xml().find(element, "childclass")) childclass_ = inner;
  const char* const own = file.xml().find(element, "class");
  class_ = own != nullptr ? own : childclass_.empty() ? "main" : childclass_;
  if (!file.classes_.contains(class_)) {
    // The compiler is read before the defaults; nothing else is.
    if (own != nullptr || !childclass_.empty()) {
      fail(fmt::format("class: found '{}', expected one of the default classes", abridged(class_)));
    }
  }
  file.used_.emplace(element.Name(), class_);
}

std::vector<MjcfNode> MjcfNode::children() const {
  std::vector<MjcfNode> nodes;
  for (const XmlElement* child : file_->childElements(*element_)) nodes.emplace_back(*file_, *child, childclass_);
  return nodes;
}

void MjcfNode::fail(const std::string& sentence) const { file_->xml().fail(*element_, sentence); }

void MjcfNode::remarkAll(const std::string& what, const std::string& done, bool matters) const {
  file_->xml().remark(*element_, what, done, matters);
}

void MjcfNode::remark(const char* attribute, const std::string& done, bool matters) const {
  find(attribute);
  file_->xml().add(fmt::format("{} {}", tag(), attribute), done, matters, file_->xml().place(*element_));
}

const char* MjcfNode::find(const char* attribute) const {
  const char* const own = file_->xml().find(*element_, attribute);
  return own != nullptr ? own : file_->findDefault(tag(), class_, attribute);
}

std::string MjcfNode::text(const char* attribute) const {
  const char* const value = find(attribute);
  return value == nullptr ? "" : value;
}

double MjcfNode::number(const char* attribute, double fallback) const {
  const char* const value = find(attribute);
  return value == nullptr ? fallback : file_->xml().number(*element_, attribute, value);
}

double MjcfNode::nonNegative(const char* attribute, double fallback) const {
  const double value = number(attribute, fallback);
  if (value < 0.0) fail(fmt::format("{}: found {}, expected a number >= 0", attribute, value));
  return value;
}

std::vector<double> MjcfNode::numbers(const char* attribute) const {
  const char* const value = find(attribute);
  return value == nullptr ? std::vector<double>() : file_->xml().numbers(*element_, attribute, value);
}

Eigen::Vector3d MjcfNode::vector3(const char* attribute, const Eigen::Vector3d& fallback) const {
  const char* const value = find(attribute);
  return value == nullptr ? fallback : file_->xml().vector3(*element_, attribute, value);
}

bool MjcfNode::flag(const char* attribute, bool automatic) const {
  const char* const value = find(attribute);
  const std::string word = value == nullptr ? "auto" : value;
  if (word == "auto") return automatic;
  if (word != "true" && word != "false") {
    fail(fmt::format("{}: found '{}', expected true, false or auto", attribute, abridged(word)));
  }
  return word == "true";
}

double MjcfNode::angleUnit() const { return file_->compiler().degrees ? std::numbers::pi / 180.0 : 1.0; }

bool MjcfNode::isLimited(const char* flag_name, const char* range) const {
  return flag(flag_name, file_->compiler().autolimits && has(range));
}

Eigen::Quaterniond MjcfNode::orientation() const {
  const auto axis = [&](const Eigen::Vector3d& v, const char* attribute) -> Eigen::Vector3d {
    if (v.norm() < kShortestAxis) fail(fmt::format("{}: found a zero vector, expected an axis", attribute));
    return v.normalized();
  };
  const auto sized = [&](const char* attribute, std::size_t count) {
    const std::vector<double> values = numbers(attribute);
    if (values.size() != count) {
      fail(fmt::format("{}: found {} numbers, expected {}", attribute, values.size(), count));
    }
    return values;
  };
  if (has("quat")) {
    const std::vector<double> q = sized("quat", 4);
    const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
    if (rotation.norm() < kShortestAxis) fail("quat: found zeros, expected a rotation");
    return rotation.normalized();
  }
  if (has("axisangle")) {
    const std::vector<double> a = sized("axisangle", 4);
    return Eigen::Quaterniond(Eigen::AngleAxisd(a[3] * angleUnit(), axis({a[0], a[1], a[2]}, "axisangle")));
  }
  if (has("euler")) {
    const std::vector<double> angles = sized("euler", 3);
    Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
    for (std::size_t i = 0; i < 3; ++i) {
      const char letter = file_->compiler().euler[i];
      const bool turned = letter >= 'x';  // small: about the axes as turned so far
      const Eigen::Vector3d unit = Eigen::Vector3d::Unit(letter - (turned ? 'x' : 'X'));
      const Eigen::Quaterniond turn(Eigen::AngleAxisd(angles[i] * angleUnit(), unit));
      rotation = turned ? rotation * turn : turn * rotation;
    }
    return rotation.normalized();
  }
  if (has("xyaxes")) {
    const std::vector<double> a = sized("xyaxes", 6);
    Eigen::Matrix3d columns;
    columns.col(0) = axis({a[0], a[1], a[2]}, "xyaxes");
    const Eigen::Vector3d y(a[3], a[4], a[5]);
    columns.col(1) = axis(y - y.dot(columns.col(0)) * columns.col(0), "xyaxes");
    columns.col(2) = columns.col(0).cross(columns.col(1));
    return Eigen::Quaterniond(columns);
  }
  if (has("zaxis")) {
    return rotationBetween(Eigen::Vector3d::UnitZ(), axis(vector3("zaxis", Eigen::Vector3d::Zero()), "zaxis"));
  }
  return Eigen::Quaterniond::Identity();
}

Eigen::Isometry3d MjcfNode::frame() const {
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  frame.linear() = orientation().toRotationMatrix();
  frame.translation() = vector3("pos", Eigen::Vector3d::Zero());
  return frame;
}

}  // namespace simgap
