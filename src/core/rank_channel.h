/// \file
/// What ranks need of a message passing library: implemented by a module, so that the program runs without one.
#pragma once

#include <functional>
#include <optional>
#include <string>

namespace simgap {

struct RankMessage {
  int from = 0;
  std::string bytes;
};

/// One thread at a time.
class RankChannel {
 public:
  virtual ~RankChannel() = default;
  virtual int rank() const = 0;
  virtual int count() const = 0;
  /// Returns at once; the message goes while other calls are made.
  virtual void send(int to, std::string bytes) = 0;
  /// A message to this rank; empty: there is none.
  virtual std::optional<RankMessage> receive() = 0;
  /// Those of rank 0, on all ranks: every rank has to call it. Sleeps while it waits; with a dead rank, for ever.
  /// \param give_up  asked meanwhile \returns nothing when it was given up: this rank can only leave then
  virtual std::optional<std::string> broadcast(std::string bytes, const std::function<bool()>& give_up) = 0;
  /// All ranks have to call it; nothing may follow.
  virtual void end() = 0;
};

}  // namespace simgap

/// \returns the channel of this process, for as long as it lives
extern "C" simgap::RankChannel* simgapMpiModule();
