// Bodies of an arm file: what they weigh, and what lines run over.
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <numbers>

#include "arm_yaml_parts.h"
#include "simgap/model/solids/mesh.h"

namespace simgap::arm_yaml {
namespace {

constexpr double kRound = 4.0 / 3.0 * std::numbers::pi;

double volume(const Part& part) {
  const double r = part.radius;
  switch (part.shape) {
    case Part::Shape::kSphere:
      return kRound * r * r * r;
    case Part::Shape::kBox:
      return part.size.prod();
    case Part::Shape::kEllipsoid:
      return kRound * part.size.prod();
    case Part::Shape::kCapsule:
      return std::numbers::pi * r * r * part.length + kRound * r * r * r;
    case Part::Shape::kInertia:
    case Part::Shape::kCylinder:
      break;
  }
  return std::numbers::pi * r * r * part.length;
}

/// Of a body that can exist: principal moments > 0, each at most the sum of the others.
Eigen::Matrix3d readInertia(const YamlNode& node) {
  const Eigen::Vector3d diagonal = node.vectorQuantity("inertia", "kg_m2");
  Eigen::Vector3d products = Eigen::Vector3d::Zero();  // xy, xz, yz
  if (node.hasQuantity("products", "kg_m2")) products = node.vectorQuantity("products", "kg_m2");
  Eigen::Matrix3d inertia;
  inertia << diagonal.x(), products.x(), products.y(), products.x(), diagonal.y(), products.z(), products.y(),
      products.z(), diagonal.z();
  const Eigen::Vector3d moments = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia).eigenvalues();
  constexpr double kRounding = 1e-6;
  if (!(moments[0] > 0.0) || moments[2] > (1.0 + kRounding) * (moments[0] + moments[1])) {
    node.fail(
        fmt::format("inertia_kg_m2: found principal moments {:.4g}, {:.4g}, {:.4g}, expected each > 0 and none above "
                    "the sum of the "
                    "other two",
                    moments[0], moments[1], moments[2]));
  }
  return inertia;
}

const std::map<std::string, Part::Shape> kShapes = {
    {"sphere", Part::Shape::kSphere},   {"cylinder", Part::Shape::kCylinder},   {"box", Part::Shape::kBox},
    {"capsule", Part::Shape::kCapsule}, {"ellipsoid", Part::Shape::kEllipsoid}, {"inertia", Part::Shape::kInertia}};

void readSize(const YamlNode& node, Part& part) {
  switch (part.shape) {
    case Part::Shape::kBox:
    case Part::Shape::kEllipsoid: {
      const bool box = part.shape == Part::Shape::kBox;
      part.size = node.vectorQuantity(box ? "size" : "semi_axes", "m");
      if ((part.size.array() <= 0.0).any())
        node.fail(box ? "size_m: expected three lengths > 0" : "semi_axes_m: expected three lengths > 0");
      return;
    }
    case Part::Shape::kInertia:
      part.inertia = readInertia(node);
      return;
    case Part::Shape::kSphere:
      part.radius = node.quantity("radius", "m", kPositive);
      return;
    case Part::Shape::kCylinder:
    case Part::Shape::kCapsule:
      part.radius = node.quantity("radius", "m", kPositive);
      part.length = node.quantity("length", "m", kPositive);
      if (const auto axis = node.find("axis")) part.axis = readAxis(*axis);
      return;
  }
}

/// What a solid weighs becomes a stated inertia: the model stands in one file.
void readMeshPart(const YamlNode& node, const MeshReader& read, Part& part) {
  if (!read) {
    node.at("shape").fail("found a mesh, expected its mass and inertia: 'simgap convert FILE NEW.yaml' works them out");
  }
  const std::string file = node.at("file").text();
  Mesh mesh = readMesh(read(file), file);
  const auto scale = node.find("scale");
  for (Eigen::Vector3d& point : mesh.points) point *= scale ? scale->number(kPositive) : 1.0;
  const MeshVolume solid = volumeOf(mesh, file);
  const auto density = node.findQuantity("density", "kg_m3", kPositive);
  if (density && node.hasQuantity("mass", "kg")) node.fail("found both a mass and a density, expected one of them");
  const Eigen::Matrix3d turn = readOrientation(node, "").toRotationMatrix();
  part.shape = Part::Shape::kInertia;
  part.mass = density ? *density * solid.volume : node.quantity("mass", "kg", kPositive);
  part.position = node.vectorQuantity("position", "m") + turn * solid.centre;
  part.inertia = turn * solid.inertia(part.mass) * turn.transpose();
}

Part readPart(const YamlNode& node, std::set<std::string>& names, bool second_version, const MeshReader& mesh) {
  Part part;
  part.name = readName(node, names);
  std::vector<std::string> shapes = {"sphere", "cylinder", "box"};
  if (second_version) shapes.insert(shapes.end(), {"capsule", "ellipsoid", "inertia", "mesh"});
  const std::string shape = node.at("shape").oneOf(shapes);
  if (shape == "mesh") {
    readMeshPart(node, mesh, part);
    return part;
  }
  part.shape = kShapes.at(shape);
  readSize(node, part);
  part.position = node.vectorQuantity("position", "m");
  const bool turns = part.shape == Part::Shape::kBox || part.shape == Part::Shape::kEllipsoid;
  if (second_version && turns) part.orientation = readOrientation(node, "");
  const bool stated = part.shape == Part::Shape::kInertia;
  const auto density = stated ? std::nullopt : node.findQuantity("density", "kg_m3", kPositive);
  if (density && node.hasQuantity("mass", "kg")) node.fail("found both a mass and a density, expected one of them");
  part.mass = density ? *density * volume(part) : node.quantity("mass", "kg", kPositive);
  return part;
}

Surface readSurface(const YamlNode& node, std::set<std::string>& names) {
  Surface surface;
  surface.name = readName(node, names);
  const bool ball = node.at("shape").oneOf({"sphere", "cylinder"}) == "sphere";
  surface.shape = ball ? Surface::Shape::kSphere : Surface::Shape::kCylinder;
  surface.radius = node.quantity("radius", "m", kPositive);
  surface.position = node.vectorQuantity("position", "m");
  if (!ball) surface.axis = readAxis(node.at("axis"));
  return surface;
}

}  // namespace

Body readBodyEntry(const YamlNode& node, std::set<std::string>& names, bool second_version, const MeshReader& mesh) {
  Body body;
  body.name = readName(node, names);
  if (const auto fixed = node.find("fixed")) body.fixed = fixed->boolean();
  std::set<std::string> own_names;
  const auto parts = node.find("parts");
  if (!parts && !body.fixed && !second_version) node.fail("a body that moves needs 'parts' (mass > 0)");
  if (parts) {
    for (const YamlNode& part : parts->items()) body.parts.push_back(readPart(part, own_names, second_version, mesh));
    if (body.parts.empty() && !body.fixed) parts->fail("found no part, expected at least one (mass > 0)");
  }
  if (const auto surfaces = second_version ? node.find("surfaces") : std::nullopt) {
    for (const YamlNode& surface : surfaces->items()) body.surfaces.push_back(readSurface(surface, own_names));
  }
  return body;
}

}  // namespace simgap::arm_yaml
