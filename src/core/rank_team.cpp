#include "rank_team.h"

#include <thread>

#include "simgap/core/ranks.h"

namespace simgap {

RankTeam& team() {
  static RankTeam instance;
  return instance;
}

void RankTeam::send(int to, Bytes message) {
  ++messages;
  bytes += message.size();
  channel->send(to, std::move(message));
}

std::optional<RankMessage> RankTeam::receive() {
  std::optional<RankMessage> message = channel->receive();
  if (message) ++messages;
  if (message) bytes += message->bytes.size();
  return message;
}

Bytes RankTeam::broadcast(Bytes given) {
  Bytes all = channel->broadcast(std::move(given));
  ++messages;
  bytes += all.size();
  return all;
}

void RankTeam::stopOthers() {
  for (int other = 1; other < count; ++other) send(other, beginWith(RankWord::kStop));
  ended = true;
}

void RankTeam::callToEnd() {
  broadcast(beginWith(RankCall::kEnd));
  ended = true;
}

void failOnRank(std::string_view sentence, ExitCode code) {
  Bytes bytes = beginWith(RankWord::kFailure);
  pack(bytes, code);
  pack(bytes, sentence);
  team().send(0, std::move(bytes));
  for (Patience patience;; std::this_thread::sleep_for(patience.next())) {
    const auto message = team().receive();
    if (message && message->bytes.front() == static_cast<char>(RankWord::kStop)) goAsOther();
  }
}

void goAsOther() {
  team().ended = true;
  throw RanksEnded();
}

}  // namespace simgap
