#include "friction_signs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "opposite_sign.h"
#include "simgap/core/units.h"
#include "simgap/optimize/least_squares.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Places of the columns; the last are the offset and the effort.
struct Places {
  explicit Places(const FrictionData& data) : loads(1 + data.load_per.cols()) {}
  Index loads;                           ///< the known load, then the rig's
  static constexpr Index kFriction = 3;  ///< |load| sign(w), sign(w), w
  Index offset() const { return loads + kFriction; }
  Index effort() const { return offset() + 1; }
  Index count() const { return effort() + 1; }
};

/// Sums of products of all columns, shape (count, count).
MatrixXd productSums(const FrictionData& data, const Places& places) {
  MatrixXd sums = MatrixXd::Zero(places.count(), places.count());
  for (const Block& rows : evenChunks(data.rows())) {
    const Index begin = rows.begin, n = rows.size();
    MatrixXd x(n, places.count());
    const auto load = data.load.segment(begin, n), direction = data.direction.segment(begin, n);
    x.col(0) = load;
    for (Index k = 1; k < places.loads; ++k) x.col(k) = data.load_per.col(k - 1).segment(begin, n);
    x.col(places.loads) = load.abs() * direction;
    x.col(places.loads + 1) = direction;
    x.col(places.loads + 2) = data.velocity.segment(begin, n);
    x.col(places.offset()).setOnes();
    x.col(places.effort()) = data.effort.segment(begin, n);
    sums.noalias() += x.transpose() * x;
  }
  return sums;
}

}  // namespace

std::string oppositeSign(const FrictionData& data) {
  const Places places(data);
  const MatrixXd sums = productSums(data, places);
  std::vector<LinearTerm> terms(static_cast<std::size_t>(places.effort()));
  terms.back().lower = -std::numeric_limits<double>::infinity();
  const auto costWith = [&](Index first, Index count) {
    VectorXd sign = VectorXd::Ones(places.count());
    sign.segment(first, count).setConstant(-1.0);
    return costTurned(sums, sign, terms);
  };
  const bool derived = std::ranges::find(data.derived, "velocity") != data.derived.end();
  const std::string motion =
      derived ? quantityName("motor_position", data.angle_unit) : quantityName("motor_velocity", data.velocity_unit);
  struct Turned {
    std::string channel;
    double cost;
  };
  std::vector<Turned> turned = {
      {quantityName(data.effort_name, data.effort_unit), costWith(places.effort(), 1)},
      {quantityName(data.load_unit == "N" ? "external_force" : "external_torque", data.load_unit),
       costWith(0, places.loads)}};
  if (goesBothWays(data.direction)) turned.push_back({motion, costWith(places.loads, Places::kFriction)});
  const Turned& best = *std::ranges::min_element(turned, {}, &Turned::cost);
  const double as_it_is = costWith(0, 0);
  if (!(best.cost < kOtherSign * as_it_is)) return {};
  const auto rms = [&](double cost) { return std::sqrt(std::max(cost, 0.0) / static_cast<double>(data.rows())); };
  return fmt::format(
      "{} has the opposite sign: turned round, load and friction explain the effort to {:.3g} {}, as it is to {:.3g}; "
      "{}",
      best.channel, rms(best.cost), data.effort_unit, rms(as_it_is), turnItRound(best.channel));
}

}  // namespace simgap
