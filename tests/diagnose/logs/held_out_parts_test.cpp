// What a cause gains is measured on every block, by models that were chosen without it.
#include "diagnose/logs/held_out_parts.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "prepared_logs.h"

namespace simgap::test {
namespace {

/// A log with a hidden bias, and parts of it that are held out.
class HeldOutPartsTest : public ::testing::Test {
 protected:
  HeldOutPartsTest() {
    parts_.addOthers(log_, {friction::find("classic"), {}, {}}, named_, allPromising(), options_, {});
  }

  /// A main selection of one cause, whether it is there or not.
  Selection mainOf(const char* cause, std::vector<std::string> rivals = {}) const {
    Selection main;
    main.baseline = search_.fit({}, nullptr);
    main.chosen = search_.fit({&actuator_effects::find(cause)}, &main.baseline);
    main.steps = {main.baseline, main.chosen};
    main.ambiguous_with = {std::move(rivals)};
    return main;
  }

  /// Squared errors of the other parts without the cause over those with it.
  std::vector<double> otherRatios(const Selection& main) {
    parts_.take(main);
    std::vector<double> ratios;
    for (std::size_t p = 1; p < parts_.parts().size(); ++p) {
      const HeldOutPart& part = parts_.parts()[p];
      ratios.push_back(part.search->errors(part.without[0], part.heldout).mse() /
                       part.search->errors(part.chosen, part.heldout).mse());
    }
    return ratios;
  }

  std::vector<HypothesisRecord> allPromising() const {
    std::vector<HypothesisRecord> records;
    for (const Hypothesis& h : named_) records.push_back({1, titleOf(*h.effect), {}, {0.1, 0.1, 0.1}, 1.0, {}, {}});
    return records;
  }

  static PreparedLog logWithBias() {
    reality::DriveSecret secret;
    secret.current_bias = 0.5;
    return preparedLog(smallRig(6000), secret);
  }

  const PreparedLog log_ = logWithBias();
  const LogDiagnosisOptions options_;
  const LogSplit split_ = splitLog(log_, options_);
  const LogSearch search_{friction::find("classic"), log_.data, split_.training, options_};
  const std::vector<Hypothesis> named_ = {{&actuator_effects::find("inertia"), {}, {}},
                                          {&actuator_effects::find("current-bias"), {}, {}},
                                          {&actuator_effects::find("bend-friction"), {}, {}}};
  HeldOutParts parts_{search_, split_.heldout, 0};
};

TEST_F(HeldOutPartsTest, HoldOutEveryBlockOnceAndLearnNothingFromIt) {
  parts_.take(mainOf("current-bias"));
  ASSERT_EQ(parts_.parts().size(), 4u);
  std::vector<std::size_t> begins;
  for (const HeldOutPart& part : parts_.parts()) {
    for (const Block& block : part.heldout) {
      begins.push_back(block.begin);
      const auto& training = part.search->training();
      EXPECT_EQ(std::ranges::find(training, block.begin, &Block::begin), training.end());
    }
  }
  std::ranges::sort(begins);
  ASSERT_EQ(begins.size(), log_.blocks.size());
  for (std::size_t b = 0; b < begins.size(); ++b) {
    EXPECT_EQ(begins[b], log_.blocks[b].begin);
    EXPECT_EQ(parts_.blocks()[b].begin, log_.blocks[b].begin);
  }
}

TEST_F(HeldOutPartsTest, ACauseThatIsThereGainsInAllOfThem) {
  for (const double ratio : otherRatios(mainOf("current-bias"))) EXPECT_GT(ratio, 1.5);
}

TEST_F(HeldOutPartsTest, ACauseThatIsNotChosenThereGainsNothing) {
  for (const double ratio : otherRatios(mainOf("bend-friction"))) EXPECT_EQ(ratio, 1.0);
}

TEST_F(HeldOutPartsTest, ARivalThatCannotBeToldApartGainsInItsPlace) {
  for (const double ratio : otherRatios(mainOf("bend-friction", {"current-bias"}))) EXPECT_GT(ratio, 1.5);
}

TEST_F(HeldOutPartsTest, ResidualsOfAllBlocksAreEachItsPartsOwn) {
  parts_.take(mainOf("current-bias"));
  const std::vector<Eigen::VectorXd> all =
      parts_.residuals([](const HeldOutPart& part) { return std::vector<Fitted>{part.chosen}; });
  ASSERT_EQ(all.size(), 1u);
  for (const HeldOutPart& part : parts_.parts()) {
    const Eigen::VectorXd own = residualOf(part.chosen);
    for (const Block& block : part.heldout) {
      const auto begin = static_cast<Eigen::Index>(block.begin), size = static_cast<Eigen::Index>(block.size());
      EXPECT_EQ(all[0].segment(begin, size), own.segment(begin, size));
    }
  }
}

}  // namespace
}  // namespace simgap::test
