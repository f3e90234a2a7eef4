/// \file
/// What the CMA-ES module offers. pagmo takes 34 MB and a third of the time of a start; it lives in a module of its own
/// that is loaded when it is asked for.
#pragma once

#include "simgap/optimize/cma_es.h"

namespace simgap {

using CmaEsObjective = std::function<double(const std::vector<double>&)>;
using CmaEsObserver = std::function<bool(const CmaEsGeneration&)>;
/// Evolves the population `start`, shape (population)(unknowns).
using CmaEsEntry = void (*)(const CmaEsObjective& objective, const std::vector<std::vector<double>>& start,
                            const CmaEsOptions& options, const CmaEsObserver& after_generation);

}  // namespace simgap

extern "C" simgap::CmaEsEntry simgapCmaEsModule();
