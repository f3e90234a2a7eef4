#include "simgap/fit/actuators/friction_comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "simgap/fit/actuators/friction_maps.h"
#include "support/files.h"
#include "support/friction_logs.h"

namespace simgap::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<std::string_view> namesOf(const std::vector<std::string>& asked) {
  std::vector<std::string_view> names;
  for (const FrictionLaw* law : lawsNamed(asked)) names.push_back(law->name);
  return names;
}

/// Of a drive whose friction has a part that no load changes: variant-a has it, classic has not.
FrictionData offsetData(std::uint64_t seed) {
  reality::FrictionTruth truth;
  truth.sliding_offset = 1.5;
  return frictionData(reality::simulateFrictionLog(truth, {.rows = 3000, .seed = seed}));
}

TEST(FrictionComparison, NamesEachLawOnce) {
  EXPECT_THAT(namesOf({"all"}), ElementsAre("classic", "variant-a", "variant-b"));
  EXPECT_THAT(namesOf({"variant-b", "all", "variant-b"}), ElementsAre("variant-b", "classic", "variant-a"));
  EXPECT_EQ(namesOf({"every"}).size(), friction::all().size());
  EXPECT_THAT(errorOf([] { lawsNamed(std::vector<std::string>{"magic"}); }), HasSubstr("magic"));
}

TEST(FrictionComparison, TheLawBehindTheDataWins) {
  const FrictionData data = offsetData(1), other = offsetData(2);
  const std::vector<std::string> names{"classic", "variant-a"};
  const FrictionComparison laws = compareLaws(lawsNamed(names), data, {}, &other, "another log");
  ASSERT_EQ(laws.fits.size(), 2u);
  EXPECT_THAT(laws.left_out, IsEmpty());
  EXPECT_EQ(laws.fits[laws.best].law->name, std::string_view("variant-a"));
  EXPECT_EQ(laws.heldout, "another log");
  for (const FrictionFit& fit : laws.fits) EXPECT_EQ(*fit.mse_heldout, meanSquaredError(fit, other, {}));
  EXPECT_LT(*laws.fits[1].mse_heldout, *laws.fits[0].mse_heldout);
}

TEST(FrictionMaps, CountEveryRowOnceAndAverageItsError) {
  const FrictionData data = offsetData(3);
  const std::vector<std::string> names{"classic"};
  const FrictionFitOptions options;
  const FrictionComparison laws = compareLaws(lawsNamed(names), data, options, nullptr, "");
  const FittedRows rows{data, options, laws};
  const ErrorMap map = errorMap(rows);
  const Eigen::ArrayXd error = (predictEffort(laws.fits[0], data, options, {0, data.rows()}) - rows.measured()).abs();
  double count = 0.0, sum = 0.0;
  for (std::size_t c = 0; c < map.count.size(); ++c) {
    count += map.count[c];
    if (map.count[c] > 0.0) sum += map.count[c] * map.error[0][c];
    EXPECT_EQ(map.count[c] > 0.0, std::isfinite(map.error[0][c]));
  }
  EXPECT_EQ(count, double(data.rows()));
  EXPECT_NEAR(sum, error.sum(), 1e-9 * error.sum());
  const std::vector<TimeSample> samples = timeSamples(rows);
  ASSERT_EQ(samples.size(), 1200u);
  EXPECT_NEAR(std::abs(samples[7].predicted[0] - samples[7].measured), error[samples[7].index], 1e-12);
}

TEST(FrictionMaps, CurvesAreAsFastAsTheRowsAndSymmetric) {
  const FrictionData data = offsetData(4);
  const std::vector<double> velocities = curveVelocities(data);
  EXPECT_DOUBLE_EQ(velocities.front(), -data.velocity.abs().maxCoeff());
  for (std::size_t i = 0; i < velocities.size(); ++i) {
    EXPECT_EQ(velocities[i], -velocities[velocities.size() - 1 - i]);
    if (i > 0) {
      EXPECT_GT(velocities[i], velocities[i - 1]);
    }
  }
  const auto bands = loadBands(Eigen::ArrayXd::LinSpaced(101, 0.0, 100.0));
  ASSERT_EQ(bands.size(), 4u);
  EXPECT_DOUBLE_EQ(bands[0].first, 1.0);  // 5 % of the rows, less 4 % of the range
  EXPECT_DOUBLE_EQ(bands[3].second, 99.0);
  EXPECT_THAT(loadBands(Eigen::ArrayXd::Constant(5, 3.0)), ElementsAre(std::pair(3.0, 3.0)));
}

}  // namespace
}  // namespace simgap::test
