// A small cause beside a large one that has no name may be a part of that.
#include "diagnose/logs/findings.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "diagnose/logs/prepared_logs.h"

namespace simgap::test {
namespace {

/// The reason for which a bias, a small cause, is no finding beside much bending; empty where it is one.
/// \param rivals  that cannot be told from bending
std::string doubtOfBias(const std::vector<std::string>& rivals) {
  reality::DriveSecret secret;
  secret.current_bias = 0.2;
  secret.capstan = 0.3;
  const PreparedLog log = preparedLog(smallRig(20000), secret);
  const LogDiagnosisOptions options;
  const LogSplit split = splitLog(log, options);
  const LogSearch search(friction::find("classic"), log.data, split.training, options);
  Selection selection;
  selection.baseline = search.fit({}, nullptr);
  search.validate(selection.baseline);
  selection.steps = {selection.baseline};
  const std::vector<Hypothesis> named = {{&actuator_effects::find("bend-friction"), {}, {}},
                                         {&actuator_effects::find("current-bias"), {}, {}}};
  for (const Hypothesis& h : named) {
    selection.steps.push_back(search.tryAll(selection.steps.back(), {h})[0].fitted);
    selection.p_adjusted.push_back(1e-6);
  }
  selection.chosen = selection.steps.back();
  selection.ambiguous_with = {rivals, {}};
  selection.instead.resize(2);
  HeldOutParts parts(search, split.heldout, 0);
  const Findings found = keepFindings(search, log, parts, 0, named, options, selection);
  const auto bias = std::ranges::find(found.candidates, "current-bias", &Candidate::effect);
  return bias == found.candidates.end() ? "" : bias->reason;
}

TEST(SlowFindings, ASmallCauseBesideALargeOneWithANameIsNamed) { EXPECT_EQ(doubtOfBias({}), ""); }

TEST(SlowFindings, ASmallCauseBesideALargeGroupWithoutANameIsACandidate) {
  const std::string doubt = doubtOfBias({"load-nonlinearity", "regime-change", "position-ripple"});
  EXPECT_NE(doubt.find("left without a name"), std::string::npos) << doubt;
}

}  // namespace
}  // namespace simgap::test
