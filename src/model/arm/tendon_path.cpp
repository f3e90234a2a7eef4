/// A line bent by a circle of radius R (000 eq. 7 in the plane). It leaves an end d_a along the unit vector e_a,
/// touches the circle after l_a = sqrt(|d_a|^2 - R^2) at R rho_a, and follows it by the angle psi:
///
///   P = l_0 + l_1 + R psi,   dP/dd_a = e_a,   d2P/dd_a dd_b = [a = b] n_a n_a^T / l_a,   dP/dR = psi,
///   de_a/dR = -rho_a / l_a,
///
/// with n_a across e_a: an end that moves along n_a turns its tangent about the point of contact, and what the circle
/// gains on one side it gives to the free line.
#include "simgap/model/arm/tendon_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace simgap {
namespace {

constexpr double kSmallestSine = 1e-6;

using Eigen::Vector2d;

struct CircleWay {
  std::array<Vector2d, 2> touch, along;
  std::array<double, 2> free;
  double angle;
  bool clockwise;
};

double turn(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Whether the segments from a to b and from c to d meet.
bool meet(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  const double determinant = turn(b - a, d - c);
  if (std::abs(determinant) < 1e-15) return false;
  const double s = turn(c - a, d - c) / determinant, t = turn(c - a, b - a) / determinant;
  return s >= 0.0 && s <= 1.0 && t >= 0.0 && t <= 1.0;
}

/// Where the tangents from both ends touch, for a line that runs round clockwise or the other way.
std::array<Vector2d, 2> tangents(const std::array<Vector2d, 2>& d, double radius, bool clockwise) {
  std::array<Vector2d, 2> touch;
  for (int a = 0; a < 2; ++a) {
    const double square = d[a].squaredNorm();
    const double free = std::sqrt(square - radius * radius);
    const double sense = clockwise == (a == 0) ? 1.0 : -1.0;
    touch[a] = (radius * radius * d[a] + sense * radius * free * Vector2d(d[a].y(), -d[a].x())) / square;
  }
  return touch;
}

/// \param side  unit vector; null: the shorter way  \returns false where the line is straight
bool roundCircle(const std::array<Vector2d, 2>& d, double radius, const Vector2d* side, CircleWay& way) {
  const double square = radius * radius * (1.0 + 1e-12);
  const Vector2d line = d[1] - d[0];
  if (d[0].squaredNorm() <= square || d[1].squaredNorm() <= square || line.squaredNorm() < 1e-15) return false;
  const Vector2d nearest = d[0] + std::clamp(-line.dot(d[0]) / line.squaredNorm(), 0.0, 1.0) * line;
  if (nearest.squaredNorm() >= radius * radius && (!side || side->dot(nearest) >= 0.0)) return false;
  double best = -std::numeric_limits<double>::infinity();
  for (const bool clockwise : {true, false}) {
    const std::array<Vector2d, 2> touch = tangents(d, radius, clockwise);
    if (meet(d[0], touch[0], d[1], touch[1])) continue;
    const double good = side ? side->dot((touch[0] + touch[1]).normalized()) : -(touch[0] - touch[1]).squaredNorm();
    if (good <= best) continue;
    best = good;
    way.touch = touch;
    way.clockwise = clockwise;
  }
  if (std::isinf(best)) return false;
  way.angle = std::atan2(turn(way.touch[0], way.touch[1]), way.touch[0].dot(way.touch[1]));
  if (way.clockwise) way.angle = -way.angle;
  if (way.angle < -1e-9) way.angle += 2.0 * std::numbers::pi;
  for (int a = 0; a < 2; ++a) {
    way.free[a] = std::max(kShortestLine, (d[a] - way.touch[a]).norm());
    way.along[a] = (d[a] - way.touch[a]) / way.free[a];
  }
  return true;
}

/// A plane in space.
struct Plane {
  Eigen::Vector3d x, y, normal;
  Eigen::Vector3d operator*(const Vector2d& v) const { return v.x() * x + v.y() * y; }
  Vector2d in(const Eigen::Vector3d& v) const { return {x.dot(v), y.dot(v)}; }
};

Plane planeOf(const PlacedSurface& surface, const Eigen::Vector3d& p0, const Eigen::Vector3d& p1) {
  if (surface.shape == Surface::Shape::kCylinder) {
    const Eigen::Vector3d x = surface.axis.unitOrthogonal();
    return {x, surface.axis.cross(x), surface.axis};
  }
  const Eigen::Vector3d x = p0.normalized();
  const Eigen::Vector3d normal = p0.cross(p1);
  const double size = normal.norm();
  const Eigen::Vector3d unit = size > 1e-15 ? Eigen::Vector3d(normal / size) : x.unitOrthogonal();
  return {x, unit.cross(x), unit};
}

void planarDerivatives(const CircleWay& way, const Plane& plane, double radius, Stretch& s) {
  s.length = way.free[0] + way.free[1] + radius * way.angle;
  s.by_radius = way.angle;
  for (int a = 0; a < 2; ++a) {
    s.slope[a] = plane * way.along[a];
    const Eigen::Vector3d across = plane.normal.cross(s.slope[a]);
    s.curvature[a][a] = across * across.transpose() / way.free[a];
    s.curvature[a][1 - a].setZero();
    s.touch[a] = plane * way.touch[a];
    s.slope_by_radius[a] = s.touch[a] / (-radius * way.free[a]);
  }
}

/// Ends that leave the plane by z_a turn it: with theta between them as seen from the centre,
///   d theta = (cot theta (p^2 + q^2) / 2 - p q / sin theta),   p = z_0 / |d_0|, q = z_1 / |d_1|.
void addTurnOfPlane(const CircleWay& way, const Plane& plane, const std::array<Eigen::Vector3d, 2>& p, double radius,
                    Stretch& s) {
  const double a = p[0].norm(), b = p[1].norm();
  const double sine = std::max(kSmallestSine, p[0].cross(p[1]).norm() / (a * b));
  const double r = way.clockwise ? -radius : radius;  // anticlockwise is the way by theta, clockwise by 2 pi - theta
  const Eigen::Matrix3d out = plane.normal * plane.normal.transpose();
  const double cotangent = p[0].dot(p[1]) / (a * b * sine);
  s.curvature[0][0] += (way.free[0] + r * cotangent) / (a * a) * out;
  s.curvature[1][1] += (way.free[1] + r * cotangent) / (b * b) * out;
  s.curvature[0][1] = s.curvature[1][0] = -r / (a * b * sine) * out;
}

/// A helix: L = sqrt(P^2 + h^2), h the way along the axis, spread over P in proportion.
void addHeight(const CircleWay& way, const Eigen::Vector3d& axis, const std::array<double, 2>& z, Stretch& s) {
  const double flat = s.length, h = z[1] - z[0];
  const std::array<Eigen::Vector3d, 2> g = s.slope, by_h = {Eigen::Vector3d(-axis), axis};
  s.length = std::hypot(flat, h);
  for (int a = 0; a < 2; ++a) s.slope[a] = (flat * g[a] + h * by_h[a]) / s.length;
  for (int a = 0; a < 2; ++a) {
    for (int b = 0; b < 2; ++b) {
      s.curvature[a][b] = (g[a] * g[b].transpose() + flat * s.curvature[a][b] + by_h[a] * by_h[b].transpose() -
                           s.slope[a] * s.slope[b].transpose())
                              .eval() /
                          s.length;
    }
  }
  const double by_radius = flat / s.length * s.by_radius;
  for (int a = 0; a < 2; ++a) {
    s.slope_by_radius[a] =
        (s.by_radius * g[a] + flat * s.slope_by_radius[a] - by_radius * s.slope[a]).eval() / s.length;
    s.touch[a] += (z[a] + (a == 0 ? h : -h) * way.free[a] / flat) * axis;
  }
  s.by_radius = by_radius;
}

}  // namespace

void straightStretch(const Eigen::Vector3d& x0, const Eigen::Vector3d& x1, Stretch& s) {
  s.wrapped = false;
  s.length = std::max((x1 - x0).norm(), kShortestLine);
  s.slope[1] = (x1 - x0) / s.length;
  s.slope[0] = -s.slope[1];
  s.curvature[0][0] = (Eigen::Matrix3d::Identity() - s.slope[1] * s.slope[1].transpose()) / s.length;
  s.curvature[1][1] = s.curvature[0][0];
  s.curvature[0][1] = s.curvature[1][0] = -s.curvature[0][0];
}

void wrappedStretch(const PlacedSurface& surface, const Eigen::Vector3d& x0, const Eigen::Vector3d& x1,
                    const Eigen::Vector3d* side, Stretch& s) {
  const std::array<Eigen::Vector3d, 2> p = {x0 - surface.centre, x1 - surface.centre};
  const Plane plane = planeOf(surface, p[0], p[1]);
  const std::array<Vector2d, 2> d = {plane.in(p[0]), plane.in(p[1])};
  const Vector2d side_in_plane = side ? plane.in(*side - surface.centre).normalized() : Vector2d::Zero();
  CircleWay way;
  if (!roundCircle(d, surface.radius, side ? &side_in_plane : nullptr, way)) return straightStretch(x0, x1, s);
  s.wrapped = true;
  planarDerivatives(way, plane, surface.radius, s);
  if (surface.shape == Surface::Shape::kSphere) {
    addTurnOfPlane(way, plane, p, surface.radius, s);
  } else {
    addHeight(way, surface.axis, {surface.axis.dot(p[0]), surface.axis.dot(p[1])}, s);
  }
  for (Eigen::Vector3d& touch : s.touch) touch += surface.centre;
}

bool jointsChange(const TendonPath& path) {
  const int body = path.attachments[0].body;
  const auto changes = [&](const Station& station) {
    if (station.kind == Station::Kind::kJoint) return station.radius != 0.0;
    return station.kind != Station::Kind::kPulley && station.at.body != body;
  };
  return path.attachments[1].body != body || std::ranges::any_of(path.between, changes);
}

PathParts partsOf(const TendonPath& path) {
  PathParts parts;
  double weight = 1.0;
  Attachment from = path.attachments[0];
  int from_station = 0, over = -1;
  const auto runTo = [&](const Attachment& to, int station) {
    PathStretch stretch{{from_station, station}, {from, to}, weight, over, from.body};
    if (over >= 0) {
      const Station& surface = path.between[static_cast<std::size_t>(over) - 1];
      stretch.body = surface.at.body;
      stretch.surface = surface.surface;
      stretch.sided = surface.sided;
      stretch.side = surface.at.point;
      stretch.side_body = surface.side_body < 0 ? surface.at.body : surface.side_body;
    }
    parts.stretches.push_back(stretch);
    from = to;
    from_station = station;
    over = -1;
  };
  bool begins = false;  // the next point is the first of a branch
  const auto meetPoint = [&](const Attachment& point, int station) {
    if (!begins) return runTo(point, station);
    from = point;
    from_station = station;
    begins = false;
  };
  const int last = static_cast<int>(path.between.size()) + 1;
  for (int k = 1; k < last; ++k) {
    const Station& station = path.between[static_cast<std::size_t>(k) - 1];
    switch (station.kind) {
      case Station::Kind::kPoint:
        meetPoint(station.at, k);
        break;
      case Station::Kind::kSurface:
        over = k;
        break;
      case Station::Kind::kPulley:
        weight = 1.0 / station.divisor;
        begins = true;
        break;
      case Station::Kind::kJoint:
        parts.wheels.push_back({k, station.joint, weight, station.radius});
        break;
    }
  }
  if (!path.jointsOnly()) meetPoint(path.attachments[1], last);
  if (path.wrap) {
    PathStretch& stretch = parts.stretches[path.wrap->stretch];
    stretch.over = 0;
    stretch.body = path.wrap->body;
    stretch.surface = path.wrap->surface;
  }
  return parts;
}

void placeStretch(std::span<const Body> bodies, const PathStretch& part, std::span<const BodyInWorld> placed,
                  Stretch& s) {
  const Eigen::Vector3d x0 = placed[part.ends[0].body] * part.ends[0].point;
  const Eigen::Vector3d x1 = placed[part.ends[1].body] * part.ends[1].point;
  if (part.over < 0) return straightStretch(x0, x1, s);
  const BodyInWorld& body = placed[part.body];
  const Surface& surface = bodies[part.body].surfaces[part.surface];
  const Eigen::Vector3d side = placed[part.side_body] * part.side;
  wrappedStretch({surface.shape, surface.radius, body * surface.position, body.rotation * surface.axis}, x0, x1,
                 part.sided ? &side : nullptr, s);
}

double tendonLength(const ArmModel& model, const TendonPath& path, std::span<const BodyInWorld> bodies,
                    std::span<const JointPosition> joints) {
  const PathParts parts = partsOf(path);
  double length = 0.0;
  Stretch stretch;
  for (const PathStretch& part : parts.stretches) {
    placeStretch(model.bodies, part, bodies, stretch);
    length += part.weight * stretch.length;
  }
  for (const PathWheel& wheel : parts.wheels) length += wheel.weight * wheel.radius * joints[wheel.joint].angle;
  return length;
}

namespace {

/// Points of the arc between where a stretch touches its surface.
void addArc(const PlacedSurface& surface, const Stretch& s, std::vector<Eigen::Vector3d>& points) {
  const Eigen::Vector3d a = s.touch[0] - surface.centre, b = s.touch[1] - surface.centre;
  // It sets out against the slope of the first end, about the normal of that and of the radius.
  const bool ball = surface.shape == Surface::Shape::kSphere;
  const Eigen::Vector3d height = ball ? Eigen::Vector3d::Zero() : Eigen::Vector3d(surface.axis * surface.axis.dot(a));
  const double rise = ball ? 0.0 : surface.axis.dot(b - a);
  const Eigen::Vector3d radial = a - height;
  const Eigen::Vector3d normal =
      ball ? a.cross(-s.slope[0]).normalized()
           : Eigen::Vector3d(std::copysign(1.0, surface.axis.dot(radial.cross(-s.slope[0]))) * surface.axis);
  double angle =
      std::atan2(normal.dot(radial.cross(b)), radial.dot(ball ? b : Eigen::Vector3d(b - normal * normal.dot(b))));
  if (angle < -1e-9) angle += 2.0 * std::numbers::pi;
  for (int k = 0; k < kArcPoints; ++k) {
    const double share = static_cast<double>(k) / (kArcPoints - 1);
    points.push_back(surface.centre + Eigen::AngleAxisd(share * angle, normal) * radial + height +
                     share * rise * surface.axis);
  }
}

}  // namespace

std::vector<std::vector<Eigen::Vector3d>> tendonPoints(const ArmModel& model, const TendonPath& path,
                                                       std::span<const BodyInWorld> bodies) {
  std::vector<std::vector<Eigen::Vector3d>> branches;
  int reached = -1;
  for (const PathStretch& part : partsOf(path).stretches) {
    if (part.station[0] != reached) branches.push_back({bodies[part.ends[0].body] * part.ends[0].point});
    reached = part.station[1];
    Stretch stretch;
    placeStretch(model.bodies, part, bodies, stretch);
    if (stretch.wrapped) {
      const BodyInWorld& body = bodies[part.body];
      const Surface& surface = model.bodies[part.body].surfaces[part.surface];
      addArc({surface.shape, surface.radius, body * surface.position, body.rotation * surface.axis}, stretch,
             branches.back());
    }
    branches.back().push_back(bodies[part.ends[1].body] * part.ends[1].point);
  }
  return branches;
}

}  // namespace simgap
