/// \file
/// MJCF as a reader asks for it: includes in their place, attributes with their defaults, frames, the compiler's units.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "xml_robot.h"

namespace simgap {

class MjcfFile;

/// An element with what its default class says.
class MjcfNode {
 public:
  MjcfNode(MjcfFile& file, const XmlElement& element, std::string childclass);

  const XmlElement& xml() const { return *element_; }
  std::string tag() const { return element_->Name(); }
  const std::string& childclass() const { return childclass_; }  ///< of what stands in it
  std::vector<MjcfNode> children() const;
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
  bool isLimited(const char* flag_name, const char* range) const;

 private:
  MjcfFile* file_;
  const XmlElement* element_;
  std::string childclass_;
  std::string class_;
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
    double least_mass = 0.0, least_inertia = 0.0;
  };
  const Compiler& compiler() const { return compiler_; }

  std::vector<ExchangeRemark> finish();

 private:
  friend class MjcfNode;
  struct DefaultClass {
    std::string parent;
    std::map<std::string, std::vector<const XmlElement*>> elements;  ///< by tag
  };
  std::vector<const XmlElement*> childElements(const XmlElement& element);
  const XmlElement& includedRoot(const XmlElement& include);
  void readCompiler();
  void readDefaults(const XmlElement& element, const std::string& name, const std::string& parent);
  const char* findDefault(const std::string& tag, const std::string& name, const char* attribute);

  XmlRobot xml_;
  std::filesystem::path file_;
  FileReader read_;
  const XmlElement* root_;
  Compiler compiler_;
  std::map<std::string, DefaultClass> classes_;
  std::set<std::pair<std::string, std::string>> used_;  ///< tag and class of every element that was read
  std::map<const XmlElement*, const XmlElement*> included_;
  std::set<std::string> files_;
};

}  // namespace simgap
