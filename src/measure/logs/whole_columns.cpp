#include "whole_columns.h"

namespace simgap {

bool isWhole(const CsvTable& table, const std::string& column) {
  return table.has(column) && (!table.isNumeric(column) || table.badRows(column).empty());
}

WholeColumns::WholeColumns(const CsvTable& table, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const bool numeric = table.isNumeric(name);
    numbers_.push_back(numeric ? table.quantity(name, "") : std::vector<double>());
    texts_.push_back(numeric ? std::vector<std::string>() : table.text(name));
  }
}

void WholeColumns::addTo(CsvWriter& csv, std::size_t row) const {
  for (std::size_t k = 0; k < numbers_.size(); ++k) {
    if (texts_[k].empty()) {
      csv.add(numbers_[k][row]);
    } else {
      csv.add(texts_[k][row]);
    }
  }
}

}  // namespace simgap
