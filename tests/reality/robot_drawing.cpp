#include <fmt/format.h>

#include <cmath>

#include "reality/robot_draws.h"
#include "reality/robot_rig.h"

namespace simgap::reality {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Translation3d;
using Eigen::Vector3d;

Matrix3d solidInertia(double mass, const Vector3d& edges) {
  const Vector3d s = edges.cwiseAbs2();
  return (mass / 12.0 * Vector3d(s.y() + s.z(), s.x() + s.z(), s.x() + s.y())).asDiagonal();
}

}  // namespace

Robot randomRobot(std::uint64_t seed, int joints, bool tree, bool slides) {
  RobotDraws draws(seed, 1);
  Robot robot;
  for (int k = 0; k < joints; ++k) {
    RobotLink link;
    link.parent = tree && k > 1 ? static_cast<int>(draws.between(0.0, k - 1e-6)) : k - 1;
    const Vector3d way = k == 0 ? Vector3d(0.0, 0.0, 0.2) : draws.inShell(0.15, 0.4);
    link.origin = Translation3d(way) * draws.turn(2.0);
    link.axis = Vector3d::Unit(static_cast<Index>(draws.between(0.0, 2.999)));
    link.slides = slides && k > 0 && draws.between(0.0, 1.0) < 0.25;
    if (link.slides) {
      link.lower = -0.2;
      link.upper = 0.3;
    }
    link.mass = 8.0 * std::pow(0.75, k) * draws.between(0.7, 1.4);
    link.centre = draws.inShell(0.05, 0.2);
    const Matrix3d turn = draws.turn(3.0).toRotationMatrix();
    const double x = draws.between(0.1, 0.3), y = draws.between(0.1, 0.3), z = draws.between(0.1, 0.3);
    link.inertia = turn * solidInertia(link.mass, {x, y, z}) * turn.transpose();
    const double size = link.slides ? 20.0 : 3.0 * std::pow(0.75, k);
    link.rotor = 0.1 * size * draws.between(0.5, 1.5);
    link.coulomb = size * draws.between(0.5, 1.5);
    link.viscous = size * draws.between(0.5, 1.5);
    link.offset = 0.3 * size * draws.between(-1.0, 1.0);
    robot.links.push_back(link);
  }
  return robot;
}

std::string drawnUrdf(const Robot& robot, std::uint64_t draw) {
  RobotDraws draws(draw, 3);
  const double wrong = draw == 0 ? 0.0 : 1.0;
  std::string text = "<robot name=\"robot\">\n<link name=\"base\"/>\n";
  for (std::size_t k = 0; k < robot.links.size(); ++k) {
    const RobotLink& link = robot.links[k];
    const double mass = link.mass * std::exp(0.2 * wrong * draws.normal());
    const Vector3d centre = link.centre + 0.02 * wrong * draws.direction();
    const Matrix3d i = link.inertia * std::exp(0.3 * wrong * draws.normal());
    const Vector3d o = link.origin.translation();
    // Fixed-axis angles roll, pitch, yaw: R = R_z R_y R_x.
    const Matrix3d r = link.origin.linear();
    const double pitch = std::atan2(-r(2, 0), std::hypot(r(0, 0), r(1, 0)));
    const double roll = std::atan2(r(2, 1), r(2, 2)), yaw = std::atan2(r(1, 0), r(0, 0));
    text += fmt::format(
        "<link name=\"link{}\"><inertial><origin xyz=\"{} {} {}\"/><mass value=\"{}\"/>\n"
        "<inertia ixx=\"{}\" iyy=\"{}\" izz=\"{}\" ixy=\"{}\" ixz=\"{}\" iyz=\"{}\"/></inertial></link>\n",
        k + 1, centre.x(), centre.y(), centre.z(), mass, i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2), i(1, 2));
    text += fmt::format(
        "<joint name=\"j{}\" type=\"{}\"><parent link=\"{}\"/><child link=\"link{}\"/>\n"
        "<origin xyz=\"{} {} {}\" rpy=\"{} {} {}\"/><axis xyz=\"{} {} {}\"/>\n"
        "<limit lower=\"{}\" upper=\"{}\" effort=\"1000\" velocity=\"10\"/></joint>\n",
        k + 1, link.slides ? "prismatic" : "revolute",
        link.parent < 0 ? "base" : fmt::format("link{}", link.parent + 1), k + 1, o.x(), o.y(), o.z(), roll, pitch, yaw,
        link.axis.x(), link.axis.y(), link.axis.z(), link.lower, link.upper);
  }
  return text + "</robot>\n";
}

}  // namespace simgap::reality
