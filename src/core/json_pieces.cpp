#include "simgap/core/json_pieces.h"

#include <cassert>
#include <utility>

namespace simgap {

JsonPieces::JsonPieces(const Json& object, const LongList& list) : list_(list), before_(toText(object)) {
  if (list_.size == 0) return;
  const std::string empty = "\n  " + Json(list_.key).dump() + ": [";  // two spaces: of the object itself
  const std::size_t place = before_.find(empty + "]");
  assert(place != std::string::npos);
  behind_ = "\n  " + before_.substr(place + empty.size());
  before_.resize(place + empty.size());
}

std::string_view JsonPieces::next() {
  constexpr std::size_t kEnough = 1 << 16;
  piece_ = std::exchange(before_, {});
  while (done_ < list_.size && piece_.size() < kEnough) {
    if (done_ > 0) piece_ += ',';
    std::string element = "\n" + toText(list_.element(done_++));
    element.pop_back();  // its final newline
    for (const char character : element) {
      piece_ += character;
      if (character == '\n') piece_ += "    ";
    }
  }
  if (piece_.size() < kEnough) piece_ += std::exchange(behind_, {});
  return piece_;
}

}  // namespace simgap
