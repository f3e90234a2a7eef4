/// \file
/// Remarks without a place in a file, each once.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "simgap/exchange/exchange.h"

namespace simgap {

class RemarkList {
 public:
  void add(const std::string& what, const std::string& done, bool matters = true) {
    const auto same = [&](const ExchangeRemark& r) { return r.what == what && r.done == done; };
    if (std::ranges::find_if(remarks_, same) == remarks_.end()) remarks_.push_back({what, done, matters, {}});
  }
  /// What changes rest or motion first.
  std::vector<ExchangeRemark> take() {
    std::ranges::stable_sort(remarks_, {}, [](const ExchangeRemark& remark) { return !remark.matters; });
    return std::move(remarks_);
  }

 private:
  std::vector<ExchangeRemark> remarks_;
};

}  // namespace simgap
