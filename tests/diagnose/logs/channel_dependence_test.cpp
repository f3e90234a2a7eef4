#include "diagnose/logs/channel_dependence.h"

#include <gtest/gtest.h>

#include <array>

namespace simgap::test {
namespace {

using Eigen::ArrayXd;

TEST(ChannelDependence, ScalesFrictionAndAddsAParabolaToTheEffort) {
  ActuatorRows rows;
  rows.time = ArrayXd::LinSpaced(3, 0.0, 1.0);
  rows.context = {ArrayXd::LinSpaced(3, -1.0, 1.0), ArrayXd::LinSpaced(3, 2.0, 4.0)};
  ActuatorTerms terms;
  terms.dry = ArrayXd::Ones(3);
  terms.viscous = ArrayXd::Constant(3, 2.0);
  const std::array one = {0.5, 0.25, 0.0, -1.0};  // of the first channel: -1, 0, 1
  kChannelDependence.apply(one, rows, terms);
  EXPECT_TRUE(terms.dry.isApprox(ArrayXd{{0.75, 1.0, 1.75}})) << terms.dry.transpose();
  EXPECT_TRUE(terms.viscous.isApprox(ArrayXd{{1.5, 2.0, 3.5}})) << terms.viscous.transpose();
  const std::array product = {0.0, 0.0, 0.0, 1.0};  // of both: -2, 0, 4
  Eigen::ArrayXXd x(3, 2);
  kChannelDependence.fill(product, rows, terms, ArrayXd::Zero(3), x);
  EXPECT_TRUE(x.col(0).isApprox(ArrayXd{{-2.0, 0.0, 4.0}}));
  EXPECT_TRUE(x.col(1).isApprox(ArrayXd{{4.0, 0.0, 16.0}}));
}

TEST(ChannelDependence, FrictionStaysPositive) {
  ActuatorRows rows;
  rows.context = {ArrayXd::Constant(1, 3.0)};
  ActuatorTerms terms;
  terms.dry = terms.viscous = ArrayXd::Ones(1);
  const std::array p = {-0.9, 0.0, 0.0, -1.0};
  kChannelDependence.apply(p, rows, terms);
  EXPECT_DOUBLE_EQ(terms.dry[0], 0.02);
}

}  // namespace
}  // namespace simgap::test
