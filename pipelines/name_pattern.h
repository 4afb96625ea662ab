#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace micro {

/// Where names say that scans lie: a text with `{row}`, `{col}` or both, as in r{row}_c{col}.
class NamePattern {
 public:
  struct Place {
    Eigen::Index row, col;  ///< 0 for what the pattern does not ask for
  };

  /// \throws InputError for a pattern that asks for no number, for one number twice, or for a number whose
  /// end its
  ///         next character does not show (another number, or a digit).
  explicit NamePattern(const std::string& pattern);

  /// The numbers where the pattern first occurs in a name; nothing if it does not.
  /// \throws InputError for a number that no index holds.
  std::optional<Place> find(const std::string& name) const;

 private:
  enum class Number { kRow, kCol };
  struct Piece {
    std::string before;  // what stands before the number
    Number number;
  };

  std::optional<Place> match(const std::string& name, std::size_t start) const;

  std::vector<Piece> pieces_;
  std::string after_;  // what stands after the last number
};

}  // namespace micro
