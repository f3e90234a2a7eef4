// An MJCF element as a reader asks for it: attributes with their defaults, frames, limits.
#include <fmt/format.h>

#include <numbers>

#include "mjcf_defaults.h"
#include "mjcf_file.h"
#include "simgap/core/rotation.h"
#include "simgap/core/text.h"

namespace simgap {
namespace {

constexpr double kShortestAxis = 1e-10;

}  // namespace

MjcfNode::MjcfNode(MjcfFile& file, const XmlElement& element, std::string childclass, const std::string& parent)
    : file_(&file), element_(&element), childclass_(std::move(childclass)) {
  file.xml().understand(element);
  file.checkKeywords(element);
  if (const char* inner = file.xml().find(element, "childclass")) childclass_ = inner;
  const char* const own = file.xml().find(element, "class");
  const std::string name = own != nullptr ? own : childclass_.empty() ? "main" : childclass_;
  // The compiler is read before the defaults; nothing else is.
  if (!file.classes_.contains(name) && (own != nullptr || !childclass_.empty())) {
    fail(fmt::format("class: found '{}', expected one of the default classes", abridged(name)));
  }
  layers_ = file.defaultsOf(defaultTag(parent, element.Name()), name);
  file.used_[&element] = layers_;
  layers_.push_back(&element);
}

std::vector<MjcfNode> MjcfNode::children() const {
  std::vector<MjcfNode> nodes;
  for (const XmlElement* child : file_->childElements(*element_)) {
    nodes.emplace_back(*file_, *child, childclass_, element_->Name());
  }
  return nodes;
}

std::vector<MjcfNode> MjcfNode::layers() const {
  std::vector<MjcfNode> nodes;
  for (const XmlElement* layer : layers_) nodes.push_back(MjcfNode(*file_, *layer));
  return nodes;
}

std::string MjcfNode::newName(const std::string& kind) const {
  const char* const name = file_->xml().find(*element_, "name");
  if (name == nullptr || *name == '\0') return "";
  if (!file_->names_[kind].insert(name).second) {
    fail(fmt::format("the name '{}' is taken by another {}", abridged(name), kind));
  }
  return name;
}

void MjcfNode::fail(const std::string& sentence) const { file_->xml().fail(*element_, sentence); }

void MjcfNode::remarkAll(const std::string& what, const std::string& done, bool matters) const {
  file_->xml().remark(*element_, what, done, matters);
  file_->leaveOut(*element_);
}

void MjcfNode::remark(const char* attribute, const std::string& done, bool matters) const {
  find(attribute);
  file_->xml().add(fmt::format("{} {}", tag(), attribute), done, matters, file_->xml().place(*element_));
}

const char* MjcfNode::find(const char* attribute) const {
  // What is said over counts as understood, too.
  const char* value = nullptr;
  for (const XmlElement* layer : layers_) {
    if (const char* const said = file_->xml().find(*layer, attribute)) value = said;
  }
  return value;
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

std::optional<std::array<double, 2>> MjcfNode::limits(const char* flag_name, const char* range) const {
  const std::vector<double> ends = numbers(range);
  if (!flag(flag_name, has(range))) return std::nullopt;
  if (ends.size() != 2) fail(fmt::format("{}: found {} numbers, expected two", range, ends.size()));
  if (flag(flag_name, false)) {
    if (ends[0] > ends[1]) fail(fmt::format("{}: found {} above {}", range, ends[0], ends[1]));
    return std::array{ends[0], ends[1]};
  }
  // Without a word about it, MuJoCo takes a range as a limit only where its first number is below the second.
  if (!file_->compiler().autolimits) {
    remark(range, fmt::format("limits nothing: neither {} nor the compiler's autolimits says that it does", flag_name));
    return std::nullopt;
  }
  if (ends[0] >= ends[1]) {
    remark(range, "limits nothing, as in MuJoCo: its first number is not below the second", ends[0] != ends[1]);
    return std::nullopt;
  }
  return std::array{ends[0], ends[1]};
}

std::vector<double> MjcfNode::sized(const char* attribute, std::size_t count) const {
  const std::vector<double> values = numbers(attribute);
  if (values.size() != count) {
    fail(fmt::format("{}: found {} numbers, expected {}", attribute, values.size(), count));
  }
  return values;
}

Eigen::Quaterniond MjcfNode::turn(const std::string& attribute) const {
  const auto axis = [&](const Eigen::Vector3d& v) -> Eigen::Vector3d {
    if (v.norm() < kShortestAxis) fail(fmt::format("{}: found a zero vector, expected an axis", attribute));
    return v.normalized();
  };
  if (attribute == "quat") {
    const std::vector<double> q = sized("quat", 4);
    const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
    if (rotation.norm() < kShortestAxis) fail("quat: found zeros, expected a rotation");
    return rotation.normalized();
  }
  if (attribute == "axisangle") {
    const std::vector<double> a = sized("axisangle", 4);
    return Eigen::Quaterniond(Eigen::AngleAxisd(a[3] * angleUnit(), axis({a[0], a[1], a[2]})));
  }
  if (attribute == "euler") {
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
  if (attribute == "xyaxes") {
    const std::vector<double> a = sized("xyaxes", 6);
    Eigen::Matrix3d columns;
    columns.col(0) = axis({a[0], a[1], a[2]});
    const Eigen::Vector3d y(a[3], a[4], a[5]);
    columns.col(1) = axis(y - y.dot(columns.col(0)) * columns.col(0));
    columns.col(2) = columns.col(0).cross(columns.col(1));
    return Eigen::Quaterniond(columns);
  }
  const Eigen::Vector3d z = axis(vector3("zaxis", Eigen::Vector3d::Zero()));
  // Half a turn leads to -z about any axis across it; MuJoCo takes x.
  if (std::hypot(z.x(), z.y()) < kShortestAxis && z.z() < 0.0) return {0.0, 1.0, 0.0, 0.0};
  return rotationBetween(Eigen::Vector3d::UnitZ(), z);
}

Eigen::Quaterniond MjcfNode::orientation() const {
  Eigen::Quaterniond said = Eigen::Quaterniond::Identity();
  bool by_quat = true;
  for (const MjcfNode& layer : layers()) {
    std::string how;
    for (const char* const attribute : {"quat", "axisangle", "euler", "xyaxes", "zaxis"}) {
      if (!layer.has(attribute)) continue;
      if (!how.empty()) layer.fail(fmt::format("found {} and {}, expected one orientation", how, attribute));
      how = attribute;
    }
    // MuJoCo keeps a quat apart from all other ways of saying it, which go before it even when a class says them.
    if (how.empty() || (how == "quat" && !by_quat)) continue;
    by_quat = how == "quat";
    said = layer.turn(how);
  }
  return said;
}

Eigen::Isometry3d MjcfNode::frame() const {
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  frame.linear() = orientation().toRotationMatrix();
  frame.translation() = vector3("pos", Eigen::Vector3d::Zero());
  return frame;
}

}  // namespace simgap
