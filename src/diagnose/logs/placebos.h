/// \file
/// Placebos of a cause: its own signature with the phases of its spectrum drawn anew. Such a signature has the cause's
/// colour and size but belongs to no motion, so that nothing it explains can be the cause's doing. What a slow or
/// repetitive residual lets placebos explain, a cause has to beat.
#pragma once

#include <string>

#include "log_hypotheses.h"

namespace simgap {

struct PlaceboTest {
  double gain = 0.0;     ///< of the squared error that the cause's own signature explains, to first order
  double largest = 0.0;  ///< the same of the best placebo
  double p = 1.0;        ///< (1 + placebos that reach it) / (1 + placebos)
};

/// \param full  model with the effect, \param rest  the model without it, both fitted to the training blocks.
/// \param effect  index of it in `full`. A pure function of its arguments.
PlaceboTest testPlacebos(const LogSearch& search, const Fitted& full, const Fitted& rest, std::size_t effect,
                         std::uint64_t seed);

/// Why a delay is one of the noise and not of the motion; empty when it is none of the noise, and for effects that
/// delay nothing. A controller that feeds a noisy velocity back writes that noise into its effort with the opposite
/// sign: a model that reads the velocity a row too early or too late does not meet it again, and fits better though
/// nothing is late. So does a shift by a part of a row, which averages two rows. Neither is left once the errors of
/// neighbouring rows are averaged, while a true delay stays; and the opposite delay is as good. Arguments as of
/// testPlacebos.
std::string doubtOfDelay(const LogSearch& search, const Fitted& full, const Fitted& rest, std::size_t effect);

}  // namespace simgap
