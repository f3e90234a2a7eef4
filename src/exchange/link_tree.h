/// \file
/// Links and the joints between them, as URDF and SDF state them, become a tree of bodies that hangs on one that stands
/// still.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "arm_exchange.h"
#include "xml_robot.h"

namespace simgap {

struct LinkJoint {
  std::string said;  ///< its name in the file
  Joint joint;       ///< type, axis, limits, frictions, spring
  bool fixed = false;
  std::string parent, child;
  std::string leader;  ///< of a joint that follows another, q = offset + multiplier q_leader; empty: none
  double multiplier = 1.0, offset = 0.0;
  Eigen::Isometry3d in_parent = Eigen::Isometry3d::Identity();  ///< the joint's frame, in the parent link
  Eigen::Isometry3d in_child = Eigen::Isometry3d::Identity();   ///< and in the child link
  std::string place;
};

class LinkTree {
 public:
  /// \param unstated  what simulators of the format take for a link without inertial; empty: nothing either
  LinkTree(XmlRobot& xml, std::filesystem::path file, std::string unstated = {})
      : xml_(xml), file_(std::move(file)), unstated_(std::move(unstated)) {}

  /// \throws DataError: the name is taken, or there are too many
  void addLink(const XmlElement& element, const std::string& name, const MassProperties& mass);
  /// \param name  in the file
  void addJoint(LinkJoint joint, const std::string& name);
  /// Where the one link stands that no joint moves; the origin without.
  void placeBase(const std::map<std::string, Eigen::Isometry3d>& where) { where_ = where; }
  /// The arm, with the joints outwards from the base in the order of the file; what is fixed becomes a part.
  /// \throws DataError: no tree, or nothing that moves
  ArmModel build(ArmModel arm);
  const ArmPlaces& places() const { return arm_places_; }
  /// Of a link in the arm that was built: its body, and its frame in that body. Empty: there is none of that name
  std::optional<std::pair<int, Eigen::Isometry3d>> placeOf(const std::string& link) const;

 private:
  [[noreturn]] void fail(const std::string& sentence) const;
  std::string baseLink() const;
  void refuseCircles() const;
  void attachChildren(const std::string& link);
  void nameStillBase(const std::string& base);
  void nameMassless();
  void follow(const LinkJoint& joint);
  void nameAll();

  XmlRobot& xml_;
  std::filesystem::path file_;
  std::string unstated_;
  ArmModel arm_;
  std::map<std::string, MassProperties> links_;
  std::vector<std::string> order_;
  std::map<std::string, std::string> place_of_;  ///< of a link: "robot.urdf:12"
  std::set<std::string> stated_, drawn_;         ///< links with an inertial; with a shape to see or to touch
  ArmPlaces arm_places_;
  std::vector<LinkJoint> joints_;
  std::map<std::string, std::string> body_name_;  ///< of a link: that of a body or part of the arm
  std::map<std::string, Eigen::Isometry3d> where_;
  std::map<std::string, std::pair<int, Eigen::Isometry3d>> places_;  ///< of a link, in a body of the arm
};

}  // namespace simgap
