// Trials between ranks.
#include "log_hypotheses.h"

namespace simgap {

void pack(Bytes& bytes, const Trial& trial) {
  pack(bytes, trial.fitted.theta);
  pack(bytes, trial.fitted.mse);
  const GroupErrors& unseen = trial.fitted.validation;
  for (const Eigen::ArrayXd* part : {&unseen.sum, &unseen.rows}) pack(bytes, Eigen::VectorXd(part->matrix()));
  pack(bytes, trial.gain_training);
  pack(bytes, trial.gain.has_value());
  const Interval gain = trial.gain.value_or(Interval{});
  for (const double number : {gain.value, gain.lower95, gain.upper95}) pack(bytes, number);
  pack(bytes, trial.p);
  pack(bytes, trial.p_paired);
  pack(bytes, trial.identifiable);
}

void unpack(BytesReader& from, Trial& trial) {
  unpack(from, trial.fitted.theta);
  unpack(from, trial.fitted.mse);
  GroupErrors& unseen = trial.fitted.validation;
  for (Eigen::ArrayXd* part : {&unseen.sum, &unseen.rows}) {
    Eigen::VectorXd values;
    unpack(from, values);
    *part = values.array();
  }
  unpack(from, trial.gain_training);
  bool known = false;
  Interval gain;
  unpack(from, known);
  for (double* const number : {&gain.value, &gain.lower95, &gain.upper95}) unpack(from, *number);
  if (known) trial.gain = gain;
  unpack(from, trial.p);
  unpack(from, trial.p_paired);
  unpack(from, trial.identifiable);
}

}  // namespace simgap
