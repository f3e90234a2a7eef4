// Muscles in SDF, which has none of its own: CARDSflow (Roboy) states them in its Gazebo plugin,
//
//   <plugin …><myoMuscle name="m"><link name="humerus"><viaPoint type="FIXPOINT">0.1 0 0</viaPoint> … </link> …
//
// Points stand in the frames of their links, in the order in which the line runs.
#include <fmt/format.h>

#include <utility>

#include "sdf_muscles.h"
#include "simgap/core/text.h"
#include "simgap/model/arm/kinematics.h"
#include "simgap/model/arm/tendon_path.h"

namespace simgap {
namespace {

class SdfMuscles {
 public:
  SdfMuscles(const LinkTree& tree, XmlRobot& xml, ArmModel& arm) : tree_(tree), xml_(xml), arm_(arm) {}

  void read(const XmlElement& plugin) {
    xml_.understand(plugin);
    for (const char* said : {"name", "filename"}) xml_.find(plugin, said);
    for (const auto* e = plugin.FirstChildElement("myoMuscle"); e; e = e->NextSiblingElement("myoMuscle")) {
      readMuscle(*e);
    }
  }

  void giveMusclesNames() {
    std::vector<NameWish> wishes;
    for (std::size_t m = 0; m < places_.size(); ++m) {
      std::string& name = arm_.muscles[m].name;
      wishes.push_back({&name, "muscle", std::exchange(name, {}), places_[m], "muscle"});
    }
    std::set<std::string> taken;
    giveNames(wishes, taken, xml_);
  }

 private:
  void readMuscle(const XmlElement& element) {
    xml_.understand(element);
    const std::string name = xml_.required(element, "name");
    std::vector<Attachment> points;
    for (const auto* link = element.FirstChildElement("link"); link; link = link->NextSiblingElement("link")) {
      addPoints(*link, points);
    }
    if (points.size() < 2) xml_.fail(element, fmt::format("found {} points of a line, expected two", points.size()));
    TendonPath path;
    path.attachments = {points.front(), points.back()};
    for (std::size_t k = 1; k + 1 < points.size(); ++k) path.between.emplace_back().at = points[k];
    const std::vector<JointPosition> drawn(arm_.joints.size());
    addPlaceholderMuscle(arm_, path, name, tendonLength(arm_, path, bodiesInWorld(arm_, drawn), drawn));
    places_.push_back(xml_.place(element));
    xml_.add("myoMuscle", std::string(kPlaceholders), true, places_.back());
  }

  void addPoints(const XmlElement& link, std::vector<Attachment>& points) {
    xml_.understand(link);
    const std::string name = xml_.required(link, "name");
    const auto place = tree_.placeOf(name);
    if (!place) xml_.fail(link, fmt::format("name: found '{}', expected the name of a link", abridged(name)));
    for (const auto* e = link.FirstChildElement("viaPoint"); e; e = e->NextSiblingElement("viaPoint")) {
      const std::string type = xml_.required(*e, "type");
      if (type != "FIXPOINT") {
        xml_.remark(*e, fmt::format("viaPoint of type {}", abridged(type)), "left out: the line runs past it");
        continue;
      }
      xml_.understand(*e);
      const char* const text = e->GetText();
      points.push_back({place->first, place->second * xml_.vector3(*e, "point", text == nullptr ? "" : text)});
    }
  }

  const LinkTree& tree_;
  XmlRobot& xml_;
  ArmModel& arm_;
  std::vector<std::string> places_;  ///< in the file, shape (muscles)
};

}  // namespace

void readSdfMuscles(const XmlElement& model, const LinkTree& tree, XmlRobot& xml, ArmModel& arm) {
  SdfMuscles muscles(tree, xml, arm);
  for (const auto* e = model.FirstChildElement("plugin"); e; e = e->NextSiblingElement("plugin")) {
    if (e->FirstChildElement("myoMuscle") != nullptr) muscles.read(*e);
  }
  muscles.giveMusclesNames();
}

}  // namespace simgap
