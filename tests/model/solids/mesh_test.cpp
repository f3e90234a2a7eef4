// Solids by their surfaces, against what a box and a tetrahedron weigh.
#include "simgap/model/solids/mesh.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstdint>

#include "simgap/core/error.h"
#include "simgap/model/arm/arm_yaml.h"
#include "support/files.h"
#include "support/many_kinds.h"

namespace simgap {
namespace {

using testing::HasSubstr;

/// A box of these edges about `at`, its faces quadrilaterals.
std::string boxObj(const Eigen::Vector3d& size, const Eigen::Vector3d& at) {
  std::string text = "# a box\no box\n";
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d corner(i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5);
    const Eigen::Vector3d p = at + corner.cwiseProduct(size);
    text += fmt::format("v {} {} {}\n", p.x(), p.y(), p.z());
  }
  return text + "f 1/1 3/2 4/3 2/4\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf -7 -5 -1 -3\n";
}

/// Triangles of a mesh as STL.
std::string stl(const Mesh& mesh, bool binary) {
  std::string text = binary ? std::string(80, ' ') : "solid s\n";
  const auto raw = [&](const auto& value) { text.append(reinterpret_cast<const char*>(&value), sizeof(value)); };
  if (binary) raw(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& t : mesh.triangles) {
    if (binary) {
      for (int k = 0; k < 3; ++k) raw(0.0f);
    } else {
      text += " facet normal 0 0 0\n  outer loop\n";
    }
    for (const int corner : t) {
      const Eigen::Vector3d& p = mesh.points[corner];
      if (!binary) text += fmt::format("   vertex {} {} {}\n", p.x(), p.y(), p.z());
      for (int k = 0; binary && k < 3; ++k) raw(static_cast<float>(p[k]));
    }
    if (binary) {
      raw(std::uint16_t{0});
    } else {
      text += "  endloop\n endfacet\n";
    }
  }
  return binary ? text : text + "endsolid s\n";
}

void expectBox(const MeshVolume& solid, const Eigen::Vector3d& size, const Eigen::Vector3d& at, double tolerance) {
  EXPECT_NEAR(solid.volume, size.prod(), tolerance * size.prod());
  EXPECT_LT((solid.centre - at).norm(), tolerance);
  const Eigen::Vector3d squares = size.cwiseAbs2();
  const Eigen::Vector3d expected(squares.y() + squares.z(), squares.x() + squares.z(), squares.x() + squares.y());
  const Eigen::Matrix3d inertia = solid.inertia(3.0);
  EXPECT_LT((inertia - Eigen::Matrix3d(Eigen::Vector3d(3.0 / 12.0 * expected).asDiagonal())).norm(),
            tolerance * expected.norm());
}

TEST(Mesh, ABoxWeighsWhatABoxDoesInEveryFormat) {
  const Eigen::Vector3d size(0.25, 0.5, 0.125), at(0.75, -0.5, 3.0);  // corners that floats hold
  const Mesh box = readMesh(boxObj(size, at), "box.obj");
  EXPECT_EQ(box.points.size(), 8u);
  EXPECT_EQ(box.triangles.size(), 12u);
  expectBox(volumeOf(box, "box.obj"), size, at, 1e-12);
  for (const bool binary : {false, true}) {
    const Mesh again = readMesh(stl(box, binary), "box.STL");
    EXPECT_EQ(again.points.size(), 8u);
    expectBox(volumeOf(again, "box.STL"), size, at, 1e-12);
  }
  Mesh inwards = box;
  for (auto& triangle : inwards.triangles) std::swap(triangle[0], triangle[1]);
  expectBox(volumeOf(inwards, "box.obj"), size, at, 1e-12);
}

TEST(Mesh, ATetrahedronsMomentsAreThoseOfItsIntegral) {
  const Mesh mesh = readMesh("v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", "t.obj");
  const MeshVolume solid = volumeOf(mesh, "t.obj");
  EXPECT_NEAR(solid.volume, 1.0, 1e-14);
  EXPECT_LT((solid.centre - Eigen::Vector3d(0.25, 0.5, 0.75)).norm(), 1e-14);
  // Integral of x^2 over x + y/2 + z/3 < 1 is 1/10, of x y 1/10: less the centre's squares.
  EXPECT_NEAR(solid.second(0, 0), 0.1 - 0.0625, 1e-14);
  EXPECT_NEAR(solid.second(1, 1), 0.4 - 0.25, 1e-14);
  EXPECT_NEAR(solid.second(0, 1), 0.1 - 0.125, 1e-14);
}

TEST(Mesh, WhatIsNoSolidIsRefused) {
  const std::string box = boxObj({1, 1, 1}, {0, 0, 0});
  const auto error = [](const std::string& text, const std::string& name = "m.obj") {
    return test::errorOf([&] { volumeOf(readMesh(text, name), name); });
  };
  EXPECT_THAT(error(test::replaced(box, "f 5 6 8 7\n", "")), HasSubstr("m.obj: found an edge of one triangle alone"));
  EXPECT_THAT(error(test::replaced(box, "f 5 6 8 7\n", "f 5 7 8 6\n")), HasSubstr("face different ways"));
  EXPECT_THAT(error(test::replaced(box, "f 5 6 8 7", "f 5 6 9 7")), HasSubstr("m.obj:12: found no corner '9'"));
  EXPECT_THAT(error("v 0 0\n"), HasSubstr("m.obj:1: found a corner that is not three numbers"));
  EXPECT_THAT(error("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 3 2\n"), HasSubstr("encloses no volume"));
  EXPECT_THAT(error("solid nothing\nendsolid\n", "m.stl"), HasSubstr("found no triangle"));
  EXPECT_THAT(error(box, "m.ply"), HasSubstr("found the ending '.ply', expected .stl or .obj"));
}

TEST(Mesh, APartOfABodyBecomesAStatedInertia) {
  const std::string capsule =
      "{name: tube, shape: capsule, radius_m: 0.01, length_m: 0.1, mass_kg: 0.25, position_m: [0, 0, -0.08], axis: [0, "
      "0, 1]}";
  const std::string shell =
      "{name: tube, shape: mesh, file: tube.obj, scale: 0.001, density_kg_m3: 2000, position_m: [0, 0, -0.1], "
      "orientation: [0.5, 0.5, 0.5, 0.5]}";
  const YamlNode root = YamlNode::parse(test::replaced(test::kManyKinds, capsule, shell), "arm.yaml");
  std::string asked;
  const ArmModel model = readArm(root, [&](const std::string& file) {
    asked = file;
    return boxObj({20, 30, 100}, {0, 0, 10});
  });
  EXPECT_EQ(asked, "tube.obj");
  const Part& part = model.bodies[2].parts[0];
  EXPECT_EQ(part.shape, Part::Shape::kInertia);
  EXPECT_NEAR(part.mass, 2000.0 * 6e-5, 1e-12);
  // x becomes y, y becomes z, z becomes x.
  EXPECT_LT((part.position - Eigen::Vector3d(0.01, 0.0, -0.1)).norm(), 1e-12);
  EXPECT_NEAR(part.inertia(0, 0), part.mass / 12.0 * (0.02 * 0.02 + 0.03 * 0.03), 1e-12);
  EXPECT_NEAR(part.inertia(1, 1), part.mass / 12.0 * (0.03 * 0.03 + 0.1 * 0.1), 1e-12);
  EXPECT_THAT(
      test::errorOf([&] { readArm(YamlNode::parse(test::replaced(test::kManyKinds, capsule, shell), "a.yaml")); }),
      HasSubstr("'simgap convert FILE NEW.yaml' works them out"));
}

}  // namespace
}  // namespace simgap
