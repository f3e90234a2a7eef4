/// \file
/// Ctrl-C (SIGINT) and SIGTERM set a flag that long work looks at; another one after that ends the program at once.
#pragma once

namespace simgap {

/// Installs the handlers; call once from main.
void installInterruptHandlers();

/// True once the user has asked to stop. Safe from any thread.
bool interruptRequested() noexcept;

/// As a signal would, where another process brings the wish.
void requestInterrupt() noexcept;

/// The wish to stop was followed, as it ends a recording, and what was gathered is now to be written whole; another one
/// stops that, too.
void interruptAnswered() noexcept;

/// For work that cannot be taken up again. \throws InterruptedError once the user has asked to stop
void stopIfInterrupted();

/// Until a pipe or a terminal has something to read, or has ended. \throws InterruptedError as stopIfInterrupted
void waitForBytes(int descriptor);

}  // namespace simgap
