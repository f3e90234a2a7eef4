/// \file
/// XML of a robot, read so that nothing is lost in silence: what no reader has asked for becomes a remark.
#pragma once

#include <tinyxml2.h>

#include <Eigen/Geometry>
#include <list>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "simgap/exchange/exchange.h"

namespace simgap {

/// No robot file may hold more bytes or elements.
inline constexpr std::size_t kLargestRobotFile = std::size_t{64} << 20U;
inline constexpr int kMostRobotElements = 200000;
/// No number of a robot file is larger.
inline constexpr double kLargestRobotNumber = 1e12;

using XmlElement = tinyxml2::XMLElement;

/// The documents of a robot, and which of their elements and attributes have been understood.
class XmlRobot {
 public:
  /// \throws DataError: no XML, too much of it, or another root element
  const XmlElement& parse(const std::string& text, const std::filesystem::path& file,
                          const std::vector<std::string>& roots);

  std::string place(const XmlElement& element) const;  ///< "finger.xml:12"
  [[noreturn]] void fail(const XmlElement& element, const std::string& sentence) const;

  /// \throws DataError: it holds macros of xacro, which have to be expanded before they mean a robot
  void refuseMacros(const XmlElement& element) const;
  /// \throws DataError: no UTF-8, which no file or terminal of ours could hold
  void checkText(const XmlElement& element, std::string_view text) const;
  /// An attribute's text; it counts as understood. \throws DataError as checkText
  const char* find(const XmlElement& element, const char* attribute);
  /// The same of an attribute that has to be there. \throws DataError: it is not, or empty
  std::string required(const XmlElement& element, const char* attribute);
  /// The first child of a name; it counts as understood. nullptr: none.
  const XmlElement* child(const XmlElement& element, const char* name);
  /// The element counts as understood, not so its attributes and children.
  void understand(const XmlElement& element) { understood_.insert(&element); }
  /// The element with all that is in it is left out, or taken in another way.
  void remark(const XmlElement& element, const std::string& what, const std::string& done, bool matters = true);
  /// The same for one attribute.
  /// Without a place in the file. What was said already gets one more place only.
  void add(const std::string& what, const std::string& done, bool matters, const std::string& place = {});

  /// Remarks so far, and one for everything that nobody has asked for. \param ignored  attributes and elements that
  /// change neither rest nor motion: reason by name
  std::vector<ExchangeRemark> finish(const std::map<std::string, std::string>& ignored);

  /// \name Attributes with a meaning. \throws DataError: other numbers, or another number of them
  ///@{
  std::vector<double> numbers(const XmlElement& element, const char* attribute, const char* text) const;
  double number(const XmlElement& element, const char* attribute, const char* text) const;
  Eigen::Vector3d vector3(const XmlElement& element, const char* attribute, const char* text) const;
  ///@}

 private:
  struct Document {
    std::string name;
    tinyxml2::XMLDocument xml;
  };
  void cover(const XmlElement& element);
  void remarkUnread(const XmlElement& element, const std::map<std::string, std::string>& ignored);

  std::list<Document> documents_;
  std::set<const void*> understood_;
  std::vector<ExchangeRemark> remarks_;
  std::map<std::string, std::size_t> index_;  ///< of a remark, by its text
};

/// What one thing of a file is to be called in the arm.
struct NameWish {
  std::string* name;  ///< receives it
  std::string kind;   ///< "joint", for a remark
  std::string given;  ///< in the file; empty without one
  std::string place;
  std::string made_up;  ///< of what has no name
};

/// Given names first, then those that our files cannot hold or that are taken, then made-up ones, so that a made-up one
/// never takes a given one. A given name that becomes another is remarked.
void giveNames(const std::vector<NameWish>& wishes, std::set<std::string>& taken, XmlRobot& xml);

/// A name that our files can hold: '.', '*' and ',' become '_'; free among `taken`, to which it is added.
std::string freeName(std::string wanted, std::set<std::string>& taken);

}  // namespace simgap
