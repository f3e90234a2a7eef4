#include "diagnose/logs/log_hypotheses.h"

#include <gtest/gtest.h>

#include "diagnose/logs/held_out.h"
#include "prepared_logs.h"
#include "simgap/fit/actuators/actuator_model.h"

namespace simgap::test {
namespace {

TEST(LogHypotheses, ACauseIsFoundAgainWhereTheOthersHaveLeftTheirPlacesWithoutIt) {
  reality::DriveSecret secret;
  secret.current_bias = 0.5;
  secret.ripple = 1.0;
  secret.ripple_ratio = 9.0;
  const PreparedLog log = preparedLog(smallRig(6000), secret);
  const LogDiagnosisOptions options;
  const LogSearch search(friction::find("classic"), log.data, splitLog(log, options).training, options);
  const Hypothesis ripple{&actuator_effects::find("position-ripple"), {}, {}};
  const Hypothesis bias{&actuator_effects::find("current-bias"), {}, {}};
  Fitted rest = search.tryAll(search.fit({}, nullptr), {ripple})[0].fitted;
  Fitted whole = search.tryAll(rest, {bias})[0].fitted;
  rest.theta[rest.model->firstParameter(0)] *= 1.5;  // its ratio: no descent leads back from there
  EXPECT_GT(search.tryAll(rest, {bias})[0].fitted.mse, 1.1 * whole.mse);
  EXPECT_LE(search.tryAll(rest, {bias}, &whole)[0].fitted.mse, (1.0 + 1e-6) * whole.mse);
}

}  // namespace
}  // namespace simgap::test
