#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "distribution/disk_table.h"
#include "distribution/sparse_table.h"
#include "height/height_field.h"
#include "pipelines/kirchhoff_estimate.h"

namespace micro {

/// The naive geometric NDF, from triangles.
struct Naive {};

/// The filtered geometric NDF [Dong15 §5.1].
struct Filtered {
  double sigma = 1;  ///< µm
};

/// One table to compute, and the name of its group under /ndf.
struct NdfMethod {
  std::string name;  ///< "naive", "filtered", "filtered_2um", "kirchhoff"
  std::variant<Naive, Filtered, Kirchhoff> kind;
};

/// The name of a filtered NDF beside others: with its σ (µm), "filtered_2um". The only or first one is
/// "filtered".
std::string filtered_name(double sigma);

/// One method's outcome on one scan.
struct ScanNdf {
  std::variant<DiskTable, SparseTable> density;  ///< sparse where it is a histogram
  std::int64_t samples = 0, outside = 0, without_normal = 0;
  std::optional<double> truncation_error;
  std::optional<KirchhoffEstimate> kirchhoff;  ///< without its density
  double seconds = 0;
};

/// One method on one grid, ready for any number of scans, from several threads at once.
class NdfEstimator {
 public:
  /// `spared`: for D_K, the larger table that the grid is a part of.
  NdfEstimator(const NdfMethod& method, const DiskGrid& grid, std::optional<DiskGrid> spared = {});
  ~NdfEstimator();
  NdfEstimator(NdfEstimator&&) noexcept;

  const NdfMethod& method() const { return method_; }
  const DiskGrid& grid() const { return grid_; }

  /// Throws InputError, with the reason, where the method does not apply to the surface.
  ScanNdf operator()(const HeightField& surface) const;

 private:
  ScanNdf compute(const Naive& naive, const HeightField& surface) const;
  ScanNdf compute(const Filtered& filtered, const HeightField& surface) const;
  ScanNdf compute(const Kirchhoff& kirchhoff, const HeightField& surface) const;

  NdfMethod method_;
  DiskGrid grid_;
  std::unique_ptr<KirchhoffScans> kirchhoff_;  // of D_K, else null
};

}  // namespace micro
