/// \file
/// The images of a folder in the order of their names.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace simgap {

/// Names that follow one another, "left_0007.png", "left_0008.png", …, take no memory however many there are; of others
/// there is a list.
class ImageNames {
 public:
  /// The files whose names end as images do. As people count: 9.png before 10.png.
  /// \throws DataError: there is none
  explicit ImageNames(const std::filesystem::path& folder);

  std::size_t size() const { return size_; }
  std::string at(std::size_t i) const;
  bool listed() const { return !list_.empty(); }

 private:
  /// A name around the last number in it.
  struct Parts {
    std::string before, digits, behind;
  };
  static std::optional<Parts> partsOf(const std::string& name);
  bool count(const std::filesystem::path& folder);

  std::size_t size_ = 0;
  std::string before_, behind_;
  std::size_t digits_ = 1;  ///< fewest; fewer are filled up with zeros
  unsigned long long first_ = 0;
  std::vector<std::string> list_;  ///< empty: the names follow from the numbers
};

}  // namespace simgap
