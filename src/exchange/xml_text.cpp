#include "xml_text.h"

#include <fmt/format.h>

#include "arm_exchange.h"
#include "simgap/core/rotation.h"

namespace simgap {
namespace {

std::string quaternion(const Eigen::Quaterniond& q) {
  return fmt::format(" quat=\"{} {} {} {}\"", q.w(), q.x(), q.y(), q.z());
}

}  // namespace

std::string xmlText(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return escaped;
}

std::string xmlNumbers(const Eigen::Vector3d& v) { return fmt::format("{} {} {}", v.x(), v.y(), v.z()); }

std::string mjcfFrame(const Eigen::Isometry3d& frame) {
  const Eigen::Quaterniond q = tidyRotation(frame.linear());
  return fmt::format(" pos=\"{}\"{}", xmlNumbers(frame.translation()), q.w() == 1.0 ? "" : quaternion(q));
}

std::string alongZ(const Eigen::Vector3d& axis) {
  if (axis == Eigen::Vector3d::UnitZ()) return "";
  return quaternion(rotationBetween(Eigen::Vector3d::UnitZ(), axis));
}

std::string mjcfGeom(const Part& part, const std::string& indent) {
  std::string shape;
  switch (part.shape) {
    case Part::Shape::kSphere:
      shape = fmt::format("type=\"sphere\" size=\"{}\"", part.radius);
      break;
    case Part::Shape::kBox:
      shape = fmt::format("type=\"box\" size=\"{}\"{}", xmlNumbers(0.5 * part.size), quaternion(part.orientation));
      break;
    case Part::Shape::kEllipsoid:
      shape = fmt::format("type=\"ellipsoid\" size=\"{}\"{}", xmlNumbers(part.size), quaternion(part.orientation));
      break;
    case Part::Shape::kCylinder:
    case Part::Shape::kCapsule:
      shape = fmt::format("type=\"{}\" size=\"{} {}\"{}", part.shape == Part::Shape::kCapsule ? "capsule" : "cylinder",
                          part.radius, 0.5 * part.length, alongZ(part.axis));
      break;
    case Part::Shape::kInertia:
      return "";
  }
  return fmt::format("{}<geom {} pos=\"{}\" contype=\"0\" conaffinity=\"0\" mass=\"0\"/>\n", indent, shape,
                     xmlNumbers(part.position));
}

}  // namespace simgap
