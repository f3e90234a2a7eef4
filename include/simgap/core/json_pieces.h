/// \file
/// JSON that does not fit in memory: an object of which a list is made element by element while it is written, and of
/// which no more is read than is wanted.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

#include "simgap/core/run_directory.h"

namespace simgap {

/// The list of an object that stands there empty, "key": [].
struct LongList {
  std::string key;  ///< empty: there is none
  std::size_t size = 0;
  std::function<Json(std::size_t)> element;
};

/// The same text as toText() of the object with the list in it.
class JsonPieces {
 public:
  /// \param list  has to outlive it
  JsonPieces(const Json& object, const LongList& list);
  /// The next piece; empty at the end. It stands until the next call.
  std::string_view next();

 private:
  const LongList& list_;
  std::string before_, behind_, piece_;
  std::size_t done_ = 0;
};

inline constexpr std::size_t kWholeList = static_cast<std::size_t>(-1);
/// By the "format" of a JSON object, how many elements of each list that it holds are wanted.
using MostListed = std::function<std::size_t(std::string_view format)>;
/// readJson without what is beyond them, which takes no memory where "format" stands in front of the list.
Json readJson(const std::filesystem::path& file, const MostListed& most_listed);

}  // namespace simgap
