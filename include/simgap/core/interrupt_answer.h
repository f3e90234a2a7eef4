/// \file
/// For work that a wish to stop ends as it should be ended, such as a recording. (Other work: interrupt.h.)
#pragma once

namespace simgap {

/// The wish to stop was followed, and what was gathered is now to be written whole; another one stops that, too.
void interruptAnswered() noexcept;

}  // namespace simgap
