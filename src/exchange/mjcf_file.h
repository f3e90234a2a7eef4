/// \file
/// MJCF as a reader asks for it: includes in their place, attributes with their defaults, frames, the compiler's units.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "xml_robot.h"

namespace simgap {

/// Elements within each other over all includes, which could nest any number of them and exhaust the stack.
inline constexpr int kDeepestMjcf = 500;

class MjcfFile;

/// An element with what its default class says.
class MjcfNode {
 public:
  /// \param parent  tag of the element or section it stands in
  MjcfNode(MjcfFile& file, const XmlElement& element, std::string childclass, const std::string& parent);

  const XmlElement& xml() const { return *element_; }
  std::string tag() const { return element_->Name(); }
  const std::string& childclass() const { return childclass_; }  ///< of what stands in it
  std::vector<MjcfNode> children() const;
  /// The defaults of its class, the outermost first, and the element itself last: each with its own attributes only.
  std::vector<MjcfNode> layers() const;
  /// Its own name; empty without one. \throws DataError: another element of that kind has it
  std::string newName(const std::string& kind) const;
  [[noreturn]] void fail(const std::string& sentence) const;
  /// The element with all that is in it, or an attribute of it, is left out or taken in another way.
  void remarkAll(const std::string& what, const std::string& done, bool matters = true) const;
  void remark(const char* attribute, const std::string& done, bool matters = true) const;

  /// \name Attributes: of the element itself, else of its default class, else empty or `fallback`
  /// \throws DataError: no numbers, or another number of them
  ///@{
  const char* find(const char* attribute) const;
  bool has(const char* attribute) const { return find(attribute) != nullptr; }
  std::string text(const char* attribute) const;
  double number(const char* attribute, double fallback) const;
  double nonNegative(const char* attribute, double fallback) const;
  std::vector<double> numbers(const char* attribute) const;
  Eigen::Vector3d vector3(const char* attribute, const Eigen::Vector3d& fallback) const;
  /// "true", "false", and "auto" as `automatic`
  bool flag(const char* attribute, bool automatic) const;
  ///@}

  /// Unit quaternion of quat, axisangle, euler, xyaxes or zaxis; identity without any.
  Eigen::Quaterniond orientation() const;
  Eigen::Isometry3d frame() const;  ///< orientation and pos
  double angleUnit() const;         ///< [rad] of a number that is an angle
  /// Both ends of a range; empty where it limits nothing.
  std::optional<std::array<double, 2>> limits(const char* flag_name, const char* range) const;

 private:
  MjcfNode(MjcfFile& file, const XmlElement& layer) : file_(&file), element_(&layer), layers_({&layer}) {}
  std::vector<double> sized(const char* attribute, std::size_t count) const;
  Eigen::Quaterniond turn(const std::string& attribute) const;

  MjcfFile* file_;
  const XmlElement* element_;
  std::string childclass_;
  std::vector<const XmlElement*> layers_;
};

class MjcfFile {
 public:
  MjcfFile(const std::string& text, const std::filesystem::path& file, FileReader read);

  XmlRobot& xml() { return xml_; }
  std::string modelName();
  /// Sections of that name, in the order of the file: <worldbody>, <tendon>, …
  std::vector<MjcfNode> sections(const std::string& name);

  struct Compiler {
    bool degrees = true;
    std::string euler = "xyz";
    bool autolimits = true;
    std::string inertia_from_geom = "auto";
    std::vector<double> inertia_groups = {0, 5};
    double total_mass = -1.0;
    bool balance_inertia = false;
    double least_mass = 0.0, least_inertia = 0.0;
  };
  const Compiler& compiler() const { return compiler_; }

  std::vector<ExchangeRemark> finish();

 private:
  friend class MjcfNode;
  struct DefaultClass {
    std::string parent;
    std::map<std::string, std::vector<const XmlElement*>> elements;  ///< by defaultTag
  };
  std::vector<const XmlElement*> childElements(const XmlElement& element);
  const XmlElement& includedRoot(const XmlElement& include);
  std::string includedText(const XmlElement& include, const std::filesystem::path& file) const;
  /// What is left out, with all that is in it, asks nothing of its class.
  void leaveOut(const XmlElement& element, int depth = 0);
  void readCompiler();
  void readDefaults(const XmlElement& element, const std::string& name, const std::string& parent, int depth = 0);
  void checkDepth(const XmlElement& element, int depth) const;
  /// \throws DataError: an attribute says none of the words that MuJoCo knows there
  void checkKeywords(const XmlElement& element) const;
  /// What a class says about elements of a kind, the outermost class first.
  std::vector<const XmlElement*> defaultsOf(const std::string& tag, const std::string& name) const;

  XmlRobot xml_;
  std::filesystem::path file_;
  FileReader read_;
  const XmlElement* root_;
  Compiler compiler_;
  std::map<std::string, DefaultClass> classes_;
  /// The defaults of every element that was read.
  std::map<const XmlElement*, std::vector<const XmlElement*>> used_;
  std::map<std::string, std::set<std::string>> names_ = {{"body", {"world"}},
                                                         {"default class", {"main"}}};  ///< taken ones, by kind
  std::map<const XmlElement*, const XmlElement*> included_;
  std::set<std::string> files_;
};

}  // namespace simgap
